# SPDX-License-Identifier: MIT
"""Warnings that name the line of the caller."""
from __future__ import annotations

import sys
import warnings
from typing import Type


def warn(sentence: str, category: Type[Warning]) -> None:
    """Warns at the line outside of this package that called it."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(sentence, category, stacklevel=level)
