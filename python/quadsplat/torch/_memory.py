# SPDX-License-Identifier: MIT
"""Memory of calls and frames, which is kept from one to the next.

torch gives it once. Then frames and calls of the same stream use it again in the stream's order, also
if a program empties torch's cache in every iteration. Kept blocks have the sizes of the last frames.
"""
from __future__ import annotations

import collections
import ctypes
import functools
import threading
from typing import Any, Deque, Dict, List, Optional, Tuple, Union

import torch

from .. import _ffi
from ._tensors import Tensor, stream_of

_SMALL = 1 << 20  # bytes: blocks up to this size fit every smaller request
_MOST = 2  # kept blocks of a kind and a stream: a new frame begins before the old one ends
_ALIGNMENT = 256

#: The device's index, -1 for the CPU, and the stream.
Place = Tuple[int, int]


class _Kept:
    """A block that no frame uses."""

    __slots__ = ("tensor", "size", "round")

    def __init__(self, tensor: Tensor) -> None:
        self.tensor = tensor
        self.size = tensor.numel()
        self.round = _round


_blocks: Dict[Tuple[Place, int], List[_Kept]] = {}
_arenas: Dict[Place, Arena] = {}
_returned: Deque[Tuple[Place, int, Tensor]] = collections.deque()  #: of freed frames
_lock = threading.Lock()
_round = 0  # grows with free_unused()


def place_of(device: torch.device) -> Place:
    """The place of work that torch enqueues now for tensors of this device."""
    return (-1, 0) if device.type == "cpu" else (device.index, stream_of(device.index))


def _device_of(place: Place) -> torch.device:
    return torch.device("cpu") if place[0] < 0 else torch.device("cuda", place[0])


def _bytes_on(place: Place, size: int) -> Tensor:
    """Uninitialised memory of torch. If there is none, kept memory is freed first."""
    device = _device_of(place)
    try:
        return torch.empty(size, dtype=torch.uint8, device=device)
    except RuntimeError:
        free_all()
        return torch.empty(size, dtype=torch.uint8, device=device)


def _keep_returned() -> None:
    """With the lock: keeps the blocks of freed frames."""
    while _returned:
        place, kind, tensor = _returned.popleft()
        kept = _blocks.setdefault((place, kind), [])
        kept.append(_Kept(tensor))
        del kept[:-_MOST]


def free_all() -> None:
    """Frees all kept memory, to torch's allocator."""
    with _lock:
        _returned.clear()
        _blocks.clear()
        _arenas.clear()


def free_unused() -> None:
    """Frees the memory that was not used since the last call of this function."""
    global _round
    with _lock:
        _keep_returned()
        for kept in _blocks.values():
            kept[:] = [block for block in kept if block.round == _round]
        for place in [place for place, arena in _arenas.items() if arena.round != _round]:
            del _arenas[place]
        _round += 1


def follow_empty_cache() -> None:
    """Lets torch.cuda.empty_cache() free unused memory too. Programs that call it in every iteration
    keep the memory of their frames."""
    plain = torch.cuda.empty_cache
    if getattr(plain, "frees_kept_memory", False):
        return

    @functools.wraps(plain)
    def empty_cache() -> None:
        free_unused()
        plain()

    empty_cache.frees_kept_memory = True  # type: ignore[attr-defined]
    torch.cuda.empty_cache = empty_cache


class Blocks:
    """The blocks of a frame. They are kept for the next frame when this one is freed."""

    def __init__(self, place: Place) -> None:
        self.is_freed = False
        self.error: Optional[BaseException] = None
        self._place = place
        self._held: List[Tuple[int, Tensor]] = []
        self.memory = _ffi.QsMemory(user=id(self), allocate=_allocate)

    def allocate(self, size: int, kind: int) -> Optional[int]:
        try:
            block = self._taken(size, kind)
            if block is None:
                # Views have unequal numbers of pairs: room for the next frame.
                block = _bytes_on(self._place, max(size + size // 8, _ALIGNMENT))
            self._held.append((kind, block))
            return block.data_ptr()
        except BaseException as error:  # ctypes would print it and go on
            self.error = error
            return None

    def _taken(self, size: int, kind: int) -> Optional[Tensor]:
        with _lock:
            _keep_returned()
            kept = _blocks.get((self._place, kind))
            if not kept:
                return None
            for number, block in enumerate(kept):
                if size <= block.size <= 2 * size + _SMALL:
                    return kept.pop(number).tensor
            kept.clear()  # frames have another size now
        return None

    def free(self) -> None:
        """After the last call that uses them; later work of the stream may overwrite them."""
        self.is_freed = True
        held, self._held = self._held, []
        _returned.extend((self._place, kind, tensor) for kind, tensor in held)
        # Python may free a frame at any point of a thread, also at one that holds the lock. Then
        # the blocks wait.
        if _lock.acquire(blocking=False):
            try:
                _keep_returned()
            finally:
                _lock.release()

    def __del__(self) -> None:
        if self._held:
            self.free()


class Arena:
    """Temporary memory of a call on a GPU: one block, as large as the last calls needed."""

    def __init__(self, place: Place) -> None:
        self.round = 0
        self.error: Optional[BaseException] = None
        self._place = place
        self._block: Optional[Tensor] = None
        self._base = self._size = 0
        self._at = 0  # bytes that the call uses of the block
        self._more: List[Tensor] = []  # of a call that needs more
        self._missing = 0
        self._peak = 0.0
        self.memory = ctypes.pointer(_ffi.QsMemory(user=id(self), allocate=_allocate))

    def allocate(self, size: int, _kind: int) -> Optional[int]:
        size = (size + _ALIGNMENT - 1) // _ALIGNMENT * _ALIGNMENT
        begin, end = self._at, self._at + size
        if end <= self._size:
            self._at = end
            return self._base + begin
        try:
            self._more.append(_bytes_on(self._place, size))
        except BaseException as error:
            self.error = error
            return None
        self._missing += size
        return self._more[-1].data_ptr()

    def finish(self) -> None:
        """After the call."""
        needed = self._at + self._missing
        self._peak = max(needed, 0.98 * self._peak)
        if self._missing or self._size > 2 * self._peak + _SMALL:
            self._more.clear()
            self._block = None
            self._size = 0
            try:
                self._block = _bytes_on(self._place, max(int(1.125 * self._peak), _ALIGNMENT))
                self._base, self._size = self._block.data_ptr(), self._block.numel()
            except RuntimeError:  # the next call asks for its parts
                pass
        self._at = self._missing = 0
        self.round = _round


class Call:
    """A call of the library on a GPU, as a `with` block: its stream and temporary memory."""

    def __init__(self, device: torch.device) -> None:
        self._place = place_of(device)
        self.stream = self._place[1]

    def __enter__(self) -> Call:
        with _lock:
            arena = _arenas.pop(self._place, None)  # no other call uses it
        self._arena = arena or Arena(self._place)
        self.memory = self._arena.memory
        register(self._arena)
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        arena = self._arena
        unregister(arena)
        error, arena.error = arena.error, None
        arena.finish()
        with _lock:
            _arenas[self._place] = arena
        if error is not None and kind is not None:
            raise error from None


#: The owners of memory of the calls that run, by id().
_owners: Dict[int, Union[Blocks, Arena]] = {}


def register(owner: Union[Blocks, Arena]) -> None:
    _owners[id(owner)] = owner


def unregister(owner: Union[Blocks, Arena]) -> None:
    del _owners[id(owner)]


@_ffi.ALLOCATE
def _allocate(user: int, size: int, kind: int) -> Optional[int]:
    return _owners[user].allocate(size, kind)
