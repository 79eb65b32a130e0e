# SPDX-License-Identifier: MIT
"""Parts of a trainer: the functions that quadsplat's own trainer uses besides the rasterizer."""
from __future__ import annotations

import ctypes
from typing import Any, Optional, Tuple

import numpy as np

from . import _ffi
from ._arrays import mark_changed, real_array, require_shape, struct_of, to_numpy, writable
from ._checks import choice, integer, real
from ._context import Context, chosen
from ._errors import UsageError


def ssim(a: Any, b: Any, *, padding: str = "same", context: Optional[Context] = None) -> float:
    """The mean structural similarity of two batches of pictures.

    a, b: batch x channels x height x width, all 1 or more, real numbers, nominally 0..1. They are
        not clamped. If one is float64, both are read as that.
    padding: "same": every pixel counts, values outside are 0; "valid": 5 pixels at every side do
        not count, and both sides have at least 11 pixels.

    The window has 11 x 11 pixels and sigma 1.5. NaN and infinite values make the mean NaN. Raises
    UsageError.
    """
    who = "ssim"
    first, second, border = _pictures(who, a, b, padding)
    mean = ctypes.c_double()
    with chosen(context, who, "cpu")._use(who) as pointer:
        _ffi.call(who, "qs_ssim", pointer, ctypes.byref(struct_of(first)),
                  ctypes.byref(struct_of(second)), border, ctypes.byref(mean))
    return mean.value


def ssim_backward(a: Any, b: Any, by_mean: float = 1.0, *, padding: str = "same",
                  context: Optional[Context] = None) -> np.ndarray:
    """The derivatives of a number by the values of `a`, from its derivative by ssim(a, b).

    Returns an array of the shape of `a`, float32, or float64 if `a` or `b` is. Raises UsageError.
    """
    who = "ssim_backward"
    first, second, border = _pictures(who, a, b, padding)
    by_a = np.empty(first.shape, first.dtype)
    with chosen(context, who, "cpu")._use(who) as pointer:
        _ffi.call(who, "qs_ssim_backward", pointer, ctypes.byref(struct_of(first)),
                  ctypes.byref(struct_of(second)), border, real(by_mean, f"{who}: by_mean"),
                  ctypes.byref(struct_of(by_a)))
    return by_a


def neighbours(points: Any, *, context: Optional[Context] = None) -> np.ndarray:
    """For each point the mean of the squared distances to its three nearest neighbours.

    points: N x 3, read as float32. Points in the same place are neighbours of distance 0.

    Returns N numbers, float32. With two or three points it is the mean over the other points, and 0
    for a single point. A point with a coordinate that is not finite gets NaN, and is no neighbour.
    Raises UsageError.
    """
    who = "neighbours"
    with np.errstate(over="ignore"):
        given = real_array(points, f"{who}: points", (None, 3)).astype(np.float32, copy=False)
    distances2 = np.empty(len(given), np.float32)
    with chosen(context, who, "cpu")._use(who) as pointer:
        _ffi.call(who, "qs_neighbours", pointer, ctypes.byref(struct_of(given)),
                  ctypes.byref(struct_of(distances2)))
    return distances2


def relocate(opacities: Any, scales: Any, counts: Any, *,
             context: Optional[Context] = None) -> Tuple[np.ndarray, np.ndarray]:
    """Opacities and scales of the copies that take the place of Gaussians (MCMC, equation 9).

    opacities: N or N x 1, 0..1.
    scales: N x 3, standard deviations.
    counts: N or N x 1 integers, the number of copies: below 1 counts as 1, which changes nothing,
        and above 51 as 51.

    Returns new arrays of the shapes and types of `opacities` and `scales`. Opacities are not
    clamped. Gaussians with an opacity of NaN or outside of 0..1 stay as they are. Raises UsageError.
    """
    who = "relocate"
    old = real_array(opacities, f"{who}: opacities")
    column = old[:, 0] if old.ndim == 2 and old.shape[1] == 1 else old
    require_shape(column, f"{who}: opacities", (None,))
    sizes = real_array(scales, f"{who}: scales", (len(column), 3))
    copies = to_numpy(counts, f"{who}: counts")
    if copies.dtype.kind not in "iu" or copies.dtype.itemsize > 8:
        raise UsageError(f"{who}: counts has elements of type {copies.dtype} instead of integers")
    if copies.ndim == 2 and copies.shape[1] == 1:
        copies = copies[:, 0]
    require_shape(copies, f"{who}: counts", (len(column),))
    copies = np.clip(copies, 0, 1000).astype(np.int32)  # any order of bytes
    new_opacities, new_scales = np.empty(old.shape, old.dtype), np.empty(sizes.shape, sizes.dtype)
    with chosen(context, who, "cpu")._use(who) as pointer:
        _ffi.call(who, "qs_relocate", pointer, ctypes.byref(struct_of(column)),
                  ctypes.byref(struct_of(sizes)), ctypes.byref(struct_of(copies)),
                  ctypes.byref(struct_of(new_opacities.reshape(len(column)))),
                  ctypes.byref(struct_of(new_scales)))
    return new_opacities, new_scales


def adam(values: Any, gradients: Any, first: Any, second: Any, rate: float, *,
         visible: Any = None, step: int = 0, betas: Tuple[float, float] = (0.9, 0.999),
         epsilon: float = 1e-15, context: Optional[Context] = None) -> None:
    """A step of Adam, in place, for the visible rows.

    values: N rows of any shape, float32, up to 4 dimensions. They change.
    gradients: of the same shape. NaN and infinite gradients count as 0.
    first, second: the moments, of the same shape, float32. They change, and start at 0.
    rate: the learning rate.
    visible: N, bool or uint8: rows of value 0 stay as they are, with their moments; None: all move.
    step: number of this step, 1, 2, ..., which corrects the moments' start at 0; 0: no correction.
    betas: decay of the moments, at least 0 and below 1.
    epsilon: added to the root of the second moment.

    A value whose move is not finite stays. Arrays that change are numpy's, tensors of torch on the
    CPU, or others that share memory with numpy that may be written. torch notices the change.
    Raises UsageError.
    """
    who = "adam"
    moved = _writable(values, f"{who}: values", None)
    given = _ffi.QsAdam()
    given.step = integer(step, f"{who}: step", 0, 2**63 - 1)
    given.rate = real(rate, f"{who}: rate")
    given.beta1, given.beta2 = (real(beta, f"{who}: betas") for beta in _pair(betas, who))
    given.epsilon = real(epsilon, f"{who}: epsilon")
    shape = moved.shape
    with np.errstate(over="ignore"):
        by = real_array(gradients, f"{who}: gradients", shape).astype(np.float32, copy=False)
    arrays = {"values": moved, "gradients": by, "first": _writable(first, f"{who}: first", shape),
              "second": _writable(second, f"{who}: second", shape)}
    if visible is not None:
        mask = to_numpy(visible, f"{who}: visible")
        if mask.dtype not in (np.bool_, np.uint8):
            raise UsageError(f"{who}: visible has elements of type {mask.dtype} instead of bool or "
                             "uint8")
        require_shape(mask, f"{who}: visible", shape[:1])
        arrays["visible"] = mask.view(np.uint8)
    for name, array in arrays.items():
        setattr(given, name, struct_of(array))
    with chosen(context, who, "cpu")._use(who) as pointer:
        _ffi.call(who, "qs_adam", pointer, ctypes.byref(given))
    for changed in (values, first, second):
        mark_changed(changed)


def _pictures(who: str, a: Any, b: Any, padding: str) -> Tuple[np.ndarray, np.ndarray, int]:
    first = real_array(a, f"{who}: a", (None,) * 4)
    second = real_array(b, f"{who}: b", first.shape)
    if first.dtype != second.dtype:
        first, second = first.astype(np.float64), second.astype(np.float64)
    return first, second, choice(padding, f"{who}: padding", _ffi.PADDINGS)


def _writable(value: Any, where: str, shape: Any) -> np.ndarray:
    """The array itself, float32, which the library may write."""
    array = writable(value, where)
    if array.dtype != np.float32 or not array.dtype.isnative:
        raise UsageError(f"{where} has elements of type {array.dtype} instead of float32")
    if not 1 <= array.ndim <= 4:
        raise UsageError(f"{where} has {array.ndim} dimensions instead of 1 to 4")
    if shape is not None:
        require_shape(array, where, shape)
    if not array.flags.aligned or any(stride % array.itemsize for stride in array.strides):
        raise UsageError(f"{where} cannot be changed in place")
    return array


def _pair(betas: Any, who: str) -> Tuple[Any, Any]:
    try:
        beta1, beta2 = betas
    except (TypeError, ValueError):
        raise UsageError(f"{who}: betas is {betas!r} instead of 2 numbers") from None
    return beta1, beta2
