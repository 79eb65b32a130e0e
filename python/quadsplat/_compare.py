# SPDX-License-Identifier: MIT
"""Metrics of two pictures."""
from __future__ import annotations

import ctypes
import os
from typing import Any, Callable, NamedTuple, Optional, Sequence, Union

import numpy as np

from . import _ffi
from ._arrays import picture_array, require_shape, struct_of, to_numpy
from ._checks import choice, encoded_path, words
from ._context import Context, chosen
from ._errors import UsageError
from ._files import read_picture
from ._gpu_arrays import GpuArray, is_on_gpu


class Comparison(NamedTuple):
    """Metrics of two pictures. NaN: not asked for."""

    psnr: float = float("nan")  #: dB of the values; infinity if they are equal
    psnr_8bit: float = float("nan")  #: dB of the values rounded to 8 bits
    ssim: float = float("nan")  #: window of 11 x 11 pixels, sigma 1.5
    flip: float = float("nan")  #: mean of LDR-FLIP at 67.02 pixels per degree
    lpips: float = float("nan")  #: LPIPS of values of -1..1, for which its network was made
    lpips_paper: float = float("nan")  #: LPIPS of values of 0..1, as the scripts of 3DGS compute it


def compare(reference: Any, picture: Any, *,
            metrics: Union[str, Sequence[str]] = ("psnr", "ssim"), mask: Any = None,
            ssim_border: str = "zeros", lpips_weights: Any = None,
            context: Optional[Context] = None) -> Comparison:
    """The metrics of a picture against a reference.

    reference, picture: pictures of render(), arrays of height x width x 3, floats of 0..1 or uint8
        of 0..255, or paths of files. Values are clamped to 0..1, and NaN counts as 0. Two
        arrays on a GPU of CUDA are compared there, in their stream, with a mask on the same GPU.
    metrics: of "psnr", "psnr_8bit", "ssim", "flip", "lpips" and "lpips_paper".
    mask: height x width, bool or uint8: "psnr" and "ssim" leave out pixels of value 0.
    ssim_border: "zeros": every pixel counts, values outside are 0; "crop": pixels whose window is
        inside count, and both sides have at least 11 pixels.
    lpips_weights: path of the .safetensors file that scripts/lpips_weights makes, for LPIPS.
    context: computes LPIPS on its backend; None: the CPU, or the GPU of the pictures.

    Raises UsageError, and InputError for files.
    """
    who = "compare"
    on_gpu = is_on_gpu(reference) and is_on_gpu(picture)
    values: Callable[[Any, str], Any] = GpuArray if on_gpu else _values
    a, b = values(reference, f"{who}: reference"), values(picture, f"{who}: picture")
    if a.shape != b.shape:
        raise UsageError(f"{who}: picture has the shape {b.shape}, but reference has {a.shape}")
    require_shape(a, f"{who}: reference", (None, None, 3))
    names = words(metrics, f"{who}: metrics", _ffi.METRICS)
    result = _ffi.QsComparison()
    result.metrics = sum({_ffi.METRICS[name] for name in names})
    result.ssim_border = choice(ssim_border, f"{who}: ssim_border", _ffi.BORDERS)
    if lpips_weights is not None:
        result.lpips_weights = encoded_path(lpips_weights, f"{who}: lpips_weights")
    if mask is not None:
        weights = _mask(mask, f"{who}: mask", on_gpu)
        require_shape(weights, f"{who}: mask", a.shape[:2])
        result.mask = _struct(weights)
    used = chosen(context, who, "cuda", a.device) if on_gpu else chosen(context, who, "cpu")
    with used._use(who) as pointer:
        if on_gpu:
            _ffi.call(who, "qs_context_stream", pointer, a.stream)
        _ffi.call(who, "qs_compare", pointer, ctypes.byref(_struct(a)), ctypes.byref(_struct(b)),
                  ctypes.byref(result))
    return Comparison(**{name: getattr(result, name) for name in names})


def _values(picture: Any, where: str) -> np.ndarray:
    if isinstance(picture, (str, os.PathLike)):
        picture = read_picture(picture)
    return picture_array(picture, where)


def _mask(mask: Any, where: str, on_gpu: bool) -> Any:
    if on_gpu and is_on_gpu(mask):
        weights: Any = GpuArray(mask, where, of_bytes=True)
    else:
        weights = to_numpy(mask, where)
    if weights.dtype not in (np.bool_, np.uint8):
        raise UsageError(f"{where} has elements of type {weights.dtype} instead of bool or uint8")
    return weights.view(np.uint8) if isinstance(weights, np.ndarray) else weights


def _struct(array: Any) -> _ffi.QsArray:
    return array.struct() if isinstance(array, GpuArray) else struct_of(array)
