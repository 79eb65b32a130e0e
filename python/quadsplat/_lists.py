# SPDX-License-Identifier: MIT
"""The decisions of a frame: footprints, tile lists, and the pairs of every culling mode."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, NamedTuple

import numpy as np

from . import _ffi, _settings
from ._arrays import copy_of
from ._camera import Camera
from ._checks import integer
from ._errors import UsageError
from ._render import _require_scene
from ._scene import Scene


class TileLists(NamedTuple):
    """V visible Gaussians in the order of their numbers, T tiles row by row, P pairs.

    In mode "reference" a single list has all Gaussians.
    """

    tile_px: int  #: side of a tile
    tile_rows: int
    tile_columns: int
    gaussians: np.ndarray  #: V, uint32: number of the Gaussian
    depths: np.ndarray  #: V, float32: view z
    means_px: np.ndarray  #: V x 2, float32: pixels
    covariances: np.ndarray  #: V x 3, float32: xx xy yy, px^2, dilated
    conics: np.ndarray  #: V x 3, float32: a b c, the inverse of the covariance
    opacities: np.ndarray  #: V, float32: at the centre, with compensation
    colors: np.ndarray  #: V x 3, float32: RGB as seen by the camera
    tile_begin: np.ndarray  #: T + 1, uint64: begin and end of every list in `listed`
    listed: np.ndarray  #: P, uint32: numbers of Gaussians, front to back

    def of_tile(self, row: int, column: int) -> np.ndarray:
        """The numbers of a tile's Gaussians, front to back. Raises UsageError."""
        y = integer(row, "TileLists.of_tile: row", 0, self.tile_rows - 1)
        x = integer(column, "TileLists.of_tile: column", 0, self.tile_columns - 1)
        tile = y * self.tile_columns + x
        return self.listed[int(self.tile_begin[tile]):int(self.tile_begin[tile + 1])]

    def pairs(self) -> np.ndarray:
        """Tile rows x tile columns, int64: the number of pairs of every tile."""
        return np.diff(self.tile_begin.astype(np.int64)).reshape(self.tile_rows, self.tile_columns)


class ModeCount(NamedTuple):
    """The size of a view's frame in a culling mode."""

    tile_pairs: int  #: (Gaussian, tile) pairs listed
    visible: int  #: Gaussians with at least one tile


def tile_lists(scene: Scene, camera: Camera, **settings: Any) -> TileLists:
    """The tile lists of a view in a culling mode, without drawing it. The arrays are copies.

    settings: as for render(), `cull` above all.

    Raises UsageError, DeviceError, and Cancelled after Context.stop().
    """
    who = "tile_lists"
    struct = _settings_of(scene, camera, settings, who)
    lists = _ffi.QsLists()
    with scene.context._use(who):
        _ffi.call(who, "qs_lists", scene._pointer(who), ctypes.byref(camera._struct),
                  ctypes.byref(struct), ctypes.byref(lists))
        numbers = (lists.tile_px, lists.tile_rows, lists.tile_columns)
        arrays = (copy_of(getattr(lists, name)) for name in TileLists._fields[len(numbers):])
        return TileLists(*numbers, *arrays)


def counts(scene: Scene, camera: Camera, **settings: Any) -> Dict[str, ModeCount]:
    """The pairs of a view in every culling mode, by name, without drawing it.

    Modes of other papers and "reference" are left out: for these, see tile_lists().
    settings: as for render(), without `cull`.

    Raises UsageError, DeviceError, and Cancelled after Context.stop().
    """
    who = "counts"
    if "cull" in settings or "mode" in settings:
        raise UsageError(f"{who}: cull is not a setting here: every mode is counted")
    struct = _settings_of(scene, camera, settings, who)
    number = ctypes.c_uint64()
    with scene.context._use(who):
        call = ("qs_count_modes", scene._pointer(who), ctypes.byref(camera._struct),
                ctypes.byref(struct))
        _ffi.call(who, *call, None, 0, ctypes.byref(number))
        found = _ffi.array_of(_ffi.QsModeCounts, number.value)
        _ffi.call(who, *call, found, len(found), ctypes.byref(number))
    return {_ffi.text(mode.name): ModeCount(mode.tile_pairs, mode.visible) for mode in found}


def _settings_of(scene: Any, camera: Any, settings: Dict[str, Any], who: str) -> _ffi.QsSettings:
    _require_scene(scene, who)
    if not isinstance(camera, Camera):
        raise UsageError(f"{who}: camera is {type(camera).__name__} instead of a quadsplat.Camera")
    return _settings.struct_of(who, settings, scene.facts.white_background)
