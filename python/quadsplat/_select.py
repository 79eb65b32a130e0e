# SPDX-License-Identifier: MIT
"""Selections of Gaussians, and points of surfaces."""
from __future__ import annotations

import ctypes
import json
from os import PathLike
from pathlib import Path as FilePath
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _ffi
from ._arrays import struct_of, to_numpy
from ._camera import Camera
from ._checks import encoded
from ._errors import InputError, UsageError
from ._lists import _settings_of
from ._scene import Edited

Step = Mapping[str, Any]


class SurfacePoint(NamedTuple):
    """The point of the surface that a pixel shows. Lengths are in world units."""

    position: np.ndarray  #: world, float64
    direction: np.ndarray  #: from the eye, a unit vector
    distance: float  #: from the eye
    along: float  #: standard deviation along the ray
    across: float  #: and across it
    to_next: float  #: standard deviation of the distance to the next pixel's point; NaN without one


def edited(scene: Any, edits: Union[str, "PathLike[str]", Sequence[Step]], who: str) -> Edited:
    """See Scene.edit()."""
    if isinstance(edits, (str, PathLike)):
        try:
            text = FilePath(edits).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{who}: {edits}: {error}") from None
    else:
        text = _text_of(edits, who)
    count = len(scene)
    arrays = [np.zeros(count, np.uint8) for _ in range(2)]
    with scene.context._use(who):
        _ffi.call(who, "qs_select", scene._pointer(who), encoded(text, f"{who}: edits"),
                  *(ctypes.byref(struct_of(array)) for array in arrays))
    return Edited(*(array.astype(bool) for array in arrays))


def measure(scene: Any, camera: Camera, pixels: Any, **settings: Any) -> List[Optional[SurfacePoint]]:
    """The points of the surface that pixels of a view show, where half of their light is stopped.

    pixels: N x 2, integers x, y from the top left.
    settings: as for render().

    An element is None if more than half of the light passes. The distance of neighbours a, b is
    numpy.linalg.norm(b.position - a.position), with the standard deviation a.to_next. Raises
    UsageError, DeviceError, and Cancelled after Context.stop().
    """
    who = "measure"
    struct = _settings_of(scene, camera, settings, who)
    given = to_numpy(pixels, f"{who}: pixels")
    if given.ndim != 2 or given.shape[1] != 2 or not np.array_equal(given, np.floor(given)):
        raise UsageError(f"{who}: pixels is no list of whole numbers x, y")
    chosen = np.ascontiguousarray(np.clip(given, -1, 2**31 - 1), np.int32)
    points = _ffi.array_of(_ffi.QsSurfacePoint, len(chosen))
    with scene.context._use(who):
        _ffi.call(who, "qs_measure", scene._pointer(who), ctypes.byref(camera._struct),
                  ctypes.byref(struct), chosen.ctypes.data, len(chosen), points)
    return [None if np.isnan(point.distance) else
            SurfacePoint(np.array(point.position), np.array(point.direction), point.distance,
                         point.along, point.across, point.to_next) for point in points]


def _text_of(steps: Sequence[Step], who: str) -> str:
    """The text of a file of edits."""
    listed: List[Dict[str, Any]] = []
    for step in steps:
        if not isinstance(step, Mapping):
            raise UsageError(f"{who}: {step!r} is no mapping: see docs/formats.md, section Edits")
        listed.append({"step": "select", **step})
    try:
        return json.dumps({"version": 1, "steps": listed}, default=_plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{who}: {error}") from None


def _plain(value: Any) -> Any:
    """A camera in the layout of cameras.json, and arrays as lists."""
    if isinstance(value, Camera):
        matrix = value.view_from_world
        fx, fy = value.focal_px
        cx, cy = value.center_px
        return {"width": value.width, "height": value.height, "fx": fx, "fy": fy, "cx": cx + 0.5,
                "cy": cy + 0.5, "near": value.near_depth, "position": value.position.tolist(),
                "rotation": matrix[:3, :3].T.tolist(), "translation": matrix[:3, 3].tolist()}
    return to_numpy(value, "select").tolist()


def steps_of(steps: Tuple[Step, ...], step: Dict[str, Any], who: str) -> List[Step]:
    """The steps of Scene.select()."""
    if not steps and not step:
        raise UsageError(f'{who}: no step was given, such as tool="sphere", point=(0, 0, 0), radius=1')
    return [*steps, step] if step else list(steps)
