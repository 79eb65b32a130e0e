# SPDX-License-Identifier: MIT
"""What the passes of a frame share besides tensors, and the calls of the library."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import torch

from .. import _ffi
from .._context import Context
from ._tensors import Tensor, array_of, put

#: The tensors of QsInputs, in the order in which they are handed on; None: absent.
INPUTS = ("means", "scales", "rotations", "covariances", "opacities", "sh", "sh_rest", "channels",
          "background", "position")
#: The pictures of QsBlended.
PICTURES = ("color", "alpha", "depth", "inverse_depth")
BLOCKS = ("per_gaussian", "per_pair", "per_pixel")

Tensors = Sequence[Optional[Tensor]]


class Plan:
    """A frame's camera and rules, and which results are wanted in which layout.

    counts_above: transmittance for the counts of pixels; None: they are not wanted.
    """

    def __init__(self, who: str, context: Context, camera: _ffi.QsCamera, rules: _ffi.QsRules,
                 pictures: Tuple[str, ...], is_planar: bool,
                 counts_above: Optional[float] = None) -> None:
        self.who = who
        self.context = context
        self.camera = camera
        self.rules = rules
        self.pictures = pictures
        self.is_planar = is_planar
        self.counts_above = counts_above

    def call(self, function: str, inputs: Tensors, *arguments: ctypes.Structure) -> None:
        """Calls a function of the library with the inputs, camera and rules in front."""
        self._call(function, inputs, map(ctypes.byref, arguments))

    def _call(self, function: str, inputs: Tensors, arguments: Iterable[Any]) -> None:
        given = _ffi.QsInputs()
        for name, tensor in zip(INPUTS, inputs):
            if tensor is not None:
                put(given, name, tensor)
        with self.context._use(self.who) as pointer:
            _ffi.call(self.who, function, pointer, ctypes.byref(given), ctypes.byref(self.camera),
                      ctypes.byref(self.rules), *arguments)

    def count_pixels(self, inputs: Tensors, frame: _ffi.QsStageFrame) -> Optional[Tensor]:
        """The number of pixels of every Gaussian, if it is wanted."""
        if self.counts_above is None:
            return None
        means = inputs[0]
        assert means is not None
        counts = means.new_empty(means.shape[0], dtype=torch.int32)
        self._call("qs_count_pixels", inputs, (ctypes.byref(frame), self.counts_above,
                                               ctypes.byref(array_of(counts))))
        return counts

    def empty_pictures(self, inputs: Tensors) -> Dict[str, Tensor]:
        """Tensors for the wanted pictures."""
        means, channels = inputs[0], inputs[INPUTS.index("channels")]
        assert means is not None
        height, width = self.camera.height, self.camera.width
        count = 3 if channels is None else channels.shape[-1]
        color = (count, height, width) if self.is_planar else (height, width, count)
        return {name: torch.empty(color if name == "color" else (height, width), dtype=means.dtype)
                for name in self.pictures}

    def blended(self, pictures: Dict[str, Tensor]) -> _ffi.QsBlended:
        """The struct of pictures, or of derivatives by them."""
        struct = _ffi.QsBlended()
        for name, tensor in pictures.items():
            if name == "color" and self.is_planar:
                tensor = tensor.permute(1, 2, 0)
            put(struct, name, tensor)
        return struct


class Blocks:
    """The memory of a frame, as tensors of bytes."""

    def __init__(self) -> None:
        self.blocks: List[Optional[Tensor]] = [None] * len(BLOCKS)
        self._error: Optional[BaseException] = None

    def call(self, plan: Plan, function: str, inputs: Tensors, *arguments: Any) -> None:
        """Plan.call() of a function that asks for memory before its other arguments."""
        key = id(self)
        _filled[key] = self
        try:
            plan.call(function, inputs, _ffi.QsMemory(user=key, allocate=_allocate), *arguments)
        except Exception:
            if self._error is not None:
                raise self._error from None
            raise
        finally:
            del _filled[key]

    def allocate(self, size: int, kind: int) -> Optional[int]:
        try:
            # Without a byte a tensor has no address.
            block = self.blocks[kind] = torch.empty(size or 1, dtype=torch.uint8)
            return block.data_ptr()
        except BaseException as error:  # ctypes would print it and go on
            self._error = error
            return None


#: The blocks of the calls that run, by id().
_filled: Dict[int, Blocks] = {}


@_ffi.ALLOCATE
def _allocate(user: int, size: int, kind: int) -> Optional[int]:
    return _filled[user].allocate(size, kind)


def copy_of(frame: _ffi.QsStageFrame, blocks: Tensors) -> _ffi.QsStageFrame:
    """The frame with its memory in these blocks."""
    copy = _ffi.QsStageFrame.from_buffer_copy(frame)
    for name, block in zip(BLOCKS, blocks):
        setattr(copy, name, None if block is None else block.data_ptr())
    return copy
