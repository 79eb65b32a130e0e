# SPDX-License-Identifier: MIT
"""Rendered views."""
from __future__ import annotations

import ctypes
import os
import tempfile
from os import PathLike
from typing import Any, Dict, NamedTuple, Optional, Union

import numpy as np

from . import _ffi
from ._arrays import struct_of, to_numpy
from ._camera import Camera
from ._checks import encoded_path
from ._compare import compare
from ._errors import UsageError

#: Maps whose values are not 0..1, so that files of 8 bits cannot hold them.
_UNBOUNDED = ("depth", "median_depth", "evaluated", "pairs", "used")
_FLOAT_FORMATS = (".npy", ".pfm", ".exr", ".tif", ".tiff")


class Counts(NamedTuple):
    """The numbers of a frame."""

    gaussians: int  #: that can be drawn
    visible: int  #: Gaussians with at least one tile
    tile_pairs: int  #: (Gaussian, tile) pairs listed
    max_pairs_in_a_tile: int
    used_pairs: int  #: pairs that a pixel blended; 0 unless `used` was asked for
    sort_bytes: int  #: size of the keys and values that were sorted
    tile_rows: int
    tile_columns: int
    tile_px: int  #: side of a tile
    pipeline: str  #: that drew the frame: "fast" leaves some views and tiles to "classic"
    threads: int  #: threads of the CPU; 0 on a GPU
    frame_ms: float  #: time from the camera to the picture in the memory of the backend
    stage_ms: Dict[str, float]  #: "preprocess", "bin", "sort", "blend"; 0 on a GPU


class Picture:
    """A rendered view. Arrays that were not asked for are None.

    It shows itself in a notebook, and numpy.asarray() gives its colours.
    """

    #: Height x width x 3, RGB, float32 nominally 0..1, or uint8 of 0..255.
    color: Optional[np.ndarray] = None
    #: Height x width, 1 - transmittance, float32 of 0..1, or uint8 of 0..255.
    alpha: Optional[np.ndarray] = None
    #: Height x width, float32: mean view z of the Gaussians by weight, 0 where alpha is 0.
    depth: Optional[np.ndarray] = None
    #: Height x width, float32: view z of the first Gaussian with a transmittance <= 1/2 behind it.
    median_depth: Optional[np.ndarray] = None
    #: Height x width, uint32: list entries up to where the pixel stopped.
    evaluated: Optional[np.ndarray] = None
    #: Tile rows x tile columns, uint32: (Gaussian, tile) pairs listed.
    pairs: Optional[np.ndarray] = None
    #: Tile rows x tile columns, uint32: pairs that a pixel blended.
    used: Optional[np.ndarray] = None

    def __init__(self, camera: Camera, cull: str, counts: Counts) -> None:
        self.camera = camera
        self.cull = cull  #: the culling mode
        self.counts = counts  #: the numbers of the frame

    def save(self, path: Union[str, PathLike[str]], what: str = "color",
             overwrite: bool = False) -> None:
        """Writes an array of the picture: .png, .ppm, .pfm or .npy, by the ending of the path.

        what: "color", "alpha", "depth", ... .png and .ppm store 8 bits of 0..1; depths and
            numbers go to .npy or .pfm.
        overwrite: an existing file is replaced. Pictures that quadsplat wrote as .png always are.

        Raises InputError, UsageError, and DeviceError if the format needs a missing module.
        """
        who = "Picture.save"
        target = encoded_path(path, f"{who}: path")
        array = self._array(what, who)
        if what in _UNBOUNDED and not os.fsdecode(target).lower().endswith(_FLOAT_FORMATS):
            raise UsageError(f"{who}: {what} is not between 0 and 1: write it as .npy or .pfm")
        if array.dtype != np.uint8:
            array = array.astype(np.float32, copy=False)
        struct = struct_of(array)
        _ffi.call(who, "qs_picture_save", ctypes.byref(struct), target, int(bool(overwrite)))

    def psnr(self, other: Any) -> float:
        """PSNR of the colours against another picture, array or file, in dB; infinity if equal."""
        return compare(other, self, metrics="psnr").psnr

    def ssim(self, other: Any) -> float:
        """SSIM of the colours against another picture, array or file; 1 if equal."""
        return compare(other, self, metrics="ssim").ssim

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        array = self._array("color", "Picture")
        if dtype is not None and array.dtype != dtype:
            return array.astype(dtype)
        return array.copy() if copy else array

    def _repr_png_(self) -> Optional[bytes]:
        """The colours, or else the alpha, as a .png file, for notebooks."""
        what = "color" if self.color is not None else "alpha"
        if getattr(self, what) is None:
            return None
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "picture.png")
            self.save(path, what)
            with open(path, "rb") as file:
                return file.read()

    def __repr__(self) -> str:
        return (f"<quadsplat.Picture: {self.camera.width} x {self.camera.height}, cull {self.cull},"
                f" {self.counts.tile_pairs} pairs>")

    def _array(self, what: str, who: str) -> np.ndarray:
        names = ("color", "alpha") + _UNBOUNDED
        if what not in names:
            raise UsageError(f"{who}: {what!r} is none of {', '.join(names)}")
        array = getattr(self, what)
        if array is None:
            raise UsageError(f"{who}: {what} was not rendered: add it to the outputs of render()")
        return to_numpy(array, f"{who}: {what}")
