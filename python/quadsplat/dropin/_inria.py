# SPDX-License-Identifier: MIT
"""The interface of INRIA's diff_gaussian_rasterization and its variants.

Matrices are transposed there: points are rows. Pictures are channels x height x width.
"""
from __future__ import annotations

import ctypes
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import torch

from .. import _ffi
from .._errors import UsageError
from ..torch import Rasterized, Rules
from ..torch._functions import Rasterize
from ..torch._memory import follow_empty_cache
from ..torch._parts import relocated
from ..torch._plan import INPUTS, Plan, camera_of
from ..torch._rules import struct_of
from ..torch._tensors import checked, context_of, put, put_transposed
from . import _options
from ._refusals import TAMING

Tensor = torch.Tensor

follow_empty_cache()
_WHO = "diff_gaussian_rasterization"
_NEAR = 0.2
_OUTPUTS = {"w-pose": ("color", "depth", "alpha"), "dr_aa": ("color", "inverse_depth"),
            "3dgs_accel": ("color", "inverse_depth")}


class GaussianRasterizationSettings(NamedTuple):
    """A view. The optional fields belong to variants, which are recognised by them."""

    image_height: int
    image_width: int
    tanfovx: float
    tanfovy: float
    bg: Tensor  #: 3
    scale_modifier: float
    viewmatrix: Tensor  #: 4 x 4, world to view, transposed
    projmatrix: Tensor  #: 4 x 4, world to clip space, transposed
    sh_degree: int
    campos: Tensor  #: 3
    prefiltered: bool = False  #: ignored
    debug: bool = False  #: ignored: errors are raised by the call that makes them
    antialiasing: Optional[bool] = None  #: dr_aa, 3dgs_accel
    projmatrix_raw: Optional[Tensor] = None  #: -w-pose
    pixel_weights: Optional[Tensor] = None  #: taming-3dgs, refused


class GaussianRasterizer(torch.nn.Module):
    """Draws a view; the results follow from the variant."""

    variant: Optional[str] = None

    def __init__(self, raster_settings: GaussianRasterizationSettings) -> None:
        super().__init__()
        self.raster_settings = raster_settings

    @torch.no_grad()
    def markVisible(self, positions: Tensor) -> Tensor:
        """N x 3 points: N, bool: those with view z > 0.2."""
        view = checked(self.raster_settings.viewmatrix, f"{_WHO}: viewmatrix")
        points = checked(positions, f"{_WHO}: positions")
        return points @ view[:3, 2].to(points) + view[3, 2].to(points) > _NEAR

    def forward(self, means3D: Tensor, means2D: Tensor, opacities: Tensor,
                shs: Optional[Tensor] = None, colors_precomp: Optional[Tensor] = None,
                scales: Optional[Tensor] = None, rotations: Optional[Tensor] = None,
                cov3D_precomp: Optional[Tensor] = None, theta: Optional[Tensor] = None,
                rho: Optional[Tensor] = None, dc: Optional[Tensor] = None) -> Any:
        """Draws N Gaussians.

        means3D: N x 3. means2D: N x 3, or N x 4 for AbsGS: gets the gradients by the centres.
        opacities: N x 1. shs: N x M x 3, or without the DC if `dc`, N x 1 x 3, is given.
        colors_precomp: N x 3 in place of shs. scales: N x 3. rotations: N x 4, w x y z.
        cov3D_precomp: N x 6 in place of scales and rotations, scaled by scale_modifier already.
        theta, rho: 3, a turn and a shift of the view, whose values are taken as 0.
        """
        settings = self.raster_settings
        name = self.variant or _variant(settings)
        if settings.pixel_weights is not None or name == "taming":
            raise UsageError(f"{_WHO}: {TAMING}")
        if (shs is None and dc is None) == (colors_precomp is None):
            raise UsageError(f"{_WHO}: give either shs or colors_precomp")
        if (cov3D_precomp is None) == (scales is None or rotations is None) or (
                cov3D_precomp is not None and (scales is not None or rotations is not None)):
            raise UsageError(f"{_WHO}: give either scales and rotations or cov3D_precomp")
        given = _inputs(means3D, scales, rotations, opacities, dc if dc is not None else shs,
                        None if dc is None else shs, colors_precomp, cov3D_precomp, settings.bg)
        plan, position = _plan(settings, name, given[0], cov3D_precomp is not None)
        view: Optional[Tensor] = None
        if theta is not None or rho is not None:
            plan.position = position = None  # which follows the view
            view = _moved(settings.viewmatrix.transpose(0, 1), theta, rho)
        elif settings.viewmatrix.requires_grad:
            view = settings.viewmatrix.transpose(0, 1)
        screen = means2D if means2D is not None and means2D.requires_grad else None
        *pictures, radii, pixels = Rasterize.apply(plan, view, screen, None, *given, position)
        drawn = Rasterized(*pictures, radii, None, pixels)
        if name == "absgs":
            return drawn.color, radii, _weights(plan, given, position)
        return _results(name, drawn, radii)


class AbsGaussianRasterizer(GaussianRasterizer):
    """Draws a view as AbsGS does."""

    variant = "absgs"


def rasterize_gaussians(means3D: Tensor, means2D: Tensor, sh: Optional[Tensor],
                        colors_precomp: Optional[Tensor], opacities: Tensor,
                        scales: Optional[Tensor], rotations: Optional[Tensor],
                        cov3Ds_precomp: Optional[Tensor],
                        raster_settings: GaussianRasterizationSettings) -> Any:
    """GaussianRasterizer as a function. Empty tensors stand for arguments that are not given."""
    sh, colors_precomp, scales, rotations, cov3Ds_precomp = (
        None if tensor is None or (tensor.dim() == 1 and tensor.numel() == 0) else tensor
        for tensor in (sh, colors_precomp, scales, rotations, cov3Ds_precomp))
    return GaussianRasterizer(raster_settings)(
        means3D, means2D, opacities, shs=sh, colors_precomp=colors_precomp, scales=scales,
        rotations=rotations, cov3D_precomp=cov3Ds_precomp)


def compute_relocation(opacity_old: Tensor, scale_old: Tensor, N: Tensor, binoms: Any = None,
                       n_max: Any = None) -> Tuple[Tensor, Tensor]:
    """Opacities and scales of relocated Gaussians (MCMC).

    opacity_old: P or P x 1. scale_old: P x 3. N: P integers, the number of copies.
    binoms, n_max: a table of binomials, which quadsplat has itself.
    """
    return relocated(opacity_old, scale_old, N, "compute_relocation", ("opacity_old", "scale_old"))


def _variant(settings: GaussianRasterizationSettings) -> str:
    asked = _options.variant()
    if asked is not None:
        return asked
    if settings.projmatrix_raw is not None:
        return "w-pose"
    return "original" if settings.antialiasing is None else "dr_aa"


def _inputs(means: Any, scales: Any, rotations: Any, opacities: Any, sh: Any, sh_rest: Any,
            channels: Any, covariances: Any, background: Any) -> List[Optional[Tensor]]:
    """The tensors of a call in the order of INPUTS, without the position."""
    means = checked(means, f"{_WHO}: means")
    dtype, device = means.dtype, means.device

    def tensor(name: str, value: Any, place: Any = device) -> Optional[Tensor]:
        return None if value is None else checked(value, f"{_WHO}: {name}", dtype, place)

    column = tensor("opacities", opacities)
    if column is not None and column.dim() == 2 and column.shape[1] == 1:
        column = column.squeeze(1)
    colors = background if background.dtype == dtype else background.to(dtype)
    if colors.dim() != 1:
        colors = colors.reshape(3)
    return [means, tensor("scales", scales), tensor("rotations", rotations),
            tensor("covariances", covariances), column, tensor("sh", sh),
            tensor("sh_rest", sh_rest), tensor("channels", channels),
            tensor("background", colors, None)]


#: The members of QsMatrices, by their names here.
_NAMES = {"view": "viewmatrix", "lens": "projmatrix", "position": "campos"}


def _plan(settings: GaussianRasterizationSettings, name: str, means: Tensor,
          has_covariances: bool) -> Tuple[Plan, Optional[Tensor]]:
    """The camera and rules, and the position if it gets a gradient."""
    camera, matrices = _ffi.QsCamera(), _ffi.QsMatrices(is_clip=1)
    camera.width, camera.height = int(settings.image_width), int(settings.image_height)
    camera.near_depth = _NEAR
    for number, tangent in enumerate((settings.tanfovx, settings.tanfovy)):
        matrices.half_fov[number] = float(tangent)
    kept = []  # as long as the struct
    for member, where in _NAMES.items():
        tensor = checked(getattr(settings, where), f"{_WHO}: {where}")
        if member != "position":
            if tensor.dim() != 2:
                raise UsageError(f"{_WHO}: viewmatrix and projmatrix are not 4 x 4")
            put_transposed(matrices, member, tensor)
        elif not tensor.requires_grad:
            if tensor.dim() != 1:
                tensor = tensor.reshape(3)
            put(matrices, member, tensor)
        kept.append(tensor)
    position = kept[-1].reshape(3) if kept[-1].requires_grad else None
    at = None
    if position is None:
        at = matrices.at = (ctypes.c_double * 3)()
    context = context_of(None, _WHO, means)
    camera_of(_WHO, _NAMES, context, camera, matrices, means.device)
    rules = struct_of(_WHO, Rules(
        cull=_options.cull() or "3dgs", sh_degree=settings.sh_degree,
        splat_scale=1.0 if has_covariances else settings.scale_modifier,
        antialiased=bool(settings.antialiasing), normalises_rotations=False))
    return Plan(_WHO, context, camera, rules, _OUTPUTS.get(name, ("color",)), True,
                0.5 if name == "w-pose" else None, at, True), position


def _moved(view: Tensor, theta: Optional[Tensor], rho: Optional[Tensor]) -> Tensor:
    """The pose with its derivatives by a turn and a shift in front of it, at 0."""
    zero = view.new_zeros(())
    turn = zero.expand(3) if theta is None else (theta - theta.detach()).reshape(3).to(view)
    shift = zero.expand(3) if rho is None else (rho - rho.detach()).reshape(3).to(view)
    x, y, z = turn
    rows = [[zero, -z, y, shift[0]], [z, zero, -x, shift[1]], [-y, x, zero, shift[2]], [zero] * 4]
    return view + torch.stack([torch.stack(row) for row in rows]) @ view


def _results(name: str, drawn: Rasterized, radii: Tensor) -> Any:
    if name in ("dr_aa", "3dgs_accel"):
        assert drawn.inverse_depth is not None
        return drawn.color, radii, drawn.inverse_depth.unsqueeze(0)
    if name == "w-pose":
        assert drawn.depth is not None and drawn.alpha is not None
        return (drawn.color, radii, drawn.depth.unsqueeze(0), drawn.alpha.unsqueeze(0),
                drawn.pixels)
    if name == "mcmc":
        return drawn.color, radii, radii > 0
    return drawn.color, radii


def _weights(plan: Plan, given: Sequence[Optional[Tensor]], position: Optional[Tensor]) -> Tensor:
    """AbsGS's gs_w: sums over pixels of alpha times transmittance, which are the derivatives of a
    picture's sum by the Gaussians' only channel."""
    fixed = [None if tensor is None else tensor.detach() for tensor in (*given, position)]
    channel = fixed[0].new_zeros((fixed[0].shape[0], 1)).requires_grad_()
    for name, value in (("sh", None), ("sh_rest", None), ("channels", channel),
                        ("background", None)):
        fixed[INPUTS.index(name)] = value
    with torch.enable_grad():
        color = Rasterize.apply(plan, None, None, None, *fixed)[0]
        return torch.autograd.grad(color.sum(), channel)[0][:, 0]
