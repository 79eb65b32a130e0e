# SPDX-License-Identifier: MIT
"""The rasterizer as nodes of torch's graph: in one node, or in two with the boundary between.

Inputs are saved by save_for_backward: torch frees them on time, and notices changes in place. The
memory of a frame is freed by backward() unless the graph is retained, or with the graph. Nothing
else belongs to a frame, so any number of frames may wait.
"""
from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple

import torch
from torch.autograd.function import once_differentiable

from .. import _ffi
from ._memory import Blocks, place_of
from ._plan import INPUTS, PICTURES, Plan, Tensors
from ._tensors import Tensor, put, put_part

#: The inputs with derivatives in QsInputGradients.
_PROJECTED = INPUTS[:7]
_SH_REST, _CHANNELS, _BACKGROUND, _POSITION = map(
    INPUTS.index, ("sh_rest", "channels", "background", "position"))
_BOUNDARY = ("means_px", "conics", "depths", "opacities", "colors")

#: Newer versions of torch tell a backward pass whether the graph is retained.
_is_retained = getattr(torch._C._autograd, "_get_current_graph_task_keep_graph", None)

Gradients = Dict[str, Optional[Tensor]]


class Rasterize(torch.autograd.Function):
    """apply(plan, view, screen, absolute, *inputs) gives the pictures, radii and pixel counts.

    view: the camera's 3 x 4 matrix, whose values the plan has.
    screen, absolute: N x 2, for derivatives by the centres in pixels, and the absolute sums. Of a
        plan with is_ndc, screen is INRIA's means2D: N x 3, or N x 4 with the absolute sums.
    """

    @staticmethod
    def forward(ctx: Any, plan: Plan, view: Optional[Tensor], screen: Optional[Tensor],  # type: ignore[override]
                absolute: Optional[Tensor], *inputs: Optional[Tensor]) -> Any:
        ctx.set_materialize_grads(False)
        pictures = plan.empty_pictures(inputs)
        boundary = _ffi.QsBoundary()
        radii = _rows(inputs, torch.int32) if plan.is_ndc else _radii(inputs)
        put(boundary, "radii", radii)
        frame, blocks = _ffi.QsStageFrame(), new_blocks(inputs)
        plan.fill("qs_forward", inputs, blocks, boundary, plan.blended(pictures), frame)
        _keep(ctx, plan, frame, inputs, blocks)
        ctx.view = _likeness(view)
        ctx.columns = 0 if screen is None else screen.shape[1]
        return (*(pictures.get(name) for name in PICTURES), *_counts(ctx, plan, inputs, frame, radii))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *by: Optional[Tensor]) -> Any:
        given = _given_pictures(by)
        if not given:
            return (None,) * len(ctx.needs_input_grad)
        plan, inputs, frame = _kept(ctx)
        _, by_view, by_screen, by_absolute, *by_inputs = ctx.needs_input_grad
        wanted = dict(zip(INPUTS, by_inputs))
        boundary, at_boundary = _boundary_gradients(inputs, wanted, by_absolute)
        if by_screen:
            screen = at_boundary["means_px"] = _numbers(inputs, ctx.columns)
            boundary.ndc = plan.is_ndc
            if ctx.columns == 4:
                rows = (screen.shape[0], 2)
                put_part(boundary, "means_px", screen, rows, (4, 1))
                put_part(boundary, "absolute_px", screen, rows, (4, 1), 2)
            else:
                put(boundary, "means_px", screen)
        struct, gradients, pose = _input_gradients(plan, inputs, wanted, by_view)
        plan.call("qs_backward", inputs, frame, plan.blended(given), boundary, struct)
        _free(ctx.own)
        gradients.update(at_boundary)
        return (None, _view_gradient(plan, pose, inputs, ctx.view), gradients.get("means_px"),
                gradients.get("absolute_px"), *_in_order(gradients, pose, inputs, wanted))


class Project(torch.autograd.Function):
    """apply(plan, frame, blocks, view, *inputs) gives the boundary, radii and pixel counts.

    frame, blocks: are filled.
    """

    @staticmethod
    def forward(ctx: Any, plan: Plan, frame: _ffi.QsStageFrame, blocks: Blocks,  # type: ignore[override]
                view: Optional[Tensor], *inputs: Optional[Tensor]) -> Any:
        ctx.set_materialize_grads(False)
        boundary, radii = _ffi.QsBoundary(), _radii(inputs)
        made = _boundary_rows(inputs)
        for name, tensor in {**made, "radii": radii}.items():
            put(boundary, name, tensor)
        plan.fill("qs_project", inputs, blocks, boundary, frame)
        _keep(ctx, plan, frame, inputs, blocks)
        ctx.view = _likeness(view)
        return (*(made.get(name) for name in _BOUNDARY), *_counts(ctx, plan, inputs, frame, radii))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *by: Optional[Tensor]) -> Any:
        if not any(tensor is not None for tensor in by):
            return (None,) * len(ctx.needs_input_grad)
        plan, inputs, frame = _kept(ctx)
        _, _, _, by_view, *by_inputs = ctx.needs_input_grad
        wanted = dict(zip(INPUTS, by_inputs))
        boundary = _ffi.QsBoundaryGradients()
        for name, tensor in zip(_BOUNDARY, by):
            put(boundary, name, tensor)
        struct, gradients, pose = _input_gradients(plan, inputs, wanted, by_view)
        plan.call("qs_project_backward", inputs, frame, boundary, struct)
        _free(ctx.own)
        return (None, None, None, _view_gradient(plan, pose, inputs, ctx.view),
                *_in_order(gradients, pose, inputs, wanted))


class Blend(torch.autograd.Function):
    """apply(plan, frame, blocks, boundary of Project, absolute, channels, background, *inputs)
    gives the pictures.

    The values of the boundary are those of the frame. inputs: detached, without gradients.
    """

    @staticmethod
    def forward(ctx: Any, plan: Plan, frame: _ffi.QsStageFrame, blocks: Blocks,  # type: ignore[override]
                means_px: Tensor, conics: Tensor, depths: Tensor, opacities: Tensor,
                colors: Optional[Tensor], absolute: Optional[Tensor], channels: Optional[Tensor],
                background: Optional[Tensor], *inputs: Optional[Tensor]) -> Any:
        ctx.set_materialize_grads(False)
        pictures = plan.empty_pictures(inputs)
        own, drawn = new_blocks(inputs), _ffi.QsStageFrame.from_buffer_copy(frame)
        plan.fill("qs_blend", inputs, own, plan.blended(pictures), drawn)
        _keep(ctx, plan, drawn, inputs, own, blocks)
        return tuple(pictures.get(name) for name in PICTURES)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *by: Optional[Tensor]) -> Any:
        given = _given_pictures(by)
        if not given:
            return (None,) * len(ctx.needs_input_grad)
        plan, inputs, frame = _kept(ctx)
        needs = ctx.needs_input_grad[3:]
        wanted = {"channels": needs[6], "background": needs[7]}
        boundary, gradients = _boundary_gradients(inputs, wanted, needs[5])
        rows = _boundary_rows(inputs)
        for name, is_wanted in zip(_BOUNDARY, needs):
            if is_wanted:
                gradients[name] = rows[name]
                put(boundary, name, rows[name])
        plan.call("qs_blend_backward", inputs, frame, plan.blended(given), boundary)
        _free(ctx.own)
        return (None, None, None, *(gradients.get(name) for name in _BOUNDARY),
                gradients.get("absolute_px"), gradients.get("channels"),
                gradients.get("background"), *(None for _ in inputs))


class Shared:
    """What Centres and Draw share of a frame.

    ids: the numbers of the Gaussians that have a row in the centres; None: all have one.
    """

    def __init__(self, plan: Plan, with_absolute: bool) -> None:
        self.plan = plan
        self.with_absolute = with_absolute
        self.frame = _ffi.QsStageFrame()
        self.blocks: Any = None
        self.pictures: Gradients = {}
        self.ids: Optional[Tensor] = None
        self.points: Any = None  #: a weak reference to the centres, which get `absgrad`
        self.part: Optional[Tensor] = None  #: the derivative by the centres that Draw passed on
        self.version = 0  #: of part

    def rows(self, values: Tensor) -> Tensor:
        """The rows of the centres."""
        return values if self.ids is None else values[self.ids]


class Centres(torch.autograd.Function):
    """apply(shared, packed, *inputs) gives the centres in gsplat's pixels and the radii, as rows of
    the visible Gaussians if `packed`, else 1 x N rows. The frame is drawn too, for Draw.

    Draw passes derivatives on to the inputs, and also gives the derivative by the centres here, so
    that the program can read it. This node passes on what other users of the centres add to that.
    """

    @staticmethod
    def forward(ctx: Any, shared: Shared, packed: bool, *inputs: Optional[Tensor]) -> Any:  # type: ignore[override]
        ctx.set_materialize_grads(False)
        plan, means = shared.plan, _means(inputs)
        count = means.shape[0]
        lead = () if packed else (1,)
        centres = means.new_empty((*lead, count, 2))
        radii = means.new_empty((*lead, count, 2), dtype=torch.int32)
        boundary = _ffi.QsBoundary(corners=1)
        for name, tensor in (("means_px", centres), ("radii", radii)):
            put_part(boundary, name, tensor, (count, 2), (2, 1))
        shared.pictures = pictures = plan.empty_pictures(inputs, 1)
        shared.blocks = new_blocks(inputs)
        plan.fill("qs_forward", inputs, shared.blocks, boundary, plan.blended(pictures),
                  shared.frame)
        if packed:
            shared.ids = radii.prod(-1).nonzero().squeeze(1)  # of 64 bits
            centres, radii = centres[shared.ids], radii[shared.ids]
        ctx.shared = shared
        ctx.save_for_backward(*inputs)
        ctx.mark_non_differentiable(radii)
        return centres, radii

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, by: Optional[Tensor], _: Any) -> Any:
        shared, part = ctx.shared, ctx.shared.part
        is_own = part is not None and by is not None and by.data_ptr() == part.data_ptr()
        if is_own and by._version != shared.version:
            raise RuntimeError(f"{shared.plan.who}: the gradient of the centres was changed in "
                               "place: return a new one from the hook")
        if by is None or is_own:
            _free(shared.blocks)
            return (None,) * len(ctx.needs_input_grad)
        inputs = ctx.saved_tensors
        _require_blocks(shared.plan, shared.blocks)
        rows = by if part is None else by - part
        if shared.ids is not None:
            rows = rows.new_zeros(_means(inputs).shape[0], 2).index_copy_(0, shared.ids, rows)
        boundary = _ffi.QsBoundaryGradients()
        put(boundary, "means_px", rows.reshape(-1, 2))
        wanted = dict(zip(INPUTS, ctx.needs_input_grad[2:]))
        struct, gradients, pose = _input_gradients(shared.plan, inputs, wanted, False)
        shared.plan.call("qs_project_backward", inputs, shared.frame, boundary, struct)
        _free(shared.blocks)
        return (None, None, *_in_order(gradients, pose, inputs, wanted))


class Draw(torch.autograd.Function):
    """apply(shared, centres, *inputs) gives the pictures that Centres drew: 1 x height x width x C
    each."""

    @staticmethod
    def forward(ctx: Any, shared: Shared, centres: Tensor, *inputs: Optional[Tensor]) -> Any:  # type: ignore[override]
        ctx.set_materialize_grads(False)
        ctx.shared = shared
        ctx.save_for_backward(*inputs)
        pictures, shared.pictures = shared.pictures, {}
        return tuple(pictures.get(name) for name in PICTURES)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *by: Optional[Tensor]) -> Any:
        given = _given_pictures(by)
        if not given:
            return (None,) * len(ctx.needs_input_grad)
        shared, inputs = ctx.shared, ctx.saved_tensors
        plan = shared.plan
        _require_blocks(plan, shared.blocks)
        _, by_centres, *by_inputs = ctx.needs_input_grad
        wanted = dict(zip(INPUTS, by_inputs))
        boundary, at_boundary = _boundary_gradients(inputs, wanted, shared.with_absolute)
        if by_centres:
            at_boundary["means_px"] = _numbers(inputs, 2)
            put(boundary, "means_px", at_boundary["means_px"])
        struct, gradients, pose = _input_gradients(plan, inputs, wanted, False)
        plan.call("qs_backward", inputs, shared.frame, plan.blended(given), boundary, struct)
        gradients.update(at_boundary)
        part = None
        if by_centres:
            shape = (-1, 2) if shared.ids is not None else (1, -1, 2)
            part = shared.part = shared.rows(at_boundary["means_px"]).view(shape)
            shared.version = part._version
            points = None if shared.points is None else shared.points()
            if shared.with_absolute and points is not None:
                points.absgrad = shared.rows(at_boundary["absolute_px"]).view(shape)
        return (None, part, *_in_order(gradients, pose, inputs, wanted))


def _given_pictures(by: Sequence[Optional[Tensor]]) -> Dict[str, Tensor]:
    """The derivatives by pictures that backward() has."""
    return {name: tensor for name, tensor in zip(PICTURES, by) if tensor is not None}


def new_blocks(inputs: Tensors) -> Blocks:
    return Blocks(place_of(_means(inputs).device))


def _keep(ctx: Any, plan: Plan, frame: _ffi.QsStageFrame, inputs: Tensors, own: Blocks,
          others: Optional[Blocks] = None) -> None:
    """Keeps what the backward pass reads. others: blocks that another node frees."""
    ctx.plan, ctx.frame, ctx.own, ctx.others = plan, frame, own, others
    ctx.save_for_backward(*inputs)


def _free(blocks: Blocks) -> None:
    """After the last backward pass that reads them: frees the blocks unless the graph is retained."""
    if _is_retained is not None and not _is_retained():
        blocks.free()


def _counts(ctx: Any, plan: Plan, inputs: Tensors, frame: _ffi.QsStageFrame,
            radii: Tensor) -> Tuple[Tensor, Optional[Tensor]]:
    """The results without gradients: the radii, and the pixel counts if they are wanted."""
    pixels = plan.count_pixels(inputs, frame)
    ctx.mark_non_differentiable(*(radii,) if pixels is None else (radii, pixels))
    return radii, pixels


def _kept(ctx: Any) -> Tuple[Plan, Tensors, _ffi.QsStageFrame]:
    """The plan, the inputs and the frame. Raises RuntimeError if an input was changed in place, or
    something was freed."""
    saved = ctx.saved_tensors
    _require_blocks(ctx.plan, ctx.own)
    if ctx.others is not None:
        _require_blocks(ctx.plan, ctx.others)
    return ctx.plan, saved, ctx.frame


def _require_blocks(plan: Plan, blocks: Blocks) -> None:
    """Raises RuntimeError if the blocks were freed."""
    if blocks.is_freed:
        raise RuntimeError(f"{plan.who}: a backward pass has freed the frame: retain the graph "
                           "(retain_graph=True) to pass through it again")


def _means(inputs: Tensors) -> Tensor:
    assert inputs[0] is not None
    return inputs[0]


def _numbers(inputs: Tensors, columns: int) -> Tensor:
    """An uninitialised tensor with `columns` numbers per Gaussian."""
    means = _means(inputs)
    return means.new_empty((means.shape[0], columns))


def _rows(inputs: Tensors, dtype: Optional[torch.dtype] = None) -> Tensor:
    """An uninitialised tensor with a number per Gaussian."""
    means = _means(inputs)
    return means.new_empty((means.shape[0],), dtype=dtype)


def _radii(inputs: Tensors) -> Tensor:
    means = _means(inputs)
    return means.new_empty((means.shape[0], 2), dtype=torch.int32)


def _boundary_rows(inputs: Tensors) -> Dict[str, Tensor]:
    rows = {"means_px": _numbers(inputs, 2), "conics": _numbers(inputs, 3), "depths": _rows(inputs),
            "opacities": _rows(inputs)}
    if inputs[_CHANNELS] is None:
        rows["colors"] = _numbers(inputs, 3)
    return rows


def _likeness(view: Optional[Tensor]) -> Any:
    """Type, device and shape of the gradient by the matrix."""
    return None if view is None else (view.dtype, view.device, tuple(view.shape))


def _boundary_gradients(inputs: Tensors, wanted: Dict[str, bool],
                        absolute: bool) -> Tuple[_ffi.QsBoundaryGradients, Gradients]:
    """A struct for the derivatives by channels, background and absolute sums that are wanted."""
    struct, gradients = _ffi.QsBoundaryGradients(), {}
    for name, tensor in (("channels", inputs[_CHANNELS]), ("background", inputs[_BACKGROUND])):
        if tensor is not None and wanted[name]:
            gradients[name] = torch.empty_like(tensor)
    if absolute:
        gradients["absolute_px"] = _numbers(inputs, 2)
    for name, tensor in gradients.items():
        put(struct, name, tensor)
    return struct, gradients


def _input_gradients(plan: Plan, inputs: Tensors, wanted: Dict[str, bool],
                     by_view: bool) -> Tuple[_ffi.QsInputGradients, Gradients, Gradients]:
    """A struct for the derivatives that are wanted, by the inputs and by the pose."""
    struct, gradients, pose = _ffi.QsInputGradients(), {}, {}
    if inputs[_SH_REST] is not None and (wanted["sh"] or wanted["sh_rest"]):
        wanted = {**wanted, "sh": True, "sh_rest": True}
    for name, tensor in zip(_PROJECTED, inputs):
        if tensor is not None and wanted[name]:
            gradient = gradients[name] = torch.empty_like(tensor)
            put(struct, name, gradient)
    if by_view:
        pose["view_from_world"] = torch.empty((3, 4), dtype=torch.float64)
    if wanted["position"] or by_view and inputs[_POSITION] is None:
        pose["position"] = torch.empty(3, dtype=torch.float64)
    for name, tensor in pose.items():
        put(struct, name, tensor)
    return struct, gradients, pose


def _in_order(gradients: Gradients, pose: Gradients, inputs: Tensors,
              wanted: Dict[str, bool]) -> List[Optional[Tensor]]:
    """The derivatives by the inputs in the order of INPUTS, None where they are not wanted."""
    position = inputs[_POSITION]
    if wanted["position"] and position is not None:
        by_position = pose["position"]
        assert by_position is not None
        gradients["position"] = by_position.to(position)
    return [gradients.get(name) if wanted[name] else None for name in INPUTS]


def _view_gradient(plan: Plan, pose: Gradients, inputs: Tensors, view: Any) -> Optional[Tensor]:
    """The derivative by the matrix, with the part of a position that follows from it."""
    gradient = pose.get("view_from_world")
    if gradient is None:
        return None
    by_position = pose.get("position")
    if inputs[_POSITION] is None and by_position is not None:
        # The position is -R^T t.
        matrix = torch.tensor(list(plan.camera.view_from_world), dtype=torch.float64).view(3, 4)
        rotation, translation = matrix[:, :3], matrix[:, 3]
        gradient[:, :3] -= torch.outer(translation, by_position)
        gradient[:, 3] -= rotation @ by_position
    dtype, device, shape = view
    whole = torch.zeros(shape, dtype=dtype)
    whole[:3] = gradient
    return whole.to(device)
