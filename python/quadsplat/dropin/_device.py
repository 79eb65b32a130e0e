# SPDX-License-Identifier: MIT
"""The option --device cpu: tensors that a program puts on `cuda` are on the CPU.

The functions of torch that make or move tensors take "cuda" as "cpu". Questions have honest
answers: torch.cuda.is_available() does not change, and tensors are on "cpu".
"""
from __future__ import annotations

import functools
import time
from types import ModuleType
from typing import Any, Callable

_MAKE = ("arange", "as_tensor", "asarray", "empty", "empty_like", "empty_strided", "eye", "full",
         "full_like", "linspace", "logspace", "ones", "ones_like", "rand", "rand_like", "randint",
         "randint_like", "randn", "randn_like", "randperm", "sparse_coo_tensor", "tensor",
         "tril_indices", "triu_indices", "zeros", "zeros_like")
_NEW = ("new_empty", "new_full", "new_ones", "new_tensor", "new_zeros")


class Event:
    """torch.cuda.Event by the clock of the host."""

    def __init__(self, *_: Any, **__: Any) -> None:
        self._seconds = 0.0

    def record(self, *_: Any) -> None:
        self._seconds = time.perf_counter()

    def elapsed_time(self, end: Event) -> float:
        """Milliseconds."""
        return 1000 * (end._seconds - self._seconds)

    def query(self) -> bool:
        return True

    def synchronize(self) -> None:
        pass

    def wait(self, *_: Any) -> None:
        pass


def map_to_cpu(torch: ModuleType) -> None:
    """Maps the calls of this process."""
    if torch.cuda.Event is Event:
        return

    def mapped(device: Any) -> Any:
        is_cuda = str(device).startswith("cuda") if isinstance(device, (str, torch.device)) else (
            type(device) is int)
        return "cpu" if is_cuda else device

    def with_device(function: Callable[..., Any], name: str = "device") -> Callable[..., Any]:
        @functools.wraps(function)
        def call(*args: Any, **options: Any) -> Any:
            if name in options:
                options[name] = mapped(options[name])
            return function(*args, **options)

        return call

    def moved(function: Callable[..., Any]) -> Callable[..., Any]:
        call = with_device(function)
        return functools.wraps(function)(
            lambda self, *args, **options: call(self, *map(mapped, args[:1]), *args[1:], **options))

    for name in _MAKE:
        if hasattr(torch, name):
            setattr(torch, name, with_device(getattr(torch, name)))
    for name in _NEW:
        setattr(torch.Tensor, name, with_device(getattr(torch.Tensor, name)))
    torch.load = with_device(torch.load, "map_location")
    for kind in (torch.Tensor, torch.nn.Module):
        kind.to = moved(kind.to)
        kind.cuda = lambda self, *_, **__: self
    torch.Tensor.pin_memory = lambda self, *_, **__: self
    torch.cuda.Event = Event
    for name in ("empty_cache", "reset_peak_memory_stats", "set_device", "synchronize"):
        setattr(torch.cuda, name, lambda *_, **__: None)
    torch.cuda.current_device = lambda: 0
