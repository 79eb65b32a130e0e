# SPDX-License-Identifier: MIT
"""Locks: one per GPU of this machine, so that two jobs never share one, and one per training folder.

A lock is a flock() on an open file. Children inherit the file, so the lock lasts as long as the last process that works
under it, even if its parent was killed.
"""
import contextlib
import fcntl
import os
import pathlib
import tempfile
import time
from typing import Iterator, Optional

POLL_S = 0.2


def try_lock(path: pathlib.Path) -> Optional[int]:
    """A descriptor that children inherit, or None if another process has the lock."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    os.set_inheritable(descriptor, True)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return descriptor
    except BlockingIOError:
        os.close(descriptor)
        return None


@contextlib.contextmanager
def locked(path: pathlib.Path) -> Iterator[int]:
    """Waits until nobody else has the lock."""
    while (descriptor := try_lock(path)) is None:
        time.sleep(POLL_S)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def gpu_lock(number: str) -> pathlib.Path:
    return pathlib.Path(tempfile.gettempdir()) / f"quadsplat_gpu_{number}.lock"


@contextlib.contextmanager
def one_gpu(gpus: list[str]) -> Iterator[tuple[dict[str, str], list[int]]]:
    """Waits for a free GPU. Yields the variables of the environment that choose it, and the descriptor of its lock.

    Without GPUs, and under Slurm, which chooses a GPU itself, both are empty.
    """
    if not gpus or "SLURM_JOB_ID" in os.environ:
        yield {}, []
        return
    while True:
        for number in gpus:
            if (descriptor := try_lock(gpu_lock(number))) is not None:
                try:
                    yield {"CUDA_VISIBLE_DEVICES": number}, [descriptor]
                finally:
                    os.close(descriptor)
                return
        time.sleep(POLL_S)
