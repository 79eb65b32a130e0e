# SPDX-License-Identifier: MIT
"""What the passes of a frame share besides tensors, and the calls of the library."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, Optional, Sequence, Tuple

import torch

from .. import _ffi
from .._context import Context
from .._errors import UsageError
from ._memory import Blocks, Call, register, unregister
from ._tensors import Tensor, array_of, places_of, put_all, put_part, stream_of

#: The tensors of QsInputs, in the order in which they are handed on; None: absent.
INPUTS = ("means", "scales", "rotations", "covariances", "opacities", "sh", "sh_rest", "channels",
          "background", "position")
#: The pictures of QsBlended.
PICTURES = ("color", "alpha", "depth", "inverse_depth")

_byref = ctypes.byref
_INPUT_PLACES = places_of(_ffi.QsInputs, INPUTS)

Tensors = Sequence[Optional[Tensor]]


class Plan:
    """A frame's camera and rules, and which results are wanted in which layout.

    counts_above: transmittance for the counts of pixels; None: they are not wanted.
    position: the point from which colours are seen, on the host, if it is not an input.
    is_ndc: derivatives by the centres are by normalised device coordinates, and radii are one
        number per Gaussian.
    """

    def __init__(self, who: str, context: Context, camera: _ffi.QsCamera, rules: _ffi.QsRules,
                 pictures: Tuple[str, ...], is_planar: bool,
                 counts_above: Optional[float] = None, position: Any = None,
                 is_ndc: bool = False) -> None:
        self.who = who
        self.context = context
        self.camera = camera
        self.rules = rules
        self.pictures = pictures
        self.is_planar = is_planar
        self.counts_above = counts_above
        self.position = position
        self.is_ndc = is_ndc

    def call(self, function: str, inputs: Tensors, *arguments: ctypes.Structure) -> None:
        """Calls a function of the library with the inputs, camera and rules in front."""
        self._call(function, inputs, map(_byref, arguments))

    def fill(self, function: str, inputs: Tensors, blocks: Blocks,
             *arguments: ctypes.Structure) -> None:
        """call() of a function that asks for memory of a frame before its other arguments."""
        register(blocks)
        try:
            self.call(function, inputs, blocks.memory, *arguments)
        except Exception:
            if blocks.error is not None:
                raise blocks.error from None
            raise
        finally:
            unregister(blocks)

    def _call(self, function: str, inputs: Tensors, arguments: Iterable[Any]) -> None:
        given = _ffi.QsInputs()
        put_all(given, _INPUT_PLACES, inputs)
        if self.position is not None:
            given.position = _host_numbers(self.position)
        means = _means(inputs)
        if not means.is_cuda:
            self._run(function, given, arguments, False)
            return
        with Call(means.device) as call:
            given.stream = call.stream
            given.temporary = call.memory
            self._run(function, given, arguments, True)

    def _run(self, function: str, given: _ffi.QsInputs, arguments: Iterable[Any],
             on_gpu: bool) -> None:
        with self.context._use(self.who) as pointer:
            _ffi.call(self.who, function, pointer, _byref(given), _byref(self.camera),
                      _byref(self.rules), *arguments, on_gpu=on_gpu)

    def count_pixels(self, inputs: Tensors, frame: _ffi.QsStageFrame) -> Optional[Tensor]:
        """The number of pixels of every Gaussian, if it is wanted, beside the Gaussians."""
        if self.counts_above is None:
            return None
        means = _means(inputs)
        counts = means.new_empty(means.shape[0], dtype=torch.int32)
        self._call("qs_count_pixels", inputs, (ctypes.byref(frame), self.counts_above,
                                               ctypes.byref(array_of(counts))))
        return counts

    def empty_pictures(self, inputs: Tensors, batch: int = 0) -> Dict[str, Tensor]:
        """Tensors for the wanted pictures. batch: 1: they are 1 x height x width x C all."""
        means, channels = _means(inputs), inputs[INPUTS.index("channels")]
        height, width = self.camera.height, self.camera.width
        count = 3 if channels is None else channels.shape[-1]
        color, one = (height, width, count), (height, width)
        if batch:
            color, one = (1, *color), (1, *one, 1)
        elif self.is_planar:
            color = (count, height, width)
        return {name: means.new_empty(color if name == "color" else one)
                for name in self.pictures}

    def blended(self, pictures: Dict[str, Tensor]) -> _ffi.QsBlended:
        """The struct of pictures, or of derivatives by them."""
        struct = _ffi.QsBlended()
        for name, tensor in pictures.items():
            shape, strides = tensor.shape, tensor.stride()
            if len(shape) == 4:
                shape, strides = shape[1:], strides[1:]
            if name != "color":
                shape, strides = shape[:2], strides[:2]
            elif self.is_planar:
                shape, strides = (*shape[1:], shape[0]), (*strides[1:], strides[0])
            put_part(struct, name, tensor, shape, strides)
        return struct


def _host_numbers(numbers: Any) -> _ffi.QsArray:
    """An array of ctypes' doubles, which must outlive the struct."""
    struct = _ffi.QsArray(data=ctypes.addressof(numbers), dimensions=1, type=_ffi.FLOAT64)
    struct.sizes[0], struct.strides[0] = len(numbers), 1
    return struct


def camera_of(who: str, names: Dict[str, str], context: Context, camera: _ffi.QsCamera,
              matrices: _ffi.QsMatrices, device: torch.device) -> None:
    """Sets the camera's pose and lens from matrices. names: of their members, for sentences."""
    on_gpu = device.type == "cuda"
    if on_gpu:
        matrices.stream = stream_of(device.index)
    try:
        with context._use(who) as pointer:
            _ffi.call(who, "qs_camera_of_matrices", pointer, _byref(matrices), _byref(camera),
                      on_gpu=on_gpu)
    except UsageError as error:
        sentence = str(error)
        for member, name in names.items():
            sentence = sentence.replace(f": {member}: ", f": {name}: ", 1)
        raise UsageError(sentence) from None


def _means(inputs: Tensors) -> Tensor:
    assert inputs[0] is not None
    return inputs[0]
