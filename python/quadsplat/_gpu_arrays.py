# SPDX-License-Identifier: MIT
"""Arrays in the memory of a GPU: tensors of torch, arrays of CuPy, JAX and other libraries that
have __cuda_array_interface__."""
from __future__ import annotations

import ctypes
import functools
import sys
from typing import Any, Optional, Sequence, Tuple

import numpy as np

from . import _ffi
from ._arrays import TYPES, detached, require_shape
from ._errors import UsageError

_CUDA_OF_DLPACK = 2
_DEVICE_ORDINAL = 9  # CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL


class GpuArray:
    """A view of an array, which must outlive it. of_bytes: bool counts as uint8."""

    def __init__(self, value: Any, where: str, of_bytes: bool = False) -> None:
        value = detached(value)
        facts = value.__cuda_array_interface__
        self.shape: Tuple[int, ...] = tuple(facts["shape"])
        self.dtype = np.dtype(facts["typestr"])
        if of_bytes and self.dtype == np.bool_:
            self.dtype = np.dtype(np.uint8)
        if self.dtype not in TYPES or not self.dtype.isnative:
            raise UsageError(f"{where} has elements of type {self.dtype}, which are not converted "
                             "on a GPU")
        self.stream = _stream_of(value, facts)
        self._pointer, self._is_read_only = facts["data"]
        self.device = _device_of(value, self._pointer)
        size = self.dtype.itemsize
        given = facts.get("strides")
        self._strides = (_packed(self.shape) if given is None else
                         tuple(stride // size for stride in given))
        if given is not None and any(stride % size for stride in given):
            raise UsageError(f"{where} has strides that are not those of whole elements")
        if len(self.shape) > 4:
            raise UsageError(f"{where} has {len(self.shape)} dimensions")

    @property
    def ndim(self) -> int:
        """The number of dimensions."""
        return len(self.shape)

    def column(self) -> GpuArray:
        """N x 1 as N."""
        self.shape, self._strides = self.shape[:1], self._strides[:1]
        return self

    def require_writable(self, where: str) -> None:
        """Raises UsageError if the memory is read only."""
        if self._is_read_only:
            raise UsageError(f"{where} cannot be changed in place")

    def struct(self) -> _ffi.QsArray:
        """The library's struct."""
        struct = _ffi.QsArray(data=self._pointer, dimensions=self.ndim, type=TYPES[self.dtype],
                              memory=_ffi.MEMORY_CUDA, device=self.device)
        struct.sizes[: self.ndim] = self.shape
        struct.strides[: self.ndim] = self._strides
        return struct


def is_on_gpu(value: Any) -> bool:
    """True if the library can read the value in the memory of a GPU."""
    try:
        return hasattr(detached(value), "__cuda_array_interface__")
    except Exception:  # a tensor in another form, such as torch's sparse ones
        return False


def real_gpu_array(value: Any, where: str,
                   shape: Optional[Sequence[Optional[int]]] = None) -> GpuArray:
    """An array of float32 or float64 on a GPU. None in `shape` stands for any size. Raises
    UsageError."""
    if not is_on_gpu(value):
        raise UsageError(f"{where} is not in the memory of the GPU that has the means")
    array = GpuArray(value, where)
    if array.dtype.kind != "f":
        raise UsageError(f"{where} has elements of type {array.dtype} instead of float32 or "
                         "float64")
    if shape is not None:
        require_shape(array, where, shape)
    return array


def _packed(shape: Tuple[int, ...]) -> Tuple[int, ...]:
    """The strides of elements that lie one after the other."""
    strides = [1]
    for size in reversed(shape[1:]):
        strides.insert(0, strides[0] * max(size, 1))
    return tuple(strides[: len(shape)])


def _device_of(value: Any, pointer: Optional[int]) -> int:
    """CUDA's number of the GPU: what the array says, else what the driver knows of its memory, else 0."""
    if hasattr(value, "__dlpack_device__"):
        kind, number = value.__dlpack_device__()
        if kind == _CUDA_OF_DLPACK:
            return int(number)
    driver = _cuda_driver()
    found = ctypes.c_int(0)
    if driver is not None and pointer:
        failed = driver.cuPointerGetAttribute(ctypes.byref(found), _DEVICE_ORDINAL, ctypes.c_uint64(pointer))
        return 0 if failed else found.value
    return 0


@functools.lru_cache(maxsize=None)
def _cuda_driver() -> Any:
    """The driver's library, which whoever made an array on a GPU has loaded; None without it."""
    try:
        return ctypes.CDLL("libcuda.so.1")
    except OSError:
        return None


def _stream_of(value: Any, facts: Any) -> Optional[int]:
    """The stream in which the array is ready: the current stream of torch, the stream of the array, or
    CUDA's default stream."""
    torch = sys.modules.get("torch")
    if torch is not None and isinstance(value, torch.Tensor):
        return int(torch.cuda.current_stream(value.device).cuda_stream) or None
    return facts.get("stream")
