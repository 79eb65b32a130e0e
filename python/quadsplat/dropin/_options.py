# SPDX-License-Identifier: MIT
"""The options of the drop-in. They are in the environment, so that child processes have them."""
from __future__ import annotations

import os
from typing import Optional

from .._errors import UsageError
from .._machine import modes

#: Members of the family of diff_gaussian_rasterization.
VARIANTS = ("original", "dr_aa", "3dgs_accel", "w-pose", "absgs", "mcmc", "taming")

DEVICES = ("cpu",)

_CULL, _VARIANT, _DEVICE = (
    "QUADSPLAT_DROPIN_" + name for name in ("CULL", "VARIANT", "DEVICE"))


def cull() -> Optional[str]:
    """The culling mode that was asked for."""
    return os.environ.get(_CULL)


def variant() -> Optional[str]:
    """The variant that was asked for."""
    return os.environ.get(_VARIANT)


def device() -> Optional[str]:
    """The device in place of `cuda`; None: programs use the device that they name."""
    return os.environ.get(_DEVICE)


def choose(mode: Optional[str], name: Optional[str], place: Optional[str]) -> None:
    """Sets the options of this process and its children. Raises UsageError."""
    known = [mode.name for mode in modes() if mode.name != "reference"]
    if mode is not None and mode not in known:
        raise UsageError(f"dropin: cull: {mode!r} is none of {', '.join(known)}")
    if name is not None and name not in VARIANTS:
        raise UsageError(f"dropin: variant: {name!r} is none of {', '.join(VARIANTS)}")
    if name == "taming":
        from ._refusals import TAMING

        raise UsageError(f"dropin: variant: {TAMING}")
    if place is not None and place not in DEVICES:
        raise UsageError(f"dropin: device: {place!r} is none of {', '.join(DEVICES)}")
    for key, value in ((_CULL, mode), (_VARIANT, name), (_DEVICE, place)):
        if value is not None:
            os.environ[key] = value
