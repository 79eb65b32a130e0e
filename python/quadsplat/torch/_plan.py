# SPDX-License-Identifier: MIT
"""What the passes of a frame share besides tensors, and the calls of the library."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import torch

from .. import _ffi
from .._context import Context, chosen
from ._tensors import Tensor, array_of, places_of, put, put_all, stream_of

#: The tensors of QsInputs, in the order in which they are handed on; None: absent.
INPUTS = ("means", "scales", "rotations", "covariances", "opacities", "sh", "sh_rest", "channels",
          "background", "position")
#: The pictures of QsBlended.
PICTURES = ("color", "alpha", "depth", "inverse_depth")
BLOCKS = ("per_gaussian", "per_pair", "per_pixel")

_byref = ctypes.byref
_INPUT_PLACES = places_of(_ffi.QsInputs, INPUTS)

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
        self._call(function, inputs, map(_byref, arguments))

    def _call(self, function: str, inputs: Tensors, arguments: Iterable[Any]) -> None:
        given = _ffi.QsInputs()
        put_all(given, _INPUT_PLACES, inputs)
        means = _means(inputs)
        temporary = _Temporary(means.device, given) if means.is_cuda else None
        try:
            with self.context._use(self.who) as pointer:
                _ffi.call(self.who, function, pointer, _byref(given), _byref(self.camera),
                          _byref(self.rules), *arguments)
        finally:
            if temporary is not None:
                temporary.free()

    def count_pixels(self, inputs: Tensors, frame: _ffi.QsStageFrame) -> Optional[Tensor]:
        """The number of pixels of every Gaussian, if it is wanted, beside the Gaussians."""
        if self.counts_above is None:
            return None
        means = _means(inputs)
        if means.is_cuda:
            return self._count_on_host(inputs).to(means.device)
        counts = means.new_empty(means.shape[0], dtype=torch.int32)
        self._call("qs_count_pixels", inputs, (ctypes.byref(frame), self.counts_above,
                                               ctypes.byref(array_of(counts))))
        return counts

    def _count_on_host(self, inputs: Tensors) -> Tensor:
        """The library counts pixels of frames in host memory alone: a frame of copies."""
        copies = [None if tensor is None else tensor.cpu() for tensor in inputs]
        plan = Plan(self.who, chosen(None, self.who, "cpu"), self.camera, self.rules, (), False,
                    self.counts_above)
        frame, blocks = _ffi.QsStageFrame(), Blocks()
        blocks.call(plan, "qs_project", copies, _ffi.QsBoundary(), frame)
        counts = plan.count_pixels(copies, frame)
        assert counts is not None
        return counts

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

    def __init__(self, device: torch.device, inputs: _ffi.QsInputs) -> None:
        self._device = device
        self._blocks: List[Tensor] = []
        self._memory = _ffi.QsMemory(user=id(self), allocate=_allocate)
        inputs.stream = stream_of(device.index)
        inputs.temporary = ctypes.pointer(self._memory)
        _filled[id(self)] = self

    def allocate(self, size: int, _kind: int) -> Optional[int]:
        try:
            self._blocks.append(_bytes_on(self._device, size))
            return self._blocks[-1].data_ptr()
        except BaseException:  # the library says so
            return None

    def free(self) -> None:
        """After the call: torch uses the memory again in the order of the stream."""
        del _filled[id(self)]
        self._blocks.clear()


def _bytes_on(device: torch.device, size: int) -> Tensor:
    """Uninitialised memory. Without a byte a tensor has no address."""
    return torch.empty(size or 1, dtype=torch.uint8, device=device)


class Blocks:
    """The memory of a frame, as tensors of bytes."""

    def __init__(self) -> None:
        self.blocks: List[Optional[Tensor]] = [None] * len(BLOCKS)
        self._device = torch.device("cpu")
        self._error: Optional[BaseException] = None

    def call(self, plan: Plan, function: str, inputs: Tensors, *arguments: Any) -> None:
        """Plan.call() of a function that asks for memory before its other arguments."""
        self._device = _means(inputs).device
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
            block = self.blocks[kind] = _bytes_on(self._device, size)
            return block.data_ptr()
        except BaseException as error:  # ctypes would print it and go on
            self._error = error
            return None


#: The memory of the calls that run, by id().
_filled: Dict[int, Union[Blocks, _Temporary]] = {}


@_ffi.ALLOCATE
def _allocate(user: int, size: int, kind: int) -> Optional[int]:
    return _filled[user].allocate(size, kind)


def copy_of(frame: _ffi.QsStageFrame, blocks: Tensors) -> _ffi.QsStageFrame:
    """The frame with its memory in these blocks."""
    copy = _ffi.QsStageFrame.from_buffer_copy(frame)
    for name, block in zip(BLOCKS, blocks):
        setattr(copy, name, None if block is None else block.data_ptr())
    return copy
