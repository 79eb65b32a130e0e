# SPDX-License-Identifier: MIT
"""Parts of a trainer for torch."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import torch
from torch.autograd.function import once_differentiable

from .. import _ffi, _parts
from .._checks import choice
from .._errors import UsageError
from ._memory import Call
from ._tensors import Tensor, array_of, checked, context_of, mark_changed, put, stream_of


class _Similarity(torch.autograd.Function):
    """apply(a, b, padding, with_l1) gives the mean SSIM, and the mean of |a - b| or None."""

    @staticmethod
    def forward(ctx: Any, a: Tensor, b: Tensor, padding: int, with_l1: bool) -> Any:  # type: ignore[override]
        ctx.set_materialize_grads(False)
        ctx.padding = padding
        means, terms = _similarity(a, b, padding, with_l1, a.is_cuda and ctx.needs_input_grad[0])
        ctx.save_for_backward(a, b, terms)
        return means

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, by_ssim: Optional[Tensor], by_l1: Optional[Tensor]) -> Any:
        a, b, terms = ctx.saved_tensors
        if by_ssim is None:
            if by_l1 is None:
                return (None,) * 4
            by_ssim = torch.zeros_like(by_l1)

        def gradient(x: Tensor, y: Tensor, fields: Optional[Tensor]) -> Tensor:
            if fields is None and x.is_cuda:
                fields = _similarity(x, y, ctx.padding, False, True)[1]
            by_x = torch.empty_like(x)
            _run_similarity("qs_similarity_backward", x, y, ctx.padding, by_ssim=by_ssim,
                            by_l1=by_l1, terms=fields, by_a=by_x)
            return by_x

        # Both means are symmetric.
        return (gradient(a, b, terms) if ctx.needs_input_grad[0] else None,
                gradient(b, a, None) if ctx.needs_input_grad[1] else None, None, None)


def _similarity(a: Tensor, b: Tensor, padding: int, with_l1: bool,
                with_terms: bool) -> Tuple[Tuple[Tensor, Optional[Tensor]], Optional[Tensor]]:
    """The two means, and the terms of the derivatives by a."""
    ssim_mean = a.new_empty(())
    l1_mean = a.new_empty(()) if with_l1 else None
    terms = None
    if with_terms:
        terms = a.new_empty((3, a.shape[0], a.shape[1], a.shape[2] * a.shape[3]))
    _run_similarity("qs_similarity", a, b, padding, ssim=ssim_mean, l1=l1_mean, terms=terms)
    return (ssim_mean, l1_mean), terms


def _run_similarity(function: str, a: Tensor, b: Tensor, padding: int,
                    **arrays: Optional[Tensor]) -> None:
    given = _ffi.QsSimilarity(border=padding)
    for name, tensor in dict(arrays, a=a, b=b).items():
        put(given, name, tensor)

    def run() -> None:
        with context_of(None, "ssim", a)._use("ssim") as pointer:
            _ffi.call("ssim", function, pointer, ctypes.byref(given), on_gpu=a.is_cuda)

    if not a.is_cuda:
        run()
        return
    with Call(a.device) as call:
        given.stream, given.temporary = call.stream, call.memory
        run()


def ssim(a: Tensor, b: Tensor, padding: str = "same") -> Tensor:
    """The mean structural similarity of two batches of pictures, with gradients by both.

    a, b: batch x channels x height x width, nominally 0..1, of any strides, float32, or on the CPU
        float64. Half precision is converted.
    padding: "same": every pixel counts, values outside are 0; "valid": 5 pixels at every side do
        not count, and both sides have at least 11 pixels.

    The window has 11 x 11 pixels and sigma 1.5. Returns a tensor of 0 dimensions. On a GPU one
    kernel computes it and one the gradient, and nothing waits. Raises UsageError.
    """
    return _compared(a, b, padding, False)[0]


def ssim_and_l1(a: Tensor, b: Tensor, padding: str = "same") -> Tuple[Tensor, Tensor]:
    """ssim(), and the mean of |a - b| over all pixels, by the same kernels."""
    return _compared(a, b, padding, True)


def _compared(a: Tensor, b: Tensor, padding: str, with_l1: bool) -> Any:
    first = checked(a, "ssim: a")
    second = checked(b, "ssim: b")
    if first.dtype != second.dtype:
        raise UsageError("ssim: b has elements of another type than a")
    if first.device != second.device:
        raise UsageError(f"ssim: b is on the device {second.device}, but a is on {first.device}")
    if first.dim() != 4 or first.numel() == 0:
        raise UsageError(f"ssim: a has the shape {tuple(first.shape)} instead of batch x channels x "
                         "height x width")
    if first.shape != second.shape:
        raise UsageError(f"ssim: b has the shape {tuple(second.shape)} instead of "
                         f"{tuple(first.shape)}")
    return _Similarity.apply(first, second, choice(padding, "ssim: padding", _ffi.PADDINGS),
                             with_l1)


class Step(NamedTuple):
    """A step of Adam of a tensor, without correction of the moments."""

    param: Tensor
    gradient: Tensor
    first: Tensor
    second: Tensor
    rate: float
    betas: Tuple[float, float]
    epsilon: float


def adam(steps: Sequence[Step], visible: Optional[Tensor]) -> None:
    """Takes the steps for the visible rows of float32 tensors on one device, in place."""
    device = steps[0].param.device
    given = (_ffi.QsAdam * len(steps))()
    rows = None
    if visible is not None:
        rows = visible.to(device)
        rows = rows.view(torch.uint8) if rows.dtype == torch.bool else rows
    stream = stream_of(device.index) if device.type == "cuda" else None
    for struct, step in zip(given, steps):
        struct.__init__(rate=step.rate, beta1=step.betas[0], beta2=step.betas[1],
                        epsilon=step.epsilon, stream=stream)
        for name, tensor in (("values", step.param), ("gradients", step.gradient),
                             ("first", step.first), ("second", step.second)):
            if checked(tensor, f"adam: {name}").dtype != torch.float32:
                raise UsageError(f"adam: {name} has elements of type {tensor.dtype} instead of "
                                 "float32")
            put(struct, name, tensor)
        if rows is not None:
            put(struct, "visible", rows)
    with context_of(None, "adam", steps[0].param)._use("adam") as pointer:
        _ffi.call("adam", "qs_adam_all", pointer, given, len(steps), on_gpu=stream is not None)
    for step in steps:
        for changed in (step.param, step.first, step.second):
            mark_changed(changed)


def relocated(opacities: Tensor, scales: Tensor, counts: Any, who: str,
              names: Tuple[str, str]) -> Tuple[Tensor, Tensor]:
    """quadsplat.relocate() of tensors where they are.

    who, names: the caller and its names of the tensors, for messages.
    """
    given = [checked(tensor, f"{who}: {name}").detach()
             for tensor, name in zip((opacities, scales), names)]
    if not given[0].is_cuda:
        made = _parts.relocate(*given, torch.as_tensor(counts).cpu())
        return torch.from_numpy(made[0]), torch.from_numpy(made[1])
    copies = torch.as_tensor(counts, device=given[0].device).reshape(-1)
    if copies.dtype not in (torch.int32, torch.int64):
        copies = copies.to(torch.int64)
    results = torch.empty_like(given[0]), torch.empty_like(given[1])
    _run_on_gpu(who, "qs_relocate", given[0].reshape(-1), given[1], copies,
                results[0].view(-1), results[1])
    return results


def neighbours(points: Tensor) -> Tensor:
    """quadsplat.neighbours() of N x 3 points on a GPU, float32."""
    found = points.new_empty(points.shape[0], dtype=torch.float32)
    _run_on_gpu("neighbours", "qs_neighbours", points.to(torch.float32), found)
    return found


def covariances(rotations: Tensor, scales: Tensor, shape: Tuple[int, ...]) -> Tensor:
    """R diag(s^2) R^T of N quaternions and N x 3 standard deviations on a GPU, N x `shape`: 6 or 3,
    3. Without gradients."""
    who = "covariances"
    made = rotations.new_empty((rotations.shape[0], *shape))
    _run_on_gpu(who, "qs_covariances", rotations, scales, made)
    return made


def add_noise(means: Tensor, rotations: Tensor, log_scales: Tensor, logits: Tensor,
              normals: Tensor, factor: float, slope: float, middle: float) -> None:
    """The noise of MCMC, in place: see QsNoise. float32."""
    noise = _ffi.QsNoise(factor=factor, slope=slope, middle=middle,
                         stream=stream_of(means.get_device()) if means.is_cuda else None)
    for name, tensor in (("means", means), ("rotations", rotations), ("log_scales", log_scales),
                         ("opacity_logits", logits), ("normals", normals)):
        put(noise, name, tensor)
    with context_of(None, "noise", means)._use("noise") as pointer:
        _ffi.call("noise", "qs_noise", pointer, ctypes.byref(noise), on_gpu=means.is_cuda)
    mark_changed(means)


def add_view(gradients: Tensor, radii: Tensor, factors: Tuple[float, float], lengths: Tensor,
             views: Tensor) -> None:
    """Adds a view to the sums of density control, in place: see qs_add_view()."""
    arrays = [array_of(tensor) for tensor in (gradients, radii, lengths, views)]
    first, second, *sums = map(ctypes.byref, arrays)
    _run_in_stream("add_view", "qs_add_view", gradients, first, second, *factors, *sums)
    mark_changed(lengths)
    mark_changed(views)


def _run_on_gpu(who: str, function: str, *tensors: Tensor) -> None:
    """Calls a function of arrays that works in the stream of the context."""
    arrays = [array_of(tensor) for tensor in tensors]
    _run_in_stream(who, function, tensors[0], *map(ctypes.byref, arrays))


def _run_in_stream(who: str, function: str, tensor: Tensor, *arguments: Any) -> None:
    """Calls a function that works where the tensor is, on a GPU in the stream of the context."""
    on_gpu = tensor.is_cuda
    with context_of(None, who, tensor)._use(who) as pointer:
        if on_gpu:
            _ffi.call(who, "qs_context_stream", pointer, stream_of(tensor.get_device()),
                      on_gpu=True)
        _ffi.call(who, function, pointer, *arguments, on_gpu=on_gpu)


class SparseAdam(torch.optim.Adam):
    """Adam that moves the rows of visible Gaussians alone, without correction of the moments.

    params: parameters or groups with one float32 tensor each, a row per Gaussian.
    lr, eps: the learning rate and the number that is added to the root of the second moment.
    betas: decay of the moments.
    """

    def __init__(self, params: Iterable[Any], lr: float = 1e-3, eps: float = 1e-8,
                 betas: Tuple[float, float] = (0.9, 0.999)) -> None:
        super().__init__(params, lr=lr, eps=eps, betas=betas)

    @torch.no_grad()
    def step(self, visibility: Tensor, N: Optional[int] = None) -> None:  # type: ignore[override]
        """Takes a step.

        visibility: N, bool: the rows that move; the others keep their moments too.
        N: the number of rows; it follows from visibility.

        Raises UsageError.
        """
        steps: Dict[torch.device, List[Step]] = {}
        for group in self.param_groups:
            if len(group["params"]) != 1:
                raise UsageError("SparseAdam: a group has more than one tensor")
            param = group["params"][0]
            if param.grad is None or param.numel() == 0:
                continue
            state = self.state[param]
            if "exp_avg" not in state:
                state["step"] = torch.tensor(0.0)
                state["exp_avg"] = torch.zeros_like(param)
                state["exp_avg_sq"] = torch.zeros_like(param)
            steps.setdefault(param.device, []).append(
                Step(param, param.grad, state["exp_avg"], state["exp_avg_sq"], group["lr"],
                     group["betas"], group["eps"]))
        for own in steps.values():
            adam(own, visibility.bool())
