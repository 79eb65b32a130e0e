# SPDX-License-Identifier: MIT
"""rasterize()."""
from __future__ import annotations

from typing import Any, Iterable, List, NamedTuple, Optional, Union

import torch

from .. import _ffi
from .._camera import Camera
from .._checks import real, words
from .._context import Context
from .._errors import UsageError
from ._functions import Blend, Project, Rasterize, new_blocks
from ._plan import INPUTS, PICTURES, Plan
from ._rules import Rules, struct_of
from ._tensors import Tensor, checked, checked_shape, context_of


class Boundary(NamedTuple):
    """The values that pixels read of N Gaussians, as nodes of the graph.

    Rows of Gaussians that are not drawn are 0; there are also rows of Gaussians that no tile lists.
    """

    means_px: Tensor  #: N x 2: centres, pixels; pixel i has its centre at i
    conics: Tensor  #: N x 3: a b c, the inverse of the dilated covariance, 1/px^2
    depths: Tensor  #: N: view z
    opacities: Tensor  #: N: at the centre, with compensation
    colors: Optional[Tensor]  #: N x 3: RGB of `sh` as seen by the camera; None with `channels`


class Rasterized(NamedTuple):
    """The results of rasterize(). Pictures that were not asked for are None."""

    color: Optional[Tensor]  #: height x width x C, over the background, not clamped
    alpha: Optional[Tensor]  #: height x width: 1 - transmittance
    depth: Optional[Tensor]  #: height x width: sum of view z by weight, not divided by alpha
    inverse_depth: Optional[Tensor]  #: height x width: the same sum of 1 / z
    radii: Tensor  #: N x 2, int32: pixels along x and y, by Rules.radius_rule
    boundary: Optional[Boundary]  #: if it was asked for
    pixels: Optional[Tensor] = None  #: N, int32: see `counts_above`; None if not asked for


def rasterize(means: Tensor, scales: Optional[Tensor] = None, rotations: Optional[Tensor] = None,
              opacities: Optional[Tensor] = None, sh: Optional[Tensor] = None, *, camera: Camera,
              sh_rest: Optional[Tensor] = None, channels: Optional[Tensor] = None,
              covariances: Optional[Tensor] = None, background: Optional[Tensor] = None,
              view_from_world: Optional[Tensor] = None, position: Optional[Tensor] = None,
              screen_points: Optional[Tensor] = None, absolute_points: Optional[Tensor] = None,
              outputs: Union[str, Iterable[str]] = "color", planar: bool = False,
              boundary: bool = False, counts_above: Optional[float] = None, rules: Rules = Rules(),
              context: Optional[Context] = None) -> Rasterized:
    """Draws N Gaussians, 0 or more, with gradients by every tensor.

    means: N x 3, world.
    scales: N x 3, standard deviations >= 0.
    rotations: N x 4, quaternions w x y z.
    opacities: N or N x 1, sensible values are 0..1.
    sh: N x K x 3, coefficients of spherical harmonics, DC first, K = 1, 4, 9 or 16.
    sh_rest: N x (K - 1) x 3, if `sh` has the DC alone, N x 1 x 3.
    channels: N x C in place of `sh`, C = 1..32, any values.
    covariances: N x 6, xx xy xz yy yz zz, in place of scales and rotations, world units^2.
    background: C; None: 0.
    camera: the size of the picture, and the pose without the next argument.
    view_from_world: 4 x 4 or 3 x 4 in place of the camera's, a rotation and a translation.
    position: 3, the point from which colours are seen, world; None: the camera's, -R^T t, and its
        gradient is part of the gradient of view_from_world.
    screen_points: N x 2; its values are ignored, and its gradient is that by the centres, 1/px.
    absolute_points: N x 2; its gradient is the sum over pixels of the absolute values of the
        pixels' parts of that, as AbsGS splits by.
    outputs: "color", "alpha", "depth", "inverse_depth"; the others are None.
    planar: colour is C x height x width.
    boundary: also gives the boundary. Its means_px take the place of `screen_points`.
    counts_above: also counts, for each Gaussian, the pixels that blend it and have a transmittance
        above this after it, at least 0 and below 1; 0: all pixels that blend it.
    rules: the rules in which published rasterizers differ.
    context: threads of the CPU, or a GPU; None: the process's, for the device of means.

    Tensors are all on the CPU or all on a GPU of CUDA, of any strides; the pose may be on either.
    All have the type of means, float32, or on the CPU float64 to check gradients. Half precision is
    converted. Values that are not finite are not drawn and have gradient 0. The same call gives the
    same bits, with any number of threads. On a GPU the work is enqueued in torch's current stream.

    Raises UsageError, and DeviceError if the memory is too small. A tensor that was changed in
    place after the call makes backward() fail with torch's RuntimeError.
    """
    who = "rasterize"
    given = {"means": checked(means, f"{who}: means")}
    for name, value in (("scales", scales), ("rotations", rotations), ("opacities", opacities),
                        ("sh", sh), ("sh_rest", sh_rest), ("channels", channels),
                        ("covariances", covariances), ("background", background)):
        if value is not None:
            # The library reads a background in either memory.
            device = None if name == "background" else means.device
            given[name] = checked(value, f"{who}: {name}", given["means"].dtype, device)
    if "opacities" not in given:
        raise UsageError(f"{who}: opacities are not given")
    if given["opacities"].dim() == 2 and given["opacities"].shape[1] == 1:
        given["opacities"] = given["opacities"].squeeze(1)
    if position is not None:
        given["position"] = checked(position, f"{who}: position")
    count = given["means"].shape[0]
    points = [None if value is None else checked_shape(
        checked(value, f"{who}: {name}", given["means"].dtype, means.device), f"{who}: {name}",
        count, 2)
        for name, value in (("screen_points", screen_points), ("absolute_points", absolute_points))]
    chosen_camera, view = _camera(who, camera, view_from_world)
    if not isinstance(rules, Rules):
        raise UsageError(f"{who}: rules is {rules!r} instead of quadsplat.torch.Rules")
    plan = Plan(who, context_of(context, who, means), chosen_camera, struct_of(who, rules),
                words(outputs, f"{who}: outputs", PICTURES), planar,
                None if counts_above is None else _share(counts_above, f"{who}: counts_above"))
    inputs = [given.get(name) for name in INPUTS]
    if not boundary:
        *results, pixels = Rasterize.apply(plan, view, *points, *inputs)
        return Rasterized(*results, None, pixels)
    if screen_points is not None:
        raise UsageError(f"{who}: screen_points is given, and so is boundary: use its means_px")
    frame, blocks = _ffi.QsStageFrame(), new_blocks(inputs)
    *edge, radii, pixels = Project.apply(plan, frame, blocks, view, *inputs)
    pictures = Blend.apply(plan, frame, blocks, *edge, points[1], given.get("channels"),
                           given.get("background"),
                           *(None if tensor is None else tensor.detach() for tensor in inputs))
    return Rasterized(*pictures, radii, Boundary(*edge), pixels)


def _share(value: Any, where: str) -> float:
    number = real(value, where)
    if not 0 <= number < 1:
        raise UsageError(f"{where}: {number} is not at least 0 and below 1")
    return number


def _camera(who: str, camera: Any, view: Any) -> Any:
    """The struct of the camera with the pose of `view`, and `view` if it is a tensor."""
    if not isinstance(camera, Camera):
        raise UsageError(f"{who}: camera is {camera!r} instead of a quadsplat.Camera")
    struct = _ffi.QsCamera.from_buffer_copy(camera._struct)
    if view is None:
        return struct, None
    where = f"{who}: view_from_world"
    view = checked(view, where)
    if tuple(view.shape) not in ((4, 4), (3, 4)):
        raise UsageError(f"{where} has the shape {tuple(view.shape)} instead of (4, 4) or (3, 4)")
    set_pose(struct, view.detach().tolist(), where)
    return struct, view


def set_pose(struct: _ffi.QsCamera, rows: List[List[float]], where: str) -> None:
    """Gives the camera the matrix of 3 or 4 rows. Raises UsageError."""
    if len(rows) == 4 and max(abs(a - b) for a, b in zip(rows[3], (0, 0, 0, 1))) > 1e-6:
        raise UsageError(f"{where} has the last row {rows[3]} instead of 0, 0, 0, 1: it may be "
                         "transposed")
    struct.view_from_world[:] = sum(rows[:3], [])
