# SPDX-License-Identifier: MIT
"""What the passes of a frame share besides tensors, and the calls of the library."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, List, Optional, Sequence, Tuple

import torch

from .. import _ffi
from .._context import Context
from ._tensors import Tensor, put

#: The tensors of QsInputs, in the order in which they are handed on; None: absent.
INPUTS = ("means", "scales", "rotations", "covariances", "opacities", "sh", "sh_rest", "channels",
          "background", "position")
#: The pictures of QsBlended.
PICTURES = ("color", "alpha", "depth", "inverse_depth")
BLOCKS = ("per_gaussian", "per_pair", "per_pixel")

Tensors = Sequence[Optional[Tensor]]


class Plan:
    """A frame's camera and rules, and which pictures are wanted in which layout."""

    def __init__(self, who: str, context: Context, camera: _ffi.QsCamera, rules: _ffi.QsRules,
                 pictures: Tuple[str, ...], is_planar: bool) -> None:
        self.who = who
        self.context = context
        self.camera = camera
        self.rules = rules
        self.pictures = pictures
        self.is_planar = is_planar

    def call(self, function: str, inputs: Tensors, *arguments: ctypes.Structure) -> None:
        """Calls a function of the library with the inputs, camera and rules in front."""
        given = _ffi.QsInputs()
        for name, tensor in zip(INPUTS, inputs):
            put(given, name, tensor)
        means = _means(inputs)
        temporary = _Temporary(means, given) if means.is_cuda else None
        try:
            with self.context._use(self.who) as pointer:
                _ffi.call(self.who, function, pointer, ctypes.byref(given),
                          ctypes.byref(self.camera), ctypes.byref(self.rules),
                          *map(ctypes.byref, arguments))
        finally:
            if temporary is not None:
                temporary.free()

    def empty_pictures(self, inputs: Tensors) -> Dict[str, Tensor]:
        """Tensors for the wanted pictures."""
        means, channels = _means(inputs), inputs[INPUTS.index("channels")]
        height, width = self.camera.height, self.camera.width
        count = 3 if channels is None else channels.shape[-1]
        color = (count, height, width) if self.is_planar else (height, width, count)
        return {name: means.new_empty(color if name == "color" else (height, width))
                for name in self.pictures}

    def blended(self, pictures: Dict[str, Tensor]) -> _ffi.QsBlended:
        """The struct of pictures, or of derivatives by them."""
        struct = _ffi.QsBlended()
        for name, tensor in pictures.items():
            if name == "color" and self.is_planar:
                tensor = tensor.permute(1, 2, 0)
            put(struct, name, tensor)
        return struct


def _means(inputs: Tensors) -> Tensor:
    assert inputs[0] is not None
    return inputs[0]


class _Temporary:
    """torch's current stream and memory of torch's allocator, for a call on a GPU."""

    def __init__(self, means: Tensor, inputs: _ffi.QsInputs) -> None:
        self._means = means
        self._blocks: List[Tensor] = []
        self._memory: Any = _ffi.QsMemory(allocate=_ffi.ALLOCATE(self._allocate))
        inputs.stream = _stream_of(means.get_device())
        inputs.temporary = ctypes.pointer(self._memory)

    def free(self) -> None:
        """After the call: torch uses the memory again in the order of the stream."""
        self._blocks.clear()
        self._memory = None  # refers to this object

    def _allocate(self, _user: Any, size: int, _kind: int) -> Optional[int]:
        try:
            self._blocks.append(bytes_beside(self._means, size))
            return self._blocks[-1].data_ptr()
        except BaseException:  # the library says so
            return None


def bytes_beside(means: Tensor, size: int) -> Tensor:
    """Memory on the device of the Gaussians. Without a byte a tensor has no address."""
    return torch.empty(max(size, 1), dtype=torch.uint8, device=means.device)


def _stream_of(device: int) -> int:
    """torch's current stream of a GPU, a cudaStream_t."""
    getter = getattr(torch._C, "_cuda_getCurrentRawStream", None)
    if getter is not None:
        return int(getter(device))
    return int(torch.cuda.current_stream(device).cuda_stream)


class Blocks:
    """The memory of a frame, as tensors of bytes."""

    def __init__(self) -> None:
        self.blocks: List[Optional[Tensor]] = [None] * len(BLOCKS)
        self._error: Optional[BaseException] = None

    def call(self, plan: Plan, function: str, inputs: Tensors, *arguments: Any) -> None:
        """Plan.call() of a function that asks for memory before its other arguments."""

        def allocate(_user: Any, size: int, kind: int) -> Optional[int]:
            try:
                block = bytes_beside(_means(inputs), size)
                self.blocks[kind] = block
                return block.data_ptr()
            except BaseException as error:  # ctypes would print it and go on
                self._error = error
                return None

        memory = _ffi.QsMemory(allocate=_ffi.ALLOCATE(allocate))
        try:
            plan.call(function, inputs, memory, *arguments)
        except Exception:
            if self._error is not None:
                raise self._error from None
            raise


def copy_of(frame: _ffi.QsStageFrame, blocks: Tensors) -> _ffi.QsStageFrame:
    """The frame with its memory in these blocks."""
    copy = _ffi.QsStageFrame.from_buffer_copy(frame)
    for name, block in zip(BLOCKS, blocks):
        setattr(copy, name, None if block is None else block.data_ptr())
    return copy
