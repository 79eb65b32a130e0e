# SPDX-License-Identifier: MIT
"""Rendering views."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple, Union, overload

import numpy as np

from . import _ffi, _settings
from ._arrays import struct_of
from ._camera import Camera
from ._checks import choice, words
from ._errors import UsageError
from ._picture import Picture
from ._scene import Scene

#: The arrays of a picture: True if the array has an element per tile instead of per pixel.
_OUTPUTS = {"color": False, "alpha": False, "depth": False, "median_depth": False,
            "evaluated": False, "pairs": True, "used": True}
_COUNTED = ("evaluated", "pairs", "used")
_DTYPES = {"float32": np.float32, "uint8": np.uint8}


class Counts(NamedTuple):
    """The numbers of a frame."""

    gaussians: int  #: that can be drawn
    visible: int  #: Gaussians with at least one tile
    tile_pairs: int  #: (Gaussian, tile) pairs listed
    max_pairs_in_a_tile: int
    used_pairs: int  #: pairs that a pixel blended; 0 unless `used` was asked for
    sort_bytes: int  #: of the keys and values that were sorted
    tile_rows: int
    tile_columns: int
    tile_px: int  #: side of a tile
    pipeline: str  #: that drew the frame: "fast" leaves some views and tiles to "classic"
    threads: int  #: of the CPU; 0 on a GPU
    frame_ms: float  #: from the camera to the picture in the memory of the backend
    stage_ms: Dict[str, float]  #: "preprocess", "bin", "sort", "blend"; 0 on a GPU


@overload
def render(scene: Scene, cameras: Camera, *, outputs: Union[str, Sequence[str]] = ...,
           dtype: Any = ..., **settings: Any) -> Picture: ...


@overload
def render(scene: Scene, cameras: Sequence[Camera], *, outputs: Union[str, Sequence[str]] = ...,
           dtype: Any = ..., **settings: Any) -> List[Picture]: ...


def render(scene: Scene, cameras: Union[Camera, Sequence[Camera]], *,
           outputs: Union[str, Sequence[str]] = "color", dtype: Any = "float32",
           **settings: Any) -> Union[Picture, List[Picture]]:
    """Renders one view, or a list of views.

    cameras: a Camera gives a Picture, and a sequence of cameras gives a list of pictures.
    outputs: one or several of "color", "alpha", "depth", "median_depth", "evaluated", "pairs" and
        "used": see Picture. Other arrays are not computed. Counts are always part of a picture.
    dtype: of color and alpha, "float32" or "uint8", floor(255 * clamp(x, 0, 1) + 0.5).
    settings: of quadsplat.Settings: mode, pipeline, background, splat_scale, dilation_px2,
        sh_degree, antialiased, tile_px.

    The program `quadsplat render` draws the same values. The first call uploads the scene.

    Raises UsageError, DeviceError, and Cancelled after Context.stop().
    """
    who = "render"
    _require_scene(scene, who)
    views = [cameras] if isinstance(cameras, Camera) else _list_of_cameras(cameras, who)
    names = words(outputs, f"{who}: outputs", _OUTPUTS)
    element = _element(dtype, f"{who}: dtype")
    chosen = _settings.struct_of(who, settings, scene.facts.white_background)
    made = [_arrays_of(camera, names, element, chosen.tile_px) for camera in views]
    structs = (_ffi.QsCamera * len(views))(*[camera._struct for camera in views])
    pictures, counts = _ffi.array_of(_ffi.QsPicture, len(views)), _ffi.array_of(
        _ffi.QsCounts, len(views))
    for picture, arrays, numbers in zip(pictures, made, counts):
        picture.counts = ctypes.pointer(numbers)
        for name, array in arrays.items():
            setattr(picture, name, struct_of(array))
    with scene.context._use(who):
        _ffi.call(who, "qs_render", scene._pointer(who), structs, len(views),
                  ctypes.byref(chosen), pictures)
    mode = chosen.mode.decode()
    results = []
    for camera, arrays, numbers in zip(views, made, counts):
        result = Picture(camera, mode, _counts(numbers))
        for name, array in arrays.items():
            setattr(result, name, array)
        results.append(result)
    return results[0] if isinstance(cameras, Camera) else results


def _require_scene(scene: Any, who: str) -> None:
    if not isinstance(scene, Scene):
        raise UsageError(f"{who}: scene is {type(scene).__name__} instead of a quadsplat.Scene")


def _list_of_cameras(cameras: Any, who: str) -> List[Camera]:
    try:
        views = list(cameras)
    except TypeError:
        views = [None]
    for index, camera in enumerate(views):
        if not isinstance(camera, Camera):
            raise UsageError(f"{who}: cameras[{index}] is {type(camera).__name__} instead of a "
                             "quadsplat.Camera" if cameras is not None else
                             f"{who}: cameras is None")
    return views


def _element(dtype: Any, where: str) -> Any:
    try:
        name = np.dtype(dtype).name
    except TypeError:
        name = dtype
    choice(name, where, dict.fromkeys(_DTYPES, 0))
    return _DTYPES[name]


def _arrays_of(camera: Camera, names: Tuple[str, ...], element: Any,
               tile_px: int) -> Dict[str, np.ndarray]:
    arrays = {}
    for name in names:
        if _OUTPUTS[name]:
            shape: Tuple[int, ...] = (-(-camera.height // tile_px), -(-camera.width // tile_px))
        else:
            shape = (camera.height, camera.width) + ((3,) if name == "color" else ())
        dtype = np.uint32 if name in _COUNTED else np.float32
        arrays[name] = np.empty(shape, element if name in ("color", "alpha") else dtype)
    return arrays


def _counts(numbers: _ffi.QsCounts) -> Counts:
    pipeline = {number: name for name, number in _ffi.PIPELINES.items()}[numbers.pipeline]
    return Counts(numbers.gaussians, numbers.visible, numbers.tile_pairs,
                  numbers.max_pairs_in_a_tile, numbers.used_pairs, numbers.sort_bytes,
                  numbers.tile_rows, numbers.tile_columns, numbers.tile_px, pipeline,
                  numbers.threads, numbers.frame_ms, dict(zip(_ffi.STAGES, numbers.stage_ms)))
