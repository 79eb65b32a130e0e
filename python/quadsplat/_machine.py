# SPDX-License-Identifier: MIT
"""The library, its culling modes, and the devices of this machine."""
from __future__ import annotations

import ctypes
from typing import List, NamedTuple, Optional, Tuple

from . import _ffi


class Device(NamedTuple):
    """A GPU."""

    number: int  #: CUDA's number
    name: str
    compute_capability: Tuple[int, int]
    total_bytes: int
    free_bytes: int
    problem: str  #: the reason why it cannot be used; empty: it can


class Report(NamedTuple):
    """The library and the devices of this machine. str() is a text of a few lines."""

    version: str  #: quadsplat's version
    threads: int  #: hardware threads of the CPU
    driver: str  #: newest CUDA version that the driver supports; empty: no driver
    runtime: str  #: CUDA version of the library; empty: built without CUDA
    first_gpu: Optional[int]  #: number of the first GPU that can be used
    cuda_problem: str  #: the reason why no GPU can be used, a sentence; empty: one can
    devices: Tuple[Device, ...]

    def __str__(self) -> str:
        lines = [f"quadsplat {self.version}, {self.threads} CPU threads"]
        if self.runtime:
            lines.append(f"CUDA {self.runtime}, driver for CUDA {self.driver or 'none'}")
        for device in self.devices:
            major, minor = device.compute_capability
            lines.append(f"GPU {device.number}: {device.name}, compute capability {major}.{minor}, "
                         f"{device.total_bytes / 2**30:.1f} GiB"
                         + (f": {device.problem}" if device.problem else ""))
        if self.cuda_problem:
            lines.append(self.cuda_problem)
        return "\n".join(lines)


class Mode(NamedTuple):
    """A culling mode."""

    name: str
    summary: str
    is_lossless: bool  #: lists every tile with a pixel of alpha >= 1/255
    keeps_faint: bool  #: also lists Gaussians of opacity <= 1/255
    is_peer: bool  #: the mode is another paper's, and not counted by counts()


def report() -> Report:
    """Asks the driver for the devices. Opens CUDA's context on every GPU. Raises DeviceError."""
    found = _ffi.QsReport()
    _ffi.call("report", "qs_report", ctypes.byref(found), None, 0)
    gpus = _ffi.array_of(_ffi.QsGpu, found.gpus)
    if len(gpus) > 0:
        _ffi.call("report", "qs_report", ctypes.byref(found), gpus, len(gpus))
    listed = tuple(
        Device(number, _ffi.text(gpu.name), (gpu.major, gpu.minor), gpu.total_bytes,
               gpu.free_bytes, _ffi.text(gpu.problem)) for number, gpu in enumerate(gpus))
    return Report(_ffi.VERSION, found.threads, _ffi.text(found.driver), _ffi.text(found.runtime),
                  None if found.first_gpu < 0 else found.first_gpu,
                  _ffi.text(found.cuda_problem), listed)


def devices() -> Tuple[Device, ...]:
    """The GPUs of this machine, also GPUs that cannot be used. Empty without CUDA."""
    return report().devices


def modes() -> List[Mode]:
    """All culling modes; the first is "reference", in double precision on the CPU, slow."""
    count = ctypes.c_uint32(1)
    found: List[Mode] = []
    while len(found) < count.value:
        mode = _ffi.QsMode()
        _ffi.call("modes", "qs_mode", len(found), ctypes.byref(mode), ctypes.byref(count))
        found.append(Mode(_ffi.text(mode.name), _ffi.text(mode.summary), bool(mode.is_lossless),
                          bool(mode.keeps_faint), bool(mode.is_peer)))
    return found
