# SPDX-License-Identifier: MIT
"""Arrays of numpy and of other libraries as the library's QsArray."""
from __future__ import annotations

import ctypes
from typing import Any, Iterable, Optional, Sequence, Tuple

import numpy as np

from . import _ffi
from ._checks import choice
from ._errors import UsageError

TYPES = {np.dtype(np.float32): _ffi.FLOAT32, np.dtype(np.float64): _ffi.FLOAT64,
         np.dtype(np.uint8): _ffi.UINT8, np.dtype(np.int32): _ffi.INT32,
         np.dtype(np.uint32): _ffi.UINT32, np.dtype(np.int64): _ffi.INT64,
         np.dtype(np.uint64): _ffi.UINT64}
_OF_TYPE = {number: dtype for dtype, number in TYPES.items()}

# Devices of DLPack whose memory the CPU reads: CPU, pinned and managed memory of CUDA.
_HOST_DEVICES = (1, 3, 13)


def to_numpy(value: Any, where: str) -> np.ndarray:
    """An array or nested sequence as a numpy array, without a copy where numpy can read it.

    Arrays of torch, JAX and other libraries are read by __array_interface__ or DLPack, or through
    their conversion to numpy. Raises UsageError for memory of a GPU.
    """
    if isinstance(value, np.ndarray):
        return value
    value = detached(value)
    if _is_on_device(value):
        raise UsageError(f"{where} is in the memory of a GPU: copy it to the host first, for "
                         "example by .cpu() or cupy.asnumpy()")
    if "bfloat16" in str(getattr(value, "dtype", "")) and hasattr(value, "float"):
        value = value.float()
    try:
        if hasattr(value, "__dlpack__") and not hasattr(value, "__array_interface__"):
            try:
                return np.from_dlpack(value)
            except Exception:  # an old numpy, or a type or layout that DLPack does not have
                pass
        return np.asarray(value)
    except Exception as error:
        raise UsageError(f"{where} cannot be read as an array: {error}") from None


def detached(value: Any) -> Any:
    """The value, without the graph of torch that it may belong to."""
    return value.detach() if getattr(value, "requires_grad", False) else value


def element_type(value: Any, where: str, known: Iterable[str]) -> np.dtype:
    """One of the known types, from its name or numpy's type. Raises UsageError."""
    try:
        name = np.dtype(value).name
    except TypeError:
        name = value
    choice(name, where, dict.fromkeys(known, 0))
    return np.dtype(name)


def writable(value: Any, where: str) -> np.ndarray:
    """The array itself, which the library may change; mark_changed() follows.

    numpy reads arrays by DLPack as read only, also tensors that may be changed. Raises UsageError
    if the memory cannot be changed.
    """
    array = to_numpy(value, where)
    if not array.flags.writeable and hasattr(value, "detach"):
        own = np.asarray(value.detach())
        if own.ctypes.data == array.ctypes.data:
            array = own
    if not array.flags.writeable or isinstance(value, (list, tuple)):
        raise UsageError(f"{where} cannot be changed in place")
    return array


def mark_changed(value: Any) -> None:
    """Lets torch notice that a tensor was changed through writable()."""
    if hasattr(value, "detach"):
        value.detach()[:0].zero_()


def _is_on_device(value: Any) -> bool:
    try:
        if hasattr(value, "__cuda_array_interface__"):
            return True
        return hasattr(value, "__dlpack_device__") and (
            value.__dlpack_device__()[0] not in _HOST_DEVICES)
    except Exception:  # a tensor without memory, such as torch's device meta
        return False


def real_array(value: Any, where: str,
               shape: Optional[Sequence[Optional[int]]] = None) -> np.ndarray:
    """An array of float32 or float64. None in `shape` stands for any size.

    Half precision and integers are converted. Raises UsageError.
    """
    array = to_numpy(value, where)
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise UsageError(f"{where} has elements of type {array.dtype} instead of real numbers")
    if shape is not None:
        require_shape(array, where, shape)
    if array.dtype.kind == "f" and array.dtype.itemsize >= 4:
        return _native(array)
    return array.astype(np.float32 if array.dtype.itemsize <= 2 else np.float64)


def picture_array(value: Any, where: str) -> np.ndarray:
    """A picture as height x width x 3 of float32, float64 or uint8. Raises UsageError."""
    array = to_numpy(value, where)
    if array.dtype != np.uint8 and array.dtype.kind != "f":
        raise UsageError(f"{where} has elements of type {array.dtype} instead of floats of 0..1 "
                         "or uint8 of 0..255")
    require_shape(array, where, (None, None, 3))
    return _native(array) if array.dtype == np.uint8 else real_array(array, where)


def require_shape(array: Any, where: str, shape: Sequence[Optional[int]]) -> None:
    """Raises UsageError unless the array has this shape."""
    if array.ndim == len(shape) and all(
            wanted is None or wanted == size for wanted, size in zip(shape, array.shape)):
        return
    wanted = ", ".join("any" if size is None else str(size) for size in shape)
    raise UsageError(f"{where} has the shape {tuple(array.shape)} instead of "
                     f"({wanted}{',' if len(shape) == 1 else ''})")


def _native(array: np.ndarray) -> np.ndarray:
    """The array, or a copy where its bytes or strides are not those of whole aligned elements."""
    native = array.dtype.newbyteorder("=")
    if array.dtype != native:
        return array.astype(native)
    if not array.flags.aligned or any(stride % array.itemsize for stride in array.strides):
        return array.copy()
    return array


def struct_of(array: Optional[np.ndarray]) -> _ffi.QsArray:
    """The struct of an array of one of TYPES, which must outlive the struct. None: absent."""
    struct = _ffi.QsArray()
    if array is None:
        return struct
    struct.data = array.ctypes.data
    struct.dimensions = array.ndim
    struct.type = TYPES[array.dtype]
    struct.memory = _ffi.MEMORY_HOST
    for axis in range(array.ndim):
        struct.sizes[axis] = array.shape[axis]
        struct.strides[axis] = array.strides[axis] // array.itemsize
    return struct


def copy_of(struct: _ffi.QsArray) -> np.ndarray:
    """A copy of an array in the library's memory."""
    dtype = _OF_TYPE[struct.type]
    shape: Tuple[int, ...] = tuple(struct.sizes[: struct.dimensions])
    if not struct.data or 0 in shape:
        return np.empty(shape, dtype)
    strides = tuple(stride * dtype.itemsize for stride in struct.strides[: struct.dimensions])
    reach = sum((size - 1) * stride for size, stride in zip(shape, strides)) + dtype.itemsize
    memory = (ctypes.c_char * reach).from_address(struct.data)
    return np.array(np.ndarray(shape, dtype, memory, 0, strides), order="C")
