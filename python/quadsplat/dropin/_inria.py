# SPDX-License-Identifier: MIT
"""The interface of INRIA's diff_gaussian_rasterization and its variants.

Matrices are transposed there: points are rows. Pictures are channels x height x width.
"""
from __future__ import annotations

from typing import Any, NamedTuple, Optional, Sequence, Tuple

import torch

from .._camera import Camera
from .._errors import UsageError
from ..torch import Rasterized, Rules, rasterize
from ..torch._parts import relocated
from ..torch._tensors import checked
from . import _options
from ._refusals import TAMING

Tensor = torch.Tensor

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
        camera, view = _camera(settings)
        position: Optional[Tensor] = settings.campos.reshape(3)
        if theta is not None or rho is not None:
            view, position = _moved(view, theta, rho), None  # which follows the view
        halves = _halves(means2D, camera)
        given = {
            "means": means3D, "scales": scales, "rotations": rotations, "opacities": opacities,
            "covariances": cov3D_precomp, "channels": colors_precomp,
            "sh": shs if dc is None else dc, "sh_rest": None if dc is None else shs}
        options = {
            "camera": camera, "view_from_world": view, "position": position,
            "background": settings.bg.reshape(3).to(means3D.dtype),
            "rules": _rules(settings, cov3D_precomp is not None)}
        drawn = rasterize(**given, **options, planar=True, outputs=_OUTPUTS.get(name, ("color",)),
                          counts_above=0.5 if name == "w-pose" else None, **halves)
        radii = drawn.radii[:, 0].contiguous()
        if name == "absgs":
            return drawn.color, radii, _weights(given, options)
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


def _rules(settings: GaussianRasterizationSettings, has_covariances: bool) -> Rules:
    return Rules(mode=_options.cull() or "3dgs", sh_degree=settings.sh_degree,
                 splat_scale=1.0 if has_covariances else settings.scale_modifier,
                 antialiased=bool(settings.antialiasing), normalises_rotations=False)


def _camera(settings: GaussianRasterizationSettings) -> Tuple[Camera, Tensor]:
    """The camera without its pose, and the pose as a tensor, world to view, not transposed."""
    width, height = int(settings.image_width), int(settings.image_height)
    tangents = float(settings.tanfovx), float(settings.tanfovy)
    view = checked(settings.viewmatrix, f"{_WHO}: viewmatrix")
    offset = _offset(view, settings, tangents)
    center = [((offset[axis] + 1) * size - 1) / 2 for axis, size in enumerate((width, height))]
    focal = [size / (2 * tangent) if tangent > 0 else 0.0
             for size, tangent in zip((width, height), tangents)]
    return Camera(width, height, focal, center, near_depth=_NEAR), view.transpose(0, 1)


def _offset(view: Tensor, settings: GaussianRasterizationSettings,
            tangents: Tuple[float, float]) -> Sequence[float]:
    """The principal point in normalised device coordinates, from projmatrix = viewmatrix P."""
    # Numbers instead of tensors: sixteen of them are not worth an operation of torch each.
    projection = checked(settings.projmatrix, f"{_WHO}: projmatrix")
    if tuple(projection.shape) != (4, 4) or tuple(view.shape) != (4, 4):
        raise UsageError(f"{_WHO}: viewmatrix and projmatrix are not 4 x 4")
    rows, whole = view.detach().tolist(), projection.detach().tolist()
    lens = [[sum(rows[k][row] * whole[k][column] for k in range(3)) for column in range(4)]
            for row in range(3)]  # the first rows of P
    last = [whole[3][column] - sum(rows[3][k] * lens[k][column] for k in range(3))
            for column in range(4)]
    reach = 1e-3 * (1 + max(map(abs, rows[3])))
    ones = [lens[axis][axis] * tangents[axis] - 1 for axis in range(2)]
    zeros = [*ones, lens[0][1], lens[1][0], lens[0][3], lens[1][3], lens[2][3] - 1]
    if not (all(abs(value) < 1e-3 for value in zeros)
            and all(abs(last[column]) < reach for column in (0, 1, 3))):
        raise UsageError(f"{_WHO}: projmatrix is not viewmatrix times a perspective projection "
                         "with the fields of view tanfovx and tanfovy")
    return [0.0 if abs(value) < 1e-5 else value for value in lens[2][:2]]


def _halves(means2D: Optional[Tensor], camera: Camera) -> Any:
    """The tensors that get gradients in pixels, so that means2D gets them in NDC units."""
    if means2D is None or not means2D.requires_grad:
        return {}
    half = means2D.new_tensor([camera.width / 2, camera.height / 2])
    parts = {"screen_points": means2D[:, :2] * half}
    if means2D.shape[1] == 4:
        parts["absolute_points"] = means2D[:, 2:] * half
    return parts


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


def _weights(given: Any, options: Any) -> Tensor:
    """AbsGS's gs_w: sums over pixels of alpha times transmittance, which are the derivatives of a
    picture's sum by the Gaussians' only channel."""
    fixed = {name: None if tensor is None else tensor.detach() for name, tensor in given.items()}
    with torch.enable_grad():
        channel = fixed["means"].new_zeros((fixed["means"].shape[0], 1)).requires_grad_()
        fixed.update(sh=None, sh_rest=None, channels=channel)
        drawn = rasterize(**fixed, camera=options["camera"],
                          view_from_world=options["view_from_world"].detach(),
                          rules=options["rules"])
        assert drawn.color is not None
        return torch.autograd.grad(drawn.color.sum(), channel)[0][:, 0]
