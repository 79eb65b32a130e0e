# SPDX-License-Identifier: MIT
"""Contexts: a backend, a GPU and threads of the CPU."""
from __future__ import annotations

import collections
import ctypes
import os
import threading
import weakref
from types import TracebackType
from typing import Any, Deque, Dict, Optional, Tuple, Type

from . import _ffi
from ._checks import choice, integer
from ._errors import UsageError
from ._warn import warn


class _Handle:
    """The library's context. It outlives the scenes in it, which finalizers close on any thread."""

    def __init__(self, pointer: int) -> None:
        self.pointer: Optional[int] = pointer
        self.process = os.getpid()
        self.lock = threading.Lock()  # held during calls
        self.user: Optional[Use] = None  # the use that holds the lock
        self.stopping = threading.Lock()  # guards `user`, and a pointer that is used without `lock`
        self._unused: Deque[int] = collections.deque()  # scenes to be closed

    def close_scene(self, scene: int) -> None:
        """Closes the scene, now or when the call that uses the context ends."""
        if os.getpid() == self.process:
            self._unused.append(scene)
            self.close_unused()

    def close_unused(self) -> None:
        while self._unused and self.lock.acquire(blocking=False):
            try:
                _ffi.library.qs_scene_close(self._unused.popleft())
            except IndexError:
                pass
            finally:
                self.lock.release()

    def require_other_thread(self, who: str) -> None:
        """Raises UsageError in a callback of the call that uses the context, which would wait for itself."""
        user = self.user
        is_own = user is not None and user.thread == threading.get_ident()
        if is_own and os.getpid() == self.process:
            raise UsageError(f"{who}: the context is used by the call that called this callback: "
                             "open another context, or wait for the end of the call")

    def stop(self, user: Optional[Use] = None) -> None:
        """Ends the call that uses the context; with `user`, only the call of this use."""
        if os.getpid() != self.process:
            return
        with self.stopping:
            if self.pointer and user in (None, self.user):
                _ffi.library.qs_stop(self.pointer)

    def close(self) -> None:
        if os.getpid() != self.process:
            return
        self.require_other_thread("Context.close")
        with self.lock, self.stopping:
            pointer, self.pointer = self.pointer, None
        if pointer:
            _ffi.library.qs_context_close(pointer)
        self.close_unused()


class Use:
    """The use of a context by a call: other threads wait."""

    def __init__(self, handle: _Handle, who: str) -> None:
        self._handle = handle
        self._who = who
        self.thread: Optional[int] = None  # the thread that entered

    def __enter__(self) -> int:
        handle = self._handle
        # First, because another thread may have held the lock when the process was forked.
        if os.getpid() != handle.process:
            raise UsageError(f"{self._who}: the context belongs to the process from which this "
                             "process was forked: load the scene here, or start processes by "
                             "multiprocessing's method spawn")
        handle.lock.acquire()
        if handle.pointer is None:
            handle.lock.release()
            raise UsageError(f"{self._who}: the context was closed")
        self.thread = threading.get_ident()
        handle.user = self
        return handle.pointer

    def __exit__(self, *_: Any) -> None:
        with self._handle.stopping:  # so that stop() ends no later call
            self._handle.user = None
        self._handle.lock.release()
        self._handle.close_unused()

    def stop(self) -> None:
        """Ends this call, if it has begun and has not ended."""
        self._handle.stop(self)


class Context:
    """A backend, a GPU and threads of the CPU. Scenes are loaded into a context.

    Without a context, functions use one of the process, which draws on the GPU where that works.
    Calls of several threads with one context wait for each other. A thread with a context of its
    own does not wait. A context may be used as a `with` block, which closes it.

    backend: "auto" (CUDA where it works, else the CPU), "cpu" or "cuda".
    device: CUDA's number of the GPU; None: the first that works.
    threads: of the CPU, with the calling thread, 1..1024; 0: one per hardware thread. Results do
        not depend on their number.

    Raises DeviceError if the backend does not work, and UsageError.
    """

    def __init__(self, backend: str = "auto", device: Optional[int] = None,
                 threads: int = 0) -> None:
        who = "Context"
        number = choice(backend, f"{who}: backend", _ffi.BACKENDS)
        gpu = _ffi.FIRST_GPU if device is None else integer(device, f"{who}: device", 0, 2**31 - 1)
        count = integer(threads, f"{who}: threads", 0, 1024)
        pointer = ctypes.c_void_p()
        _ffi.call(who, "qs_context_open", number, gpu, count, ctypes.byref(pointer))
        assert pointer.value is not None
        self._handle = _Handle(pointer.value)
        self._finalizer = weakref.finalize(self, _Handle.close, self._handle)
        self._backend = "cpu" if _ffi.library.qs_context_backend(pointer) == 1 else "cuda"
        if backend == "auto" and self._backend == "cpu":
            _say_why_cpu()

    @property
    def backend(self) -> str:
        """"cpu" or "cuda"."""
        return self._backend

    def stop(self) -> None:
        """Ends a call that runs on another thread: it raises Cancelled soon, or finishes.

        Without such a call it does nothing.
        """
        self._handle.stop()

    def close(self) -> None:
        """Waits for a running call and frees the context. Its scenes can only be closed then.

        Raises UsageError in a callback of a call that uses the context.
        """
        self._handle.require_other_thread("Context.close")
        self._finalizer()

    def __enter__(self) -> Context:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        state = ", closed" if self._handle.pointer is None else ""
        return f"<quadsplat.Context: {self._backend}{state}>"

    def __reduce__(self) -> Any:
        raise UsageError("Context: it cannot be pickled: open one in each process")

    def _use(self, who: str) -> Use:
        self._handle.require_other_thread(who)
        return Use(self._handle, who)


_said_why = False


def _say_why_cpu() -> None:
    global _said_why
    if _said_why:
        return
    _said_why = True
    report = _ffi.QsReport()
    _ffi.call("Context", "qs_report", ctypes.byref(report), None, 0)
    reason = _ffi.text(report.cuda_problem) or "no GPU can be used"
    warn(f"quadsplat draws on the CPU: {reason}", RuntimeWarning)


_defaults: Dict[Tuple[int, str, Optional[int]], Context] = {}
_defaults_lock = threading.Lock()


def _forget_defaults() -> None:
    global _defaults_lock
    _defaults_lock = threading.Lock()


os.register_at_fork(after_in_child=_forget_defaults)


def default_context(backend: str = "auto", device: Optional[int] = None) -> Context:
    """The context of the process, opened by the first call."""
    with _defaults_lock:
        key = (os.getpid(), backend, device)
        found = _defaults.get(key)
        if found is None or found._handle.pointer is None:
            found = _defaults[key] = Context(backend, device)
        return found


def chosen(context: Optional[Context], who: str, backend: str = "auto",
           device: Optional[int] = None) -> Context:
    """The given context, or the process's."""
    if context is None:
        return default_context(backend, device)
    if not isinstance(context, Context):
        raise UsageError(f"{who}: context is {context!r} instead of a quadsplat.Context")
    return context
