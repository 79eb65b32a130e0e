# SPDX-License-Identifier: MIT
"""gsplat's rasterization() and the functions of its extension, versions 1.4 to 1.6."""
from __future__ import annotations

import sys
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import torch

from .. import _ffi, _parts
from .._camera import Camera
from .._errors import UsageError
from ..torch import Rules, _functions, _plan, _rasterize
from ..torch._parts import adam as _adam
from ..torch._tensors import checked
from . import _options

Tensor = torch.Tensor

_WHO = "gsplat.rasterization"
_MODES = ("RGB", "D", "ED", "RGB+D", "RGB+ED")
_CHANNELS = 32
_STAND_IN = (1, 5, 3)


class Info(dict):  # type: ignore[type-arg]
    """gsplat's third result. The sorted lists of (Gaussian, tile) pairs are not in it."""

    def __missing__(self, key: str) -> Any:
        raise KeyError(f"quadsplat's info has no {key!r}: the lists of tiles are in "
                       "quadsplat.tile_lists()")


class _Version(NamedTuple):
    """The rules of a version of gsplat."""

    radius_rule: str
    mode: str
    alpha_max: float
    compensation_floor: float
    has_two_radii: bool
    has_batches: bool


def _version() -> _Version:
    module = sys.modules.get("gsplat")
    words = str(getattr(module, "__version__", "1.5.3")).split("+")[0].split(".")
    try:
        number: Tuple[int, ...] = tuple(int(word) for word in words[:3])
    except ValueError:
        number = _STAND_IN
    if number < (1, 5):
        return _Version("gsplat_1_4", "3dgs", 0.999, 0.0, False, False)
    if number < (1, 6):
        return _Version("gsplat_1_5", "adr", 0.999, 0.0, True, number >= (1, 5, 3))
    return _Version("gsplat_1_5", "adr", 0.99, 2.5e-5, True, True)


def rasterization(
        means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, colors: Tensor,
        viewmats: Tensor, Ks: Tensor, width: int, height: int, near_plane: float = 0.01,
        far_plane: float = 1e10, radius_clip: float = 0.0, eps2d: float = 0.3,
        sh_degree: Optional[int] = None, packed: bool = True, tile_size: Optional[int] = None,
        backgrounds: Optional[Tensor] = None, render_mode: str = "RGB", sparse_grad: bool = False,
        absgrad: bool = False, rasterize_mode: str = "classic", channel_chunk: int = 32,
        distributed: bool = False, camera_model: str = "pinhole", segmented: bool = False,
        covars: Optional[Tensor] = None, **others: Any) -> Tuple[Tensor, Tensor, Info]:
    """Draws N Gaussians with C cameras, as gsplat does.

    means: N x 3. quats: N x 4, w x y z. scales: N x 3. opacities: N.
    colors: N x D or C x N x D, or SH of N x K x 3 or C x N x K x 3 with sh_degree.
    viewmats: C x 4 x 4, world to view. Ks: C x 3 x 3, pixel i has its centre at i + 0.5.
    covars: N x 3 x 3 in place of quats and scales. backgrounds: C x D.
    packed: decides the shapes of the third result: a row per visible Gaussian and camera, or C x N.
    render_mode: "RGB", "D", "ED", "RGB+D" or "RGB+ED"; ED is D over alpha.

    Returns colours C x height x width x X, alphas C x height x width x 1, and a dictionary, whose
    means2d is a node of the graph with gradients in pixels, and .absgrad if `absgrad`. Raises
    UsageError for arguments that quadsplat does not have.
    """
    version = _version()
    _refuse(others, camera_model, distributed, segmented, tile_size, render_mode, rasterize_mode,
            sparse_grad, packed)
    means = _shaped(means, "means", (None, 3))
    count = means.shape[0]
    views = _shaped(viewmats, "viewmats", (None, 4, 4))
    cameras = views.shape[0]
    if cameras == 0:
        raise UsageError(f"{_WHO}: viewmats has no camera")
    _shaped(Ks, "Ks", (cameras, 3, 3))
    given = {"means": means, "opacities": _shaped(opacities, "opacities", (count,))}
    ids: List[Tensor] = []  # of the visible Gaussians, for sparse gradients
    if covars is not None:
        whole = _shaped(covars, "covars", (count, 3, 3))
        given["covariances"] = torch.stack([whole[:, row, column] for row, column in (
            (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))], 1)
    else:
        given["rotations"] = _shaped(quats, "quats", (count, 4))
        given["scales"] = _shaped(scales, "scales", (count, 3))
    if sparse_grad:
        for name in ("means", "rotations", "scales"):
            if name in given:
                given[name] = _Sparse.apply(given[name], ids)
    has_color = render_mode.startswith("RGB")
    edges, frames = [], []
    for number in range(cameras):
        inputs = dict(given, **_colors(colors, number, cameras, count, sh_degree,
                                      means.device))
        if backgrounds is not None and has_color:
            inputs["background"] = _shaped(backgrounds, "backgrounds", (cameras, None))[number]
        view = views[number]
        inputs["position"] = torch.linalg.inv_ex(view)[0][:3, 3]
        plan = _plan_of(version, view, Ks[number], int(width), int(height), near_plane, far_plane,
                        radius_clip, eps2d, sh_degree, rasterize_mode, render_mode)
        row = [inputs.get(name) for name in _plan.INPUTS]
        frame, blocks = _ffi.QsStageFrame(), _plan.Blocks()
        edges.append(_functions.Project.apply(plan, frame, blocks, view, *row))
        frames.append((plan, frame, blocks, row))
    info, centres, absolute = _info(version, edges, packed, absgrad, count)
    ids.append(info["gaussian_ids"] if packed else torch.empty(0, dtype=torch.int64))
    pictures = []
    for number, (plan, frame, blocks, row) in enumerate(frames):
        edge = list(edges[number][:5])
        edge[0] = centres(number)
        chosen = dict(zip(_plan.INPUTS, row))
        pictures.append(_functions.Blend.apply(
            plan, frame, blocks, *edge, absolute(number), chosen["channels"], chosen["background"],
            *(None if tensor is None else tensor.detach() for tensor in row)))
    alphas = torch.stack([picture[1] for picture in pictures]).unsqueeze(-1)
    parts = [torch.stack([picture[0] for picture in pictures])] if has_color else []
    if render_mode != "RGB":
        depth = torch.stack([picture[2] for picture in pictures]).unsqueeze(-1)
        parts.append(depth / alphas.clamp(min=1e-10) if render_mode.endswith("ED") else depth)
    tiles = [-(-int(size) // 16) for size in (width, height)]
    info.update(width=int(width), height=int(height), tile_width=tiles[0], tile_height=tiles[1],
                tile_size=16, n_cameras=cameras)
    if version.has_batches:
        info["n_batches"] = 1
    return torch.cat(parts, -1), alphas, info


class _Sparse(torch.autograd.Function):
    """The tensor; its gradient is a sparse tensor of the rows of the visible Gaussians."""

    @staticmethod
    def forward(ctx: Any, tensor: Tensor, ids: List[Tensor]) -> Tensor:  # type: ignore[override]
        ctx.ids = ids
        return tensor.view_as(tensor)

    @staticmethod
    def backward(ctx: Any, by: Tensor) -> Any:  # type: ignore[override]
        rows = ctx.ids[0].unique()
        return torch.sparse_coo_tensor(rows[None], by[rows], by.shape), None


def _plan_of(version: _Version, view: Tensor, intrinsics: Tensor, width: int, height: int,
             near: float, far: float, clip: float, dilation: float, sh_degree: Optional[int],
             rasterize_mode: str, render_mode: str) -> _plan.Plan:
    (fx, skew, cx), (_, fy, cy) = intrinsics.detach().double().tolist()[:2]
    if skew != 0:
        raise UsageError(f"{_WHO}: Ks has a skew, which quadsplat does not have")
    camera = Camera(width, height, (fx, fy), (cx - 0.5, cy - 0.5), near_depth=near)
    margins = [0.3 * 0.5 * size / focal for size, focal in ((width, fx), (height, fy))]
    rules = Rules(
        mode=_options.cull() or version.mode, sh_degree=sh_degree or 0, far_depth=far,
        dilation_px2=dilation, antialiased=rasterize_mode == "antialiased",
        compensation_floor=version.compensation_floor, alpha_max=version.alpha_max,
        alpha_max_blocks=True, stops_at_equal=True, zero_color_passes=True, radius_clip_px=clip,
        radius_rule=version.radius_rule,
        slopes=(-(cx / fx + margins[0]), -(cy / fy + margins[1]),
                (width - cx) / fx + margins[0], (height - cy) / fy + margins[1]))
    outputs = (["color"] if render_mode.startswith("RGB") else []) + ["alpha"] + (
        [] if render_mode == "RGB" else ["depth"])
    struct, _ = _rasterize._camera(_WHO, camera, view)
    return _plan.Plan(_WHO, _rasterize.context_of(None, _WHO, view), struct,
                      _rasterize.struct_of(_WHO, rules), tuple(outputs), False)


def _colors(colors: Optional[Tensor], number: int, cameras: int, count: int,
            sh_degree: Optional[int], device: torch.device) -> Dict[str, Tensor]:
    """The channels or SH of a camera."""
    if colors is None:
        return {"channels": torch.zeros(count, 1, device=device)}
    colors = checked(colors, f"{_WHO}: colors")
    if sh_degree is None:
        shape: Tuple[Optional[int], ...] = (count, None)
    else:
        if not 0 <= sh_degree <= 3:
            raise UsageError(f"{_WHO}: sh_degree: {sh_degree} is not between 0 and 3")
        shape = (count, None, 3)
    if colors.dim() == len(shape) + 1:
        colors = _shaped(colors, "colors", (cameras, *shape))[number]
    colors = _shaped(colors, "colors", shape)
    if sh_degree is None:
        if not 1 <= colors.shape[1] <= _CHANNELS:
            raise UsageError(f"{_WHO}: {colors.shape[1]} channels are not between 1 and "
                             f"{_CHANNELS}: draw them in parts")
        return {"channels": colors}
    if colors.shape[1] < (sh_degree + 1) ** 2:
        raise UsageError(f"{_WHO}: {colors.shape[1]} coefficients are too few for degree "
                         f"{sh_degree}")
    return {"sh": colors[:, : (sh_degree + 1) ** 2]}


def _info(version: _Version, edges: Any, packed: bool, absgrad: bool, count: int) -> Any:
    """The dictionary, and functions from a camera to its centres and absolute sums, N x 2.

    Centres at pixels are at halves there.
    """
    info = Info()
    radii = torch.stack([edge[5] for edge in edges])
    names = {"means2d": 0, "conics": 1, "depths": 2, "opacities": 3}
    values = {name: torch.stack([edge[place] for edge in edges]) for name, place in names.items()}
    seen = (radii > 0).all(-1)
    camera_ids, gaussian_ids = torch.nonzero(seen, as_tuple=True)
    if packed:
        values = {name: value[camera_ids, gaussian_ids] for name, value in values.items()}
        radii = radii[camera_ids, gaussian_ids]
    visible = seen[..., None] if not packed else torch.ones_like(camera_ids)[:, None] > 0
    points = values["means2d"] = torch.where(visible, values["means2d"] + 0.5,
                                             torch.zeros_like(values["means2d"]))
    carrier = None
    if absgrad:
        carrier = torch.zeros_like(points).requires_grad_()
        carrier.register_hook(lambda sums: setattr(points, "absgrad", sums))
    ids = (camera_ids, gaussian_ids) if packed else (None, None)
    info.update(camera_ids=ids[0], gaussian_ids=ids[1], **values)
    info["radii"] = radii if version.has_two_radii else radii[..., 0]
    if version.has_batches:
        info["batch_ids"] = torch.zeros_like(camera_ids) if packed else None
    if not packed:
        return (info, lambda camera: points[camera],
                lambda camera: None if carrier is None else carrier[camera])

    def unpacked(rows: Tensor, camera: int) -> Tensor:
        own = camera_ids == camera
        whole = rows.new_zeros(count, 2)
        return whole.index_put((gaussian_ids[own],), rows[own])

    return (info, lambda camera: unpacked(points, camera),
            lambda camera: None if carrier is None else unpacked(carrier, camera))


def _shaped(value: Any, name: str, shape: Tuple[Optional[int], ...]) -> Tensor:
    tensor = checked(value, f"{_WHO}: {name}")
    if tensor.dim() != len(shape) or any(
            wanted is not None and wanted != size for wanted, size in zip(shape, tensor.shape)):
        text = ", ".join("any" if size is None else str(size) for size in shape)
        raise UsageError(f"{_WHO}: {name} has the shape {tuple(tensor.shape)} instead of ({text}): "
                         "batches of scenes are drawn one by one")
    return tensor


def _refuse(others: Dict[str, Any], camera_model: str, distributed: bool, segmented: bool,
            tile_size: Optional[int], render_mode: str, rasterize_mode: str, sparse_grad: bool,
            packed: bool) -> None:
    """Raises UsageError for the arguments that quadsplat does not have."""
    if camera_model != "pinhole":
        raise UsageError(f"{_WHO}: camera_model: {camera_model!r} is not drawn, only 'pinhole': "
                         "remove the distortion of the photographs first")
    if distributed:
        raise UsageError(f"{_WHO}: distributed: one process draws: leave it off")
    if segmented:
        raise UsageError(f"{_WHO}: segmented: it is a way of sorting on a GPU: leave it off")
    if tile_size not in (None, 16):
        raise UsageError(f"{_WHO}: tile_size: {tile_size} is not 16")
    if render_mode not in _MODES:
        raise UsageError(f"{_WHO}: render_mode: {render_mode!r} is none of {', '.join(_MODES)}")
    if rasterize_mode not in ("classic", "antialiased"):
        raise UsageError(f"{_WHO}: rasterize_mode: {rasterize_mode!r} is neither 'classic' nor "
                         "'antialiased'")
    if sparse_grad and not packed:
        raise UsageError(f"{_WHO}: sparse_grad needs packed=True")
    for name, value in others.items():
        if name == "global_z_order" and value is True:
            continue
        if value is not None and value is not False:
            raise UsageError(f"{_WHO}: {name} is not supported: use pinhole cameras without "
                             "distortion, and channels of colors for other values")


def compute_relocation(opacities: Tensor, scales: Tensor, ratios: Tensor, binoms: Any = None,
                       n_max: Any = None) -> Tuple[Tensor, Tensor]:
    """Opacities and scales of relocated Gaussians (MCMC). binoms and n_max are ignored."""
    given = [checked(tensor, f"gsplat.compute_relocation: {name}").detach().cpu() for tensor, name in
             ((opacities, "opacities"), (scales, "scales"))]
    made = _parts.relocate(*given, torch.as_tensor(ratios).cpu())
    new_opacities, new_scales = (torch.from_numpy(array).to(opacities.device) for array in made)
    return new_opacities, new_scales


def adam(param: Tensor, param_grad: Tensor, exp_avg: Tensor, exp_avg_sq: Tensor,
         valid: Optional[Tensor], lr: float, b1: float, b2: float, eps: float) -> None:
    """A step of Adam for the valid rows, without correction of the moments."""
    _adam(param, param_grad, exp_avg, exp_avg_sq, None if valid is None else valid.bool(), lr,
          (b1, b2), eps)


def quat_scale_to_covar_preci(quats: Tensor, scales: Tensor, compute_covar: bool = True,
                              compute_preci: bool = True,
                              triu: bool = False) -> Tuple[Optional[Tensor], Optional[Tensor]]:
    """Covariances of N quaternions and standard deviations, and their inverses.

    Returns N x 3 x 3 each, or N x 6 with `triu`: xx xy xz yy yz zz; None if not asked for.
    """
    w, x, y, z = torch.nn.functional.normalize(quats, dim=-1).unbind(-1)
    rotation = torch.stack([
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)
    rotation = rotation.reshape(*quats.shape[:-1], 3, 3)

    def squared(factors: Tensor) -> Tensor:
        half = rotation * factors.unsqueeze(-2)
        whole = half @ half.transpose(-1, -2)
        if not triu:
            return whole
        rows, columns = torch.triu_indices(3, 3)
        return whole[..., rows, columns]

    return (squared(scales) if compute_covar else None,
            squared(1 / scales) if compute_preci else None)
