# SPDX-License-Identifier: MIT
"""gsplat's rasterization() and the functions of its extension, versions 1.4 to 1.6."""
from __future__ import annotations

import functools
import itertools
import math
import re
import sys
import weakref
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

import torch

from .. import _ffi
from .._camera import Camera
from .._context import Context
from .._errors import UsageError
from ..torch import Rules, _functions, _plan, _rasterize
from ..torch._parts import adam as _adam
from ..torch._memory import follow_empty_cache
from ..torch._parts import Step, add_noise, covariances, relocated
from ..torch._tensors import checked, context_of, put_part
from . import _options

Tensor = torch.Tensor

follow_empty_cache()
_WHO = "gsplat.rasterization"
_MODES = ("RGB", "D", "ED", "RGB+D", "RGB+ED")
_CHANNELS = 32
_STAND_IN = (1, 5, 3)
#: Arguments that are not supported: what to do instead.
_INSTEAD = {
    "with_ut": "leave it off: Gaussians are projected as in 3DGS",
    "with_eval3d": "leave it off: Gaussians are evaluated on the picture, as in 3DGS",
    "global_z_order": "leave it on: Gaussians are ordered by view z",
    "extra_signals_sh_degree": "evaluate the SH, and pass the values as extra_signals",
    "return_normals": "pass the normals as extra_signals",
    "rays": "pass viewmats and Ks",
    "rolling_shutter": "use RollingShutterType.GLOBAL",
    "viewmats_rs": "use RollingShutterType.GLOBAL",
    "renderer_config": "leave it out: it belongs to with_eval3d",
}


class Info(dict):  # type: ignore[type-arg]
    """gsplat's third result. The sorted lists of (Gaussian, tile) pairs are not in it.

    later: gives the values that few programs read, when one of them is read.
    """

    _LATER = ("conics", "depths", "opacities")

    def __init__(self, later: Any = None) -> None:
        super().__init__()
        self._later = later
        if later is not None:
            self.update(dict.fromkeys(self._LATER))

    def _fill(self) -> None:
        if self._later is not None:
            later, self._later = self._later, None
            self.update(later())

    def __getitem__(self, key: str) -> Any:
        if key in self._LATER:
            self._fill()
        return super().__getitem__(key)

    def __iter__(self) -> Iterator[str]:  # its own, so that dict(info) reads the values by name
        return super().__iter__()

    def get(self, key: str, default: Any = None) -> Any:
        return self[key] if key in self else default

    def items(self) -> Any:
        self._fill()
        return super().items()

    def values(self) -> Any:
        self._fill()
        return super().values()

    def copy(self) -> Any:
        self._fill()
        return super().copy()

    def pop(self, key: str, *default: Any) -> Any:
        self._fill()
        return super().pop(key, *default)

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
    least_opacity: float  #: the least opacity of relocated Gaussians; 0: they are not clamped


def _version() -> _Version:
    return _version_of(str(getattr(sys.modules.get("gsplat"), "__version__", "")))


@functools.lru_cache(maxsize=None)
def _version_of(text: str) -> _Version:
    release = re.match(r"\d+(\.\d+){0,2}", text)
    number = tuple(map(int, release.group().split("."))) if release else _STAND_IN
    if number < (1, 5):
        return _Version("gsplat_1_4", "3dgs", 0.999, 0.0, False, False, 0)
    if number < (1, 6):
        return _Version("gsplat_1_5", "adr", 0.999, 0.0, True, number >= (1, 5, 3), 0)
    return _Version("gsplat_1_5", "adr", 0.99, 2.5e-5, True, True, 0.005)


def rasterization(
        means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, colors: Optional[Tensor],
        viewmats: Tensor, Ks: Tensor, width: int, height: int, near_plane: float = 0.01,
        far_plane: float = 1e10, radius_clip: float = 0.0, eps2d: float = 0.3,
        sh_degree: Optional[int] = None, packed: bool = True, tile_size: Optional[int] = None,
        backgrounds: Optional[Tensor] = None, render_mode: str = "RGB", sparse_grad: bool = False,
        absgrad: bool = False, rasterize_mode: str = "classic", channel_chunk: int = 32,
        distributed: bool = False, camera_model: str = "pinhole", segmented: bool = False,
        covars: Optional[Tensor] = None, extra_signals: Optional[Tensor] = None,
        **others: Any) -> Tuple[Tensor, Tensor, Info]:
    """Draws scenes of N Gaussians with C cameras each, as gsplat does.

    `..` are the dimensions of the scenes, of any number; a single scene has none.

    means: .. x N x 3. quats: .. x N x 4, w x y z. scales: .. x N x 3. opacities: .. x N.
    colors: .. x N x D or .. x C x N x D, or SH of .. x N x K x 3 or .. x C x N x K x 3 with
        sh_degree. Without `..` they belong to all scenes.
    viewmats: .. x C x 4 x 4, world to view. Ks: .. x C x 3 x 3, pixel i has its centre at i + 0.5.
    covars: .. x N x 3 x 3 in place of quats and scales. backgrounds: .. x C x D.
    packed: decides the shapes of the third result: a row per visible Gaussian of a camera and
        scene, or .. x C x N rows.
    render_mode: "RGB", "D", "ED", "RGB+D" or "RGB+ED"; ED is D over alpha.
    extra_signals: E more channels in the shapes of `colors`, over 0. The third result has their
        pictures as "render_extra_signals".

    Returns colours .. x C x height x width x X, alphas .. x C x height x width x 1, and a
    dictionary, whose means2d is a node of the graph with gradients in pixels, and .absgrad if
    `absgrad`. Raises UsageError for arguments that quadsplat does not have.
    """
    version = _version()
    _refuse(others, camera_model, distributed, segmented, tile_size, render_mode, rasterize_mode,
            sparse_grad, packed)
    sizes = _sizes(means, viewmats)
    if (sizes.cameras == 1 and not sizes.batch and covars is None and extra_signals is None
            and colors is not None and not sparse_grad and render_mode.startswith("RGB")
            and not viewmats.requires_grad):
        return _one_picture(version, sizes, means, quats, scales, opacities, colors, viewmats, Ks,
                            int(width), int(height), near_plane, far_plane, radius_clip, eps2d,
                            sh_degree, packed, backgrounds, render_mode, absgrad, rasterize_mode)
    ids: List[Tensor] = []  # numbers of the visible Gaussians, for sparse gradients
    if sparse_grad:
        if sizes.batch:
            raise UsageError(f"{_WHO}: sparse_grad: leave it off for scenes with leading dimensions")
        means, quats, scales = (
            _Sparse.apply(tensor, ids) if isinstance(tensor, Tensor) else tensor
            for tensor in (means, quats, scales))
    scenes, rows = sizes.scenes, (sizes.count,)
    given = {"means": scenes(means, "means", *rows, 3),
             "opacities": scenes(opacities, "opacities", *rows)}
    if covars is not None:
        whole = scenes(covars, "covars", *rows, 3, 3)
        given["covariances"] = torch.stack([whole[..., row, column] for row, column in (
            (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))], -1)
    else:
        given["rotations"] = scenes(quats, "quats", *rows, 4)
        given["scales"] = scenes(scales, "scales", *rows, 3)
    views = scenes(viewmats, "viewmats", sizes.cameras, 4, 4)
    lenses = scenes(Ks, "Ks", sizes.cameras, 3, 3)
    has_color = render_mode.startswith("RGB")
    has_depth = render_mode != "RGB"
    paint = _Paint(sizes, given["means"], colors if has_color else None, sh_degree, backgrounds,
                   extra_signals)
    outputs = ("color",) * paint.is_given + ("alpha",) + ("depth",) * has_depth
    context = context_of(None, _WHO, given["means"])
    frames = []
    numbers = _numbers(views, lenses)
    for scene, number in sizes.each():
        view = views[scene, number]
        inputs = {name: tensor[scene] for name, tensor in given.items()}
        inputs.update(paint.projected(scene, number))
        if view.requires_grad:  # else the position is the camera's
            inputs["position"] = torch.linalg.inv_ex(view)[0][:3, 3]
        plan = _plan_of(version, context, next(numbers), int(width), int(height), near_plane,
                        far_plane, radius_clip, eps2d, sh_degree, rasterize_mode, outputs)
        row = [inputs.get(name) for name in _plan.INPUTS]
        frame, blocks = _ffi.QsStageFrame(), _functions.new_blocks(row)
        edge = _functions.Project.apply(plan, frame, blocks, view, *row)
        frames.append((plan, frame, blocks, edge, inputs))
    info, centres, absolute = _info(version, [frame[3] for frame in frames], packed, absgrad, sizes)
    if packed:
        ids.append(info["gaussian_ids"])
    drawn = []
    for at, (scene, number) in enumerate(sizes.each()):
        plan, frame, blocks, edge, inputs = frames[at]
        blended, own_colors = paint.blended(scene, number, inputs, edge[4])
        row = [blended.get(name) for name in _plan.INPUTS]
        drawn.append(_functions.Blend.apply(
            plan, frame, blocks, centres(at), *edge[1:4], own_colors, absolute(at),
            blended.get("channels"), blended.get("background"),
            *(None if tensor is None else tensor.detach() for tensor in row)))

    def stacked(place: int) -> Tensor:
        pictures = _stacked([pictures[place] for pictures in drawn])
        return pictures.reshape(*sizes.batch, sizes.cameras, *pictures.shape[1:])

    alphas = stacked(1).unsqueeze(-1)
    parts = []
    if paint.is_given:
        channels = stacked(0)
        if has_color:
            parts.append(channels[..., : paint.own])
        if extra_signals is not None:
            info["render_extra_signals"] = channels[..., paint.own:]
    if has_depth:
        depth = stacked(2).unsqueeze(-1)
        parts.append(depth / alphas.clamp(min=1e-10) if render_mode.endswith("ED") else depth)
    _add_sizes(info, int(width), int(height), sizes.cameras)
    if version.has_batches:
        info["n_batches"] = sizes.number
    return parts[0] if len(parts) == 1 else torch.cat(parts, -1), alphas, info


def _one_picture(version: _Version, sizes: _Sizes, means: Tensor, quats: Tensor, scales: Tensor,
                 opacities: Tensor, colors: Tensor, viewmats: Tensor, Ks: Tensor, width: int,
                 height: int, near: float, far: float, clip: float, dilation: float,
                 sh_degree: Optional[int], packed: bool, backgrounds: Optional[Tensor],
                 render_mode: str, absgrad: bool,
                 rasterize_mode: str) -> Tuple[Tensor, Tensor, Info]:
    """rasterization() of the usual call, a scene and a camera, in few operations of torch."""
    count = sizes.count
    given: Dict[str, Optional[Tensor]] = {
        "means": _shaped(means, "means", (count, 3)),
        "rotations": _shaped(quats, "quats", (count, 4)),
        "scales": _shaped(scales, "scales", (count, 3)),
        "opacities": _shaped(opacities, "opacities", (count,))}
    paint = _tensor(colors, "colors")
    if paint.dim() == (3 if sh_degree is None else 4):
        paint = paint[0]
    if sh_degree is None:
        given["channels"] = _shaped(paint, "colors", (count, None))
        if not 1 <= paint.shape[-1] <= _CHANNELS:
            raise UsageError(f"{_WHO}: {paint.shape[-1]} channels are not between 1 and "
                             f"{_CHANNELS}: draw them in parts")
    else:
        given["sh"] = _coefficients(_shaped(paint, "colors", (count, None, 3)), sh_degree)
    if backgrounds is not None:
        own = 3 if sh_degree is not None else paint.shape[-1]
        given["background"] = _shaped(backgrounds, "backgrounds", (1, own))[0]
    outputs = ("color", "alpha") if render_mode == "RGB" else ("color", "alpha", "depth")
    context = context_of(None, _WHO, means)
    camera, matrices = _ffi.QsCamera(), _ffi.QsMatrices()
    camera.width, camera.height, camera.near_depth = width, height, near
    for name, tensor, sides in (("view", _shaped(viewmats, "viewmats", (1, 4, 4)), (4, 4)),
                                ("lens", _shaped(Ks, "Ks", (1, 3, 3)), (3, 3))):
        put_part(matrices, name, tensor, sides, tensor.stride()[1:])
    _plan.camera_of(_WHO, {"view": "viewmats", "lens": "Ks"}, context, camera, matrices,
                    means.device)
    rules = _rules_of(version, camera, far, clip, dilation, sh_degree, rasterize_mode)
    plan = _plan.Plan(_WHO, context, camera, rules, outputs, False)
    row = [given.get(name) for name in _plan.INPUTS]
    shared = _functions.Shared(plan, absgrad)
    centres, radii = _functions.Centres.apply(shared, packed, *row)
    shared.points = weakref.ref(centres)
    color, alpha, depth, _ = _functions.Draw.apply(shared, centres, *row)

    def later() -> Dict[str, Tensor]:
        frame, blocks = _ffi.QsStageFrame(), _functions.new_blocks(row)
        _, *edge = _functions.Project.apply(plan, frame, blocks, None, *row)[:4]
        names = ("conics", "depths", "opacities")
        if packed:
            return {name: value[shared.ids] for name, value in zip(names, edge)}
        return {name: value[None] for name, value in zip(names, edge)}

    info = Info(later)
    ids = shared.ids
    camera_ids = None if ids is None else torch.zeros_like(ids)
    info.update(camera_ids=camera_ids, gaussian_ids=ids, means2d=centres,
                radii=radii if version.has_two_radii else radii[..., 0])
    if version.has_batches:
        info.update(batch_ids=camera_ids, n_batches=1)
    _add_sizes(info, width, height, 1)
    if depth is None:
        return color, alpha, info
    if render_mode.endswith("ED"):
        depth = depth / alpha.clamp(min=1e-10)
    return torch.cat([color, depth], -1), alpha, info


def _add_sizes(info: Info, width: int, height: int, cameras: int) -> None:
    info.update(width=width, height=height, tile_width=-(-width // 16),
                tile_height=-(-height // 16), tile_size=16, n_cameras=cameras)


def _stacked(tensors: List[Tensor]) -> Tensor:
    """torch.stack() without a copy of a single tensor."""
    return tensors[0][None] if len(tensors) == 1 else torch.stack(tensors)


class _Sizes(NamedTuple):
    """The sizes of a call: the dimensions of the scenes, Gaussians, and cameras of a scene."""

    batch: Tuple[int, ...]
    count: int
    cameras: int

    @property
    def number(self) -> int:
        """Of scenes."""
        return math.prod(self.batch)

    def each(self) -> Iterator[Tuple[int, int]]:
        """The numbers of scene and camera of every picture."""
        return itertools.product(range(self.number), range(self.cameras))

    def scenes(self, value: Any, name: str, *shape: Optional[int]) -> Tensor:
        """A tensor of batch x shape, as scenes x shape."""
        whole = _shaped(value, name, (*self.batch, *shape))
        return whole.reshape(self.number, *whole.shape[len(self.batch):])

    def pictures(self, value: Any, name: str, *shape: Optional[int]) -> Tensor:
        """A tensor of batch x shape, batch x cameras x shape or shape, as scenes x cameras x
        shape. Nothing is copied."""
        whole = _tensor(value, name)
        if self.batch and whole.dim() == len(shape):
            whole = _shaped(whole, name, shape)[None, None]
        elif whole.dim() == len(self.batch) + 1 + len(shape):
            whole = self.scenes(whole, name, self.cameras, *shape)
        else:
            whole = self.scenes(whole, name, *shape)[:, None]
        return whole.expand(self.number, self.cameras, *whole.shape[2:])


def _sizes(means: Any, viewmats: Any) -> _Sizes:
    points, views = _tensor(means, "means"), _tensor(viewmats, "viewmats")
    for tensor, name, least in ((points, "means", 2), (views, "viewmats", 3)):
        if tensor.dim() < least:
            raise UsageError(f"{_WHO}: {name} has {tensor.dim()} dimensions instead of {least} or "
                             "more")
    batch = tuple(points.shape[:-2])
    if 0 in batch:
        raise UsageError(f"{_WHO}: means has no scene: its shape is {tuple(points.shape)}")
    if views.shape[-3] == 0:
        raise UsageError(f"{_WHO}: viewmats has no camera")
    return _Sizes(batch, points.shape[-2], views.shape[-3])


class _Paint:
    """The channels of Gaussians: colours or SH, and signals behind them.

    Signals behind SH are blended with the colours that project() made of the SH, so all channels
    are drawn together.
    """

    def __init__(self, sizes: _Sizes, means: Tensor, colors: Optional[Tensor],
                 sh_degree: Optional[int], backgrounds: Optional[Tensor],
                 signals: Optional[Tensor]) -> None:
        self._none = means.new_zeros(sizes.count, 1)  # a channel of pictures without channels
        self._sh: Optional[Tensor] = None
        self._channels: Optional[Tensor] = None
        self._background: Optional[Tensor] = None
        self._signals: Optional[Tensor] = None
        self.own = 0  #: the number of channels of the colours
        if colors is not None and sh_degree is not None:
            self._sh, self.own = _harmonics(sizes, colors, sh_degree), 3
        elif colors is not None:
            self._channels = sizes.pictures(colors, "colors", sizes.count, None)
            self.own = self._channels.shape[-1]
        if signals is not None:
            self._signals = sizes.pictures(signals, "extra_signals", sizes.count, None)
        if backgrounds is not None and colors is not None:
            self._background = sizes.scenes(backgrounds, "backgrounds", sizes.cameras, self.own)
        self.is_given = colors is not None or signals is not None
        whole = self.own + (0 if self._signals is None else self._signals.shape[-1])
        if self.is_given and not 1 <= whole <= _CHANNELS:
            raise UsageError(f"{_WHO}: {whole} channels are not between 1 and {_CHANNELS}: draw "
                             "them in parts")

    def projected(self, scene: int, number: int) -> Dict[str, Tensor]:
        """The inputs of project() for a camera."""
        if self._sh is not None:
            inputs = {"sh": self._sh[scene, number]}
        elif self._channels is not None:
            inputs = {"channels": self._channels[scene, number]}
        else:
            inputs = {"channels": self._none}
        if self._background is not None:
            inputs["background"] = self._background[scene, number]
        return inputs

    def blended(self, scene: int, number: int, inputs: Dict[str, Tensor],
                colors: Optional[Tensor]) -> Tuple[Dict[str, Tensor], Optional[Tensor]]:
        """The inputs of blend(), and the colours of the boundary if it reads them.

        inputs, colors: of project().
        """
        if self._signals is None:
            return inputs, colors
        signals = self._signals[scene, number]
        own = inputs.get("channels") if self.own else None
        before = [tensor for tensor in (colors, own) if tensor is not None]
        inputs = {**inputs, "channels": torch.cat([*before, signals], -1)}
        inputs.pop("sh", None)
        if "background" in inputs:
            background = inputs["background"]
            inputs["background"] = torch.cat([background, background.new_zeros(signals.shape[-1])])
        return inputs, None


def _harmonics(sizes: _Sizes, colors: Tensor, sh_degree: int) -> Tensor:
    """SH of the coefficients of a degree, scenes x cameras x N x K x 3."""
    return _coefficients(sizes.pictures(colors, "colors", sizes.count, None, 3), sh_degree)


def _coefficients(sh: Tensor, sh_degree: int) -> Tensor:
    """SH of 1, 4, 9 or 16 coefficients, of .. x K x 3: K as given, or those of the degree."""
    if not 0 <= sh_degree <= 3:
        raise UsageError(f"{_WHO}: sh_degree: {sh_degree} is not between 0 and 3")
    used = (sh_degree + 1) ** 2
    if sh.shape[-2] < used:
        raise UsageError(f"{_WHO}: {sh.shape[-2]} coefficients are too few for degree "
                         f"{sh_degree}")
    return sh if sh.shape[-2] in (1, 4, 9, 16) else sh[..., :used, :]


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


class _Numbers(NamedTuple):
    """The matrices of a camera on the host."""

    view: List[List[float]]
    intrinsics: List[List[float]]


def _numbers(views: Tensor, lenses: Tensor) -> Iterator[_Numbers]:
    """The matrices of all pictures, with one copy from a GPU."""
    pictures = views.shape[0] * views.shape[1]
    rows = torch.cat([views.detach().double().reshape(pictures, 16),
                      lenses.detach().to(views.device).double().reshape(pictures, 9)], 1).tolist()
    for row in rows:
        yield _Numbers([row[at:at + 4] for at in range(0, 16, 4)],
                       [row[at:at + 3] for at in range(16, 25, 3)])


def _plan_of(version: _Version, context: Context, numbers: _Numbers, width: int, height: int,
             near: float, far: float, clip: float, dilation: float, sh_degree: Optional[int],
             rasterize_mode: str, outputs: Tuple[str, ...]) -> _plan.Plan:
    (fx, skew, cx), (_, fy, cy) = numbers.intrinsics[:2]
    if skew != 0:
        raise UsageError(f"{_WHO}: Ks has a skew, which quadsplat does not have")
    camera = Camera(width, height, (fx, fy), (cx - 0.5, cy - 0.5), near_depth=near)
    rules = _rules_of(version, camera._struct, far, clip, dilation, sh_degree, rasterize_mode)
    struct, _ = _rasterize._camera(_WHO, camera, None)
    _rasterize.set_pose(struct, numbers.view, f"{_WHO}: viewmats")
    return _plan.Plan(_WHO, context, struct, rules, outputs, False)


def _rules_of(version: _Version, camera: _ffi.QsCamera, far: float, clip: float, dilation: float,
              sh_degree: Optional[int], rasterize_mode: str) -> _ffi.QsRules:
    lens = tuple(zip((camera.width, camera.height), camera.focal_px, camera.center_px))
    return _rules(version, _options.cull() or version.mode, lens, float(far), float(clip),
                  float(dilation), sh_degree or 0, rasterize_mode == "antialiased")


@functools.lru_cache(maxsize=256)
def _rules(version: _Version, cull: str, lens: Tuple[Tuple[int, float, float], ...], far: float,
           clip: float, dilation: float, sh_degree: int, antialiased: bool) -> _ffi.QsRules:
    """The rules, which nobody changes. lens: size, focal length and centre of each axis, pixels."""
    rules = _rasterize.struct_of(_WHO, Rules(
        cull=cull, sh_degree=sh_degree, far_depth=far, dilation_px2=dilation,
        antialiased=antialiased, compensation_floor=version.compensation_floor,
        alpha_max=version.alpha_max, alpha_max_blocks=True, stops_at_equal=True,
        zero_color_passes=True, radius_clip_px=clip, radius_rule=version.radius_rule))
    own = _ffi.QsRules.from_buffer_copy(rules)
    for axis, (size, focal, first) in enumerate(lens):
        center = first + 0.5
        margin = 0.3 * 0.5 * size / focal
        own.slope_low[axis] = -(center / focal + margin)
        own.slope_high[axis] = (size - center) / focal + margin
    return own


def _info(version: _Version, edges: Any, packed: bool, absgrad: bool, sizes: _Sizes) -> Any:
    """The dictionary, and functions from the number of a picture to its centres and absolute sums,
    N x 2.

    Centres at pixels are at halves there.
    """
    info = Info()
    radii = _stacked([edge[5] for edge in edges])
    names = {"means2d": 0, "conics": 1, "depths": 2, "opacities": 3}
    values = {name: _stacked([edge[place] for edge in edges]) for name, place in names.items()}
    seen = (radii > 0).all(-1)
    if packed:
        picture_ids, gaussian_ids = torch.nonzero(seen, as_tuple=True)
        values = {name: value[picture_ids, gaussian_ids] for name, value in values.items()}
        radii = radii[picture_ids, gaussian_ids]
        values["means2d"] = values["means2d"] + 0.5
    else:
        values["means2d"] = torch.where(seen[..., None], values["means2d"] + 0.5,
                                        values["means2d"].new_zeros(()))
        whole = (*sizes.batch, sizes.cameras)
        values = {name: value.reshape(*whole, *value.shape[1:]) for name, value in values.items()}
        radii = radii.reshape(*whole, *radii.shape[1:])
    points, carrier = values["means2d"], None
    if absgrad:
        carrier = torch.zeros_like(points).requires_grad_()
        carrier.register_hook(lambda sums: setattr(points, "absgrad", sums))
    info.update(camera_ids=picture_ids % sizes.cameras if packed else None,
                gaussian_ids=gaussian_ids if packed else None, **values)
    info["radii"] = radii if version.has_two_radii else radii[..., 0]
    if version.has_batches:
        info["batch_ids"] = (torch.div(picture_ids, sizes.cameras, rounding_mode="floor") if packed
                             else None)

    def of_picture(rows: Optional[Tensor], number: int) -> Optional[Tensor]:
        if rows is None:
            return None
        if not packed:
            return rows.reshape(len(edges), sizes.count, 2)[number]
        if len(edges) == 1:  # all rows are its own
            return rows.new_zeros(sizes.count, 2).index_put((gaussian_ids,), rows)
        own = picture_ids == number
        return rows.new_zeros(sizes.count, 2).index_put((gaussian_ids[own],), rows[own])

    return (info, lambda number: of_picture(points, number),
            lambda number: of_picture(carrier, number))


def _tensor(value: Any, name: str) -> Tensor:
    return checked(value, f"{_WHO}: {name}", most_dimensions=64)  # torch's limit


def _shaped(value: Any, name: str, shape: Tuple[Optional[int], ...]) -> Tensor:
    tensor = _tensor(value, name)
    if tensor.dim() != len(shape) or any(
            wanted is not None and wanted != size for wanted, size in zip(shape, tensor.shape)):
        text = ", ".join("any" if size is None else str(size) for size in shape)
        raise UsageError(f"{_WHO}: {name} has the shape {tuple(tensor.shape)} instead of ({text})")
    return tensor


def _refuse(others: Dict[str, Any], camera_model: str, distributed: bool, segmented: bool,
            tile_size: Optional[int], render_mode: str, rasterize_mode: str, sparse_grad: bool,
            packed: bool) -> None:
    """Raises UsageError for the arguments that quadsplat does not have."""
    if camera_model != "pinhole":
        raise UsageError(f"{_WHO}: camera_model: {camera_model!r} is not drawn, only 'pinhole': "
                         "remove the distortion of the photographs first, or draw without derivatives "
                         "by quadsplat.render() and Camera(model=...)")
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
        # GLOBAL: of gsplat's RollingShutterType
        is_default = value is True if name == "global_z_order" else (
            value is None or value is False or getattr(value, "name", "") == "GLOBAL")
        if not is_default:
            instead = _INSTEAD.get(name, "use pinhole cameras without distortion")
            raise UsageError(f"{_WHO}: {name} is not supported: {instead}")


def compute_relocation(opacities: Tensor, scales: Tensor, ratios: Tensor, binoms: Any = None,
                       min_opacity: Optional[float] = None) -> Tuple[Tensor, Tensor]:
    """Opacities and scales of relocated Gaussians (MCMC). binoms is ignored.

    min_opacity: lower bound of the opacities, for which the scales are made too; 0: none; None:
        0.005 for gsplat from 1.6, else 0. With a bound they are also below 1.
    """
    who, names = "gsplat.compute_relocation", ("opacities", "scales")
    least = _version().least_opacity if min_opacity is None else min_opacity
    if least == 0:
        return relocated(opacities, scales, ratios, who, names)
    # A Gaussian whose copies have the bound, and the scales of these copies for the given opacity.
    copies = ratios.clamp(1, _ffi.MOST_COPIES)
    whole = torch.maximum(opacities, (1 - (1 - least) ** copies.double()).to(opacities.dtype))
    shared, sized = relocated(whole, scales, copies, who, names)
    return (shared.clamp(least, 1 - torch.finfo(torch.float32).eps),
            sized * (opacities / whole).unsqueeze(-1))


def _cuda_fused_mcmc_perturb(
        positions: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor,
        noise_scale: Optional[float] = None, *, scaler: Optional[float] = None, t: float = 0.005,
        k: float = 100.0) -> bool:
    """The noise of MCMC, gsplat 1.6: True if it was added. False: gsplat adds it with torch.

    scales, opacities: logarithms and logits. noise_scale, or its older name scaler: the factor.
    """
    values = (positions, quats, scales, opacities)
    factor = scaler if noise_scale is None else noise_scale
    if factor is None or any(value.dtype != torch.float32 or not value.is_cuda for value in values):
        return False
    add_noise(positions, quats, scales, opacities.reshape(-1), torch.randn_like(positions),
              float(factor), float(k), float(t))
    return True


def adam(param: Tensor, param_grad: Tensor, exp_avg: Tensor, exp_avg_sq: Tensor,
         valid: Optional[Tensor], lr: float, b1: float, b2: float, eps: float) -> None:
    """A step of Adam for the valid rows, without correction of the moments."""
    _adam([Step(param, param_grad, exp_avg, exp_avg_sq, lr, (b1, b2), eps)],
          None if valid is None else valid.bool())


@functools.lru_cache(maxsize=None)
def _rotation_of_products(dtype: torch.dtype, device: torch.device) -> Tensor:
    """16 x 9: a rotation, row by row, from the products of two numbers of its quaternion w x y z."""
    w, x, y, z = range(4)
    terms = (((w, w, 1), (x, x, 1), (y, y, -1), (z, z, -1)), ((x, y, 2), (w, z, -2)),
             ((x, z, 2), (w, y, 2)), ((x, y, 2), (w, z, 2)),
             ((w, w, 1), (x, x, -1), (y, y, 1), (z, z, -1)), ((y, z, 2), (w, x, -2)),
             ((x, z, 2), (w, y, -2)), ((y, z, 2), (w, x, 2)),
             ((w, w, 1), (x, x, -1), (y, y, -1), (z, z, 1)))
    matrix = torch.zeros(16, 9, dtype=dtype)
    for element, factors in enumerate(terms):
        for a, b, factor in factors:
            matrix[4 * a + b, element] += factor
    return matrix.to(device)


def quat_scale_to_covar_preci(quats: Tensor, scales: Tensor, compute_covar: bool = True,
                              compute_preci: bool = True,
                              triu: bool = False) -> Tuple[Optional[Tensor], Optional[Tensor]]:
    """Covariances of N quaternions and standard deviations, and their inverses.

    Returns N x 3 x 3 each, or N x 6 with `triu`: xx xy xz yy yz zz; None if not asked for.
    """
    if (quats.is_cuda and quats.dim() == 2 and quats.dtype == scales.dtype == torch.float32
            and not (torch.is_grad_enabled() and (quats.requires_grad or scales.requires_grad))):
        shape = (6,) if triu else (3, 3)
        return (covariances(quats, scales, shape) if compute_covar else None,
                covariances(quats, 1 / scales, shape) if compute_preci else None)
    unit = torch.nn.functional.normalize(quats, dim=-1)
    products = (unit.unsqueeze(-1) * unit.unsqueeze(-2)).flatten(-2)  # ww wx wy wz xw xx ..
    rotation = products @ _rotation_of_products(unit.dtype, unit.device)
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
