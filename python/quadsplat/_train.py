# SPDX-License-Identifier: MIT
"""Training of scenes from photographs."""
from __future__ import annotations

import ctypes
import math
import threading
from os import PathLike
from typing import Any, Callable, List, NamedTuple, Optional, Union

from . import _ffi
from ._checks import encoded, encoded_path
from ._context import Context, chosen
from ._errors import Cancelled, UsageError

Path = Union[str, "PathLike[str]"]


class Training(NamedTuple):
    """The state of a run. NaN: not known yet."""

    iteration: int  #: iterations that are done; 0 before the first
    iterations: int  #: number of iterations of the whole run
    gaussians: int
    loss: float  #: loss of the last iteration; 0 before the first
    seconds: float  #: time of all iterations, also of earlier runs, without evaluations
    evaluated: int  #: the iteration of the last evaluation; 0: none yet
    test_psnr: float  #: dB on the test views
    test_ssim: float
    guard_psnr: float  #: dB on the views that `guard=True` reserves
    guarded: int  #: the iteration of that measurement; 0: none yet
    growth_ended: int  #: the iteration after which the guard ended growth; 0: it did not

    @property
    def finished(self) -> bool:
        """False if the run was ended before its last iteration."""
        return self.iteration >= self.iterations


def train(data: Path, model: Path, *, iterations: Optional[int] = None,
          callback: Optional[Callable[[Training], Any]] = None,
          text: Optional[Callable[[str], Any]] = None, context: Optional[Context] = None,
          **options: Any) -> Training:
    """Trains a model from photographs, as the program does, to the same bytes.

    data: a folder of COLMAP, or one with a transforms.json or cameras.json.
    model: the folder of the trained model, new or empty. load() opens it.
    iterations: training steps; None: 70 for each training view, from 3000 to 30000, or 30000 with another strategy than paced.
    callback: called with the state before the first iteration, after each iteration and after the
        last evaluation. A true result ends the run; an exception ends it and is raised here.
    text: called with each sentence that the program would print, for example print.
    context: trains, and cannot be used meanwhile; None: a context of its own, on the GPU where that
        works.
    options: the options of `quadsplat train` without dashes, `sh_degree=2` for --sh-degree 2. Values are
        texts, numbers, paths, sequences of numbers, and True or False for options that are on or
        off. None: the default.

    Both callbacks run in another thread. Ctrl+C, Context.stop() and a true result of the callback
    end the run after its iteration; the model is saved, and `resume=True` continues it.

    Returns the last state. Raises KeyboardInterrupt after Ctrl+C, Cancelled after Context.stop(),
    UsageError, InputError and DeviceError, in the sentences of the program.
    """
    who = "train"
    given = _ffi.QsTraining()
    given.data = encoded_path(data, f"{who}: data")
    given.model = encoded_path(model, f"{who}: model")
    if iterations is not None:
        options["iterations"] = iterations
    pairs = [(encoded(name, who), _value(value, f"{who}: {name}"))
             for name, value in options.items() if value is not None]
    list_of = (_ffi.QsOption * len(pairs))(*pairs)
    given.options = ctypes.cast(list_of, ctypes.c_void_p)
    given.option_count = len(pairs)
    calls = _Callbacks(callback, text)
    given.progress, given.text = calls.progress, calls.text
    if context is not None:
        return _run(given, calls, chosen(context, who), who)
    with Context() as own:
        return _run(given, calls, own, who)


class _Callbacks:
    """The functions that the library calls, which it refers to during the run."""

    def __init__(self, callback: Optional[Callable[[Training], Any]],
                 text: Optional[Callable[[str], Any]]) -> None:
        self.error: Optional[BaseException] = None
        self.wants_end = False

        def on_progress(_: Any, state: Any) -> int:
            if callback is not None and not self.wants_end:
                self._guard(lambda: self._end_if(callback(_state_of(state.contents))))
            return int(self.wants_end)

        def on_text(_: Any, sentence: bytes) -> None:
            if text is not None and self.error is None:
                self._guard(lambda: text(_ffi.text(sentence)))

        self.progress = _ffi.PROGRESS(on_progress)
        self.text = _ffi.TEXT(on_text)

    def _end_if(self, result: Any) -> None:
        self.wants_end = bool(result)

    def _guard(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:  # it cannot pass through the library
            self.error, self.wants_end = error, True


def _run(given: _ffi.QsTraining, calls: _Callbacks, context: Context, who: str) -> Training:
    """Trains in another thread, because the main thread must notice Ctrl+C."""
    state = _ffi.QsTrainingState()
    raised: List[BaseException] = []
    done = threading.Event()
    use = context._use(who)

    def work() -> None:
        try:
            with use as pointer:
                _ffi.call(who, "qs_train", pointer, ctypes.byref(given), ctypes.byref(state))
        except BaseException as error:
            raised.append(error)
        finally:
            done.set()

    threading.Thread(target=work, name="quadsplat.train", daemon=True).start()
    interrupt: Optional[BaseException] = None
    while True:
        try:
            if interrupt is not None:
                use.stop()  # again: the call may not have begun
            if done.wait(0.1):
                break
        except KeyboardInterrupt as error:
            interrupt = error
    for error in (calls.error, interrupt):
        if error is not None:
            raise error
    if raised and not (isinstance(raised[0], Cancelled) and calls.wants_end):
        raise raised[0]
    return _state_of(state)


def _state_of(state: _ffi.QsTrainingState) -> Training:
    return Training(state.iteration, state.iterations, state.gaussians, state.loss, state.seconds,
                    state.evaluated, _known(state.test_psnr), _known(state.test_ssim),
                    _known(state.guard_psnr), state.guarded, state.growth_ended)


def _known(value: float) -> float:
    """The value; NaN is always the same object, so that equal states compare equal."""
    return math.nan if math.isnan(value) else value


def _value(value: Any, where: str) -> bytes:
    """The text of a value on the command line."""
    if isinstance(value, bool):
        return b"on" if value else b"off"
    if isinstance(value, PathLike):
        return encoded_path(value, where)
    if isinstance(value, str):
        return encoded(value, where)
    try:
        parts = tuple(value)
    except TypeError:
        parts = (value,)
    try:
        return ",".join(map(_number, parts)).encode()
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{where} is {value!r} instead of a text or numbers") from None


def _number(value: Any) -> str:
    """Plain decimals."""
    if int(value) == value:
        return str(int(value))
    text = repr(float(value))
    return f"{float(value):.30f}".rstrip("0") if "e" in text else text
