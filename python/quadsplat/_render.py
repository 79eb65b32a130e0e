# SPDX-License-Identifier: MIT
"""Rendering views."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union, overload

import numpy as np

from . import _ffi, _settings
from ._arrays import TYPES, element_type, mark_changed, struct_of, writable
from ._camera import Camera
from ._checks import words
from ._errors import UsageError
from ._gpu_arrays import GpuArray, is_on_gpu
from ._picture import Counts, Picture
from ._scene import Scene

#: The arrays of a picture: True if the array has an element per tile instead of per pixel.
_OUTPUTS = {"color": False, "alpha": False, "depth": False, "median_depth": False,
            "evaluated": False, "pairs": True, "used": True}
_COUNTED = ("evaluated", "pairs", "used")
_DTYPES = ("float32", "uint8")

_Names = Union[str, Sequence[str], None]
_ByOutput = Mapping[str, Any]  # arrays by output


@overload
def render(scene: Scene, cameras: Camera, *, outputs: _Names = ..., dtype: Any = ...,
           out: Optional[_ByOutput] = ..., **settings: Any) -> Picture: ...


@overload
def render(scene: Scene, cameras: Sequence[Camera], *, outputs: _Names = ..., dtype: Any = ...,
           out: Optional[Sequence[_ByOutput]] = ..., **settings: Any) -> List[Picture]: ...


def render(scene: Scene, cameras: Union[Camera, Sequence[Camera]], *, outputs: _Names = None,
           dtype: Any = "float32", out: Union[None, _ByOutput, Sequence[_ByOutput]] = None,
           **settings: Any) -> Union[Picture, List[Picture]]:
    """Renders one view, or a list of views.

    cameras: a Camera gives a Picture, and a sequence of cameras gives a list of pictures.
    outputs: one or several of "color", "alpha", "depth", "median_depth", "evaluated", "pairs" and
        "used": see Picture. Other arrays are not computed. Counts are always part of a picture.
        None: the outputs in `out`, or "color".
    dtype: of color and alpha, "float32" or "uint8", floor(255 * clamp(x, 0, 1) + 0.5).
    out: arrays to fill, by output, with the shapes and types of Picture: numpy's, or color, alpha,
        depth and median_depth of torch, CuPy or others in the memory of the scene's GPU, which are
        not copied through the host. A list of cameras takes a list of them.
    settings: of quadsplat.Settings: cull, pipeline, background, splat_scale, dilation_px2,
        sh_degree, antialiased, tile_px.

    The program `quadsplat render` draws the same values. The first call uploads the scene.

    Raises UsageError, DeviceError, and Cancelled after Context.stop().
    """
    who = "render"
    _require_scene(scene, who)
    if "backend" in settings:
        raise UsageError(f"{who}: backend is not a setting: the scene's context has it: load the "
                         f"scene with context=quadsplat.Context({settings['backend']!r})")
    views = [cameras] if isinstance(cameras, Camera) else _list_of_cameras(cameras, who)
    element = element_type(dtype, f"{who}: dtype", _DTYPES)
    chosen = _settings.struct_of(who, settings, scene.facts.white_background)
    made = []
    for camera, own in zip(views, _arrays_given(out, len(views), isinstance(cameras, Camera), who)):
        names = words(tuple(own) or "color" if outputs is None else outputs, f"{who}: outputs",
                      _OUTPUTS)
        missing = tuple(name for name in names if name not in own)
        made.append({**_arrays_of(camera, missing, element, chosen.tile_px), **own})
    structs = (_ffi.QsCamera * len(views))(*[camera._struct for camera in views])
    pictures, counts = _ffi.array_of(_ffi.QsPicture, len(views)), _ffi.array_of(
        _ffi.QsCounts, len(views))
    for picture, arrays, numbers in zip(pictures, made, counts):
        picture.counts = ctypes.pointer(numbers)
        for name, array in arrays.items():
            where = f"{who}: {name}"
            if is_on_gpu(array):
                on_gpu = GpuArray(array, where)
                on_gpu.require_writable(where)
                setattr(picture, name, on_gpu.struct())
                picture.stream = on_gpu.stream
            else:
                setattr(picture, name, struct_of(_writable(array, where)))
    with scene.context._use(who):
        _ffi.call(who, "qs_render", scene._pointer(who), structs, len(views),
                  ctypes.byref(chosen), pictures)
    cull = chosen.cull.decode()
    results = []
    for camera, arrays, numbers in zip(views, made, counts):
        result = Picture(camera, cull, _counts(numbers))
        for name, array in arrays.items():
            setattr(result, name, array)
            mark_changed(array)
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


def _arrays_given(out: Any, views: int, is_one: bool, who: str) -> List[_ByOutput]:
    """The arrays to fill, by view. Raises UsageError."""
    if out is None:
        return [{}] * views
    whole = [out] if is_one else list(out) if isinstance(out, (list, tuple)) else [None]
    for arrays in whole:
        if not isinstance(arrays, Mapping):
            raise UsageError(f"{who}: out is not a dictionary of arrays by output"
                             + ("" if is_one else " for each camera"))
        words(arrays, f"{who}: out", _OUTPUTS)
    if len(whole) != views:
        raise UsageError(f"{who}: out has {len(whole)} dictionaries for {views} cameras")
    return whole


def _writable(array: Any, where: str) -> np.ndarray:
    own = writable(array, where)
    if own.dtype not in TYPES:
        raise UsageError(f"{where} has elements of type {own.dtype}")
    if not own.flags.aligned or any(stride % own.itemsize for stride in own.strides):
        raise UsageError(f"{where} is not an array of whole aligned elements")
    return own


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
