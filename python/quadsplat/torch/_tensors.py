# SPDX-License-Identifier: MIT
"""Tensors of torch as the library's QsArray."""
from __future__ import annotations

import ctypes
import struct
from typing import Any, Iterable, Optional, Sequence, Tuple, Type

import torch

from .. import _arrays, _ffi
from .._context import Context, chosen
from .._errors import UsageError

Tensor = torch.Tensor

_TYPES = {torch.float32: _ffi.FLOAT32, torch.float64: _ffi.FLOAT64, torch.int32: _ffi.INT32,
          torch.uint8: _ffi.UINT8, torch.int64: _ffi.INT64}
_HALVES = (torch.float16, torch.bfloat16)
_HOST = (_ffi.MEMORY_HOST, 0)  # QsArray.memory and .device
_CUDA = _ffi.MEMORY_CUDA
_increment_version = getattr(torch.autograd.graph, "increment_version", None)  # newer versions have it

# The members of a QsArray of 0 to 4 dimensions: writing all of them at once is ten times as fast as
# one by one. `x` writes a 0.
_ARRAYS = tuple(struct.Struct("=Q" + 2 * (count * "q" + (4 - count) * "8x") + "IIIi")
                for count in range(5))
assert {array.size for array in _ARRAYS} == {ctypes.sizeof(_ffi.QsArray)}
_PACK = tuple(array.pack_into for array in _ARRAYS)


def put(target: ctypes.Structure, name: str, tensor: Optional[Tensor]) -> None:
    """Sets the member of a struct to a tensor, which must outlive the struct. None: absent."""
    if tensor is not None:
        _pack(target, getattr(target.__class__, name).offset, tensor)


def places_of(struct: Type[ctypes.Structure], names: Iterable[str]) -> Tuple[int, ...]:
    """The places of members of a struct, for put_all()."""
    return tuple(getattr(struct, name).offset for name in names)


def put_all(target: ctypes.Structure, places: Iterable[int],
            tensors: Iterable[Optional[Tensor]]) -> None:
    """put() of many members, which is faster."""
    for place, tensor in zip(places, tensors):
        if tensor is not None:
            _pack(target, place, tensor)


def array_of(tensor: Tensor) -> _ffi.QsArray:
    """The struct of a tensor, which must outlive it."""
    struct = _ffi.QsArray()
    _pack(struct, 0, tensor)
    return struct


def put_part(target: ctypes.Structure, name: str, tensor: Tensor, shape: Sequence[int],
             strides: Sequence[int], offset: int = 0) -> None:
    """Sets the member to elements of a tensor from `offset` on, without a view of torch."""
    memory, device = (_CUDA, tensor.get_device()) if tensor.is_cuda else _HOST
    _PACK[len(shape)](target, getattr(target.__class__, name).offset,
                      tensor.data_ptr() + offset * tensor.element_size(), *shape, *strides,
                      len(shape), _TYPES[tensor.dtype], memory, device)


def put_transposed(target: ctypes.Structure, name: str, tensor: Tensor) -> None:
    """Sets the member to the transpose of a matrix."""
    put_part(target, name, tensor, tuple(reversed(tensor.shape)), tuple(reversed(tensor.stride())))


def _pack(target: ctypes.Structure, offset: int, tensor: Tensor) -> None:
    shape, strides = tensor.shape, tensor.stride()
    dimensions = len(shape)
    if dimensions == 0:  # a number
        shape, strides, dimensions = (1,), (1,), 1
    memory, device = (_CUDA, tensor.get_device()) if tensor.is_cuda else _HOST
    _PACK[dimensions](target, offset, tensor.data_ptr(), *shape, *strides, dimensions,
                      _TYPES[tensor.dtype], memory, device)


def stream_of(device: int) -> int:
    """torch's current stream of a GPU, a cudaStream_t."""
    getter = getattr(torch._C, "_cuda_getCurrentRawStream", None)
    if getter is not None:
        return int(getter(device))
    return int(torch.cuda.current_stream(device).cuda_stream)


def mark_changed(tensor: Tensor) -> None:
    """Lets torch notice that the library changed the tensor."""
    if _increment_version is None:
        _arrays.mark_changed(tensor)
    else:
        _increment_version(tensor)


def context_of(context: Optional[Context], who: str, means: Tensor) -> Context:
    """The given context, or the process's for the device of the Gaussians."""
    if means.is_cuda:
        return chosen(context, who, "cuda", means.get_device())
    return chosen(context, who, "cpu")


def checked(value: Any, where: str, dtype: Optional[torch.dtype] = None,
            device: Optional[torch.device] = None, most_dimensions: int = 4) -> Tensor:
    """A tensor of float32 or float64 that the library can read. Half precision becomes float32.

    dtype, device: the type and the device that it must have then. most_dimensions: the library has
    4. Raises UsageError.
    """
    if (isinstance(value, Tensor) and dtype is not None and value.dtype == dtype
            and value.device == device and value.layout == torch.strided
            and 1 <= value.dim() <= most_dimensions):
        return value  # nearly all calls end here
    if not isinstance(value, Tensor):
        raise UsageError(f"{where} is a {type(value).__name__} instead of a torch.Tensor")
    if value.device.type not in ("cpu", "cuda"):
        raise UsageError(f"{where} is on the device {value.device}: gradients are computed on the "
                         "CPU and with CUDA: move the tensors there by .cpu() or .cuda()")
    if device is not None and value.device != device:
        raise UsageError(f"{where} is on the device {value.device}, but means is on {device}")
    if value.layout != torch.strided:
        raise UsageError(f"{where} is sparse: convert it by .to_dense()")
    if value.dtype in _HALVES:
        value = value.to(torch.float32)
    if value.dtype not in (torch.float32, torch.float64):
        raise UsageError(f"{where} has elements of type {_name(value.dtype)} instead of float32 or "
                         "float64")
    if dtype is not None and value.dtype != dtype:
        raise UsageError(f"{where} has elements of type {_name(value.dtype)}, but means has "
                         f"{_name(dtype)}")
    if not 1 <= value.dim() <= most_dimensions:
        raise UsageError(f"{where} has {value.dim()} dimensions")
    return value


def checked_shape(tensor: Tensor, where: str, *shape: int) -> Tensor:
    """The tensor. Raises UsageError unless it has this shape."""
    if tuple(tensor.shape) != shape:
        raise UsageError(f"{where} has the shape {tuple(tensor.shape)} instead of {shape}")
    return tensor


def _name(dtype: torch.dtype) -> str:
    return str(dtype).replace("torch.", "")
