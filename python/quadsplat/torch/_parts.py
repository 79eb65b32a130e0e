# SPDX-License-Identifier: MIT
"""Parts of a trainer for torch."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, Optional, Tuple

import torch
from torch.autograd.function import once_differentiable

from .. import _ffi, _parts
from .._checks import choice
from .._errors import UsageError
from . import _gpu_ssim
from ._tensors import Tensor, checked, context_of, mark_changed, put, stream_of


class _Ssim(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, a: Tensor, b: Tensor, padding: str) -> Tensor:  # type: ignore[override]
        ctx.save_for_backward(a, b)
        ctx.padding = padding
        if a.is_cuda:
            return _gpu_ssim.ssim_and_gradient(a, b, padding)[0]
        return a.new_tensor(_parts.ssim(a, b, padding=padding))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, by: Tensor) -> Any:
        a, b = ctx.saved_tensors

        def gradient(x: Tensor, y: Tensor) -> Tensor:
            if x.is_cuda:
                return by * _gpu_ssim.ssim_and_gradient(x, y, ctx.padding)[1]
            return torch.from_numpy(_parts.ssim_backward(x, y, by.item(), padding=ctx.padding))

        # SSIM is symmetric.
        return (gradient(a, b) if ctx.needs_input_grad[0] else None,
                gradient(b, a) if ctx.needs_input_grad[1] else None, None)


def ssim(a: Tensor, b: Tensor, padding: str = "same") -> Tensor:
    """The mean structural similarity of two batches of pictures, with gradients by both.

    a, b: batch x channels x height x width, nominally 0..1, float32 or float64. Half precision is
        converted.
    padding: "same": every pixel counts, values outside are 0; "valid": 5 pixels at every side do
        not count, and both sides have at least 11 pixels.

    The window has 11 x 11 pixels and sigma 1.5. Returns a tensor of 0 dimensions. Raises UsageError.
    """
    first = checked(a, "ssim: a")
    second = checked(b, "ssim: b")
    if first.dtype != second.dtype:
        raise UsageError("ssim: b has elements of another type than a")
    if first.is_cuda or second.is_cuda:
        _check_on_gpu(first, second, padding)
    return _Ssim.apply(first, second, padding)


def _check_on_gpu(a: Tensor, b: Tensor, padding: str) -> None:
    """The library's checks. Raises UsageError."""
    if a.device != b.device:
        raise UsageError(f"ssim: b is on the device {b.device}, but a is on {a.device}")
    if a.dim() != 4 or a.numel() == 0:
        raise UsageError(f"ssim: a has the shape {tuple(a.shape)} instead of batch x channels x "
                         "height x width")
    if a.shape != b.shape:
        raise UsageError(f"ssim: b has the shape {tuple(b.shape)} instead of {tuple(a.shape)}")
    choice(padding, "ssim: padding", _ffi.PADDINGS)
    if padding == "valid" and min(a.shape[2:]) < 11:
        raise UsageError(f"ssim: padding 'valid' needs 11 pixels along each side, not "
                         f"{a.shape[3]} x {a.shape[2]}")


def adam(param: Tensor, gradient: Tensor, first: Tensor, second: Tensor,
         visible: Optional[Tensor], rate: float, betas: Tuple[float, float],
         epsilon: float) -> None:
    """quadsplat.adam() of tensors, without correction of the moments."""
    tensors = {"values": param, "gradients": gradient, "first": first, "second": second}
    for name, tensor in tensors.items():
        checked(tensor, f"adam: {name}")
    if param.is_cuda:
        _step_on_gpu(tensors, visible, rate, betas, epsilon)
    else:
        _parts.adam(param, gradient, first, second, rate, visible=visible, betas=betas,
                    epsilon=epsilon)


def _step_on_gpu(tensors: Dict[str, Tensor], visible: Optional[Tensor], rate: float,
                 betas: Tuple[float, float], epsilon: float) -> None:
    """Enqueues the step in torch's current stream."""
    param = tensors["values"]
    step = _ffi.QsAdam(rate=rate, beta1=betas[0], beta2=betas[1], epsilon=epsilon,
                       stream=stream_of(param.get_device()))
    for name, tensor in tensors.items():
        if tensor.dtype != torch.float32:
            raise UsageError(f"adam: {name} has elements of type {tensor.dtype} instead of float32")
        put(step, name, tensor)
    if visible is not None:
        rows = visible.to(param.device)
        put(step, "visible", rows.view(torch.uint8) if rows.dtype == torch.bool else rows)
    with context_of(None, "adam", param)._use("adam") as pointer:
        _ffi.call("adam", "qs_adam", pointer, ctypes.byref(step))
    for changed in (param, tensors["first"], tensors["second"]):
        mark_changed(changed)


def relocated(opacities: Tensor, scales: Tensor, counts: Any, who: str,
              names: Tuple[str, str]) -> Tuple[Tensor, Tensor]:
    """quadsplat.relocate() of tensors, computed on the CPU. The results are where opacities is.

    who, names: the caller and its names of the tensors, for messages.
    """
    given = [checked(tensor, f"{who}: {name}").detach().cpu() for tensor, name in
             zip((opacities, scales), names)]
    made = _parts.relocate(*given, torch.as_tensor(counts).cpu())
    new_opacities, new_scales = (torch.from_numpy(array).to(opacities.device) for array in made)
    return new_opacities, new_scales


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
            adam(param, param.grad, state["exp_avg"], state["exp_avg_sq"], visibility.bool(),
                 group["lr"], group["betas"], group["eps"])
