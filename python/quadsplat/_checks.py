# SPDX-License-Identifier: MIT
"""Checks of arguments, before ctypes would cut their values."""
from __future__ import annotations

import operator
import os
from typing import Any, Iterable, Mapping, Tuple

from ._errors import UsageError


def integer(value: Any, where: str, low: int, high: int) -> int:
    """The value as an int of low..high."""
    try:
        number = operator.index(value)
    except TypeError:
        raise UsageError(f"{where} is {value!r} instead of an integer") from None
    if not low <= number <= high:
        raise UsageError(f"{where}: {number} is not between {low} and {high}")
    return number


def real(value: Any, where: str) -> float:
    """The value as a float. The library checks its range."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError, RuntimeError):
        raise UsageError(f"{where} is {value!r} instead of a number") from None


def reals(value: Any, where: str, count: int) -> Tuple[float, ...]:
    """The value as a tuple of floats."""
    try:
        values = tuple(value)
    except (TypeError, RuntimeError):
        values = ()
    if len(values) != count or isinstance(value, str):
        raise UsageError(f"{where} is {value!r} instead of {count} numbers")
    return tuple(real(element, where) for element in values)


def choice(value: Any, where: str, table: Mapping[Any, int]) -> int:
    """The number of a word of the table."""
    try:
        return table[value]
    except (KeyError, TypeError):
        words = ", ".join(repr(word) for word in table)
        raise UsageError(f"{where}: {value!r} is none of {words}") from None


def words(value: Any, where: str, known: Iterable[str]) -> Tuple[str, ...]:
    """One of the known words, or several, as a tuple."""
    try:
        given = (value,) if isinstance(value, str) else tuple(value)
    except TypeError:
        raise UsageError(f"{where} is {value!r} instead of words") from None
    names = tuple(known)
    for word in given:
        if word not in names:
            raise UsageError(f"{where}: {word!r} is none of {', '.join(names)}")
    return given


def encoded(value: Any, where: str) -> bytes:
    """A text for the library."""
    if not isinstance(value, str):
        raise UsageError(f"{where} is {value!r} instead of a text")
    if "\0" in value:
        raise UsageError(f"{where} has a character of code 0")
    return value.encode(errors="surrogateescape")


def encoded_path(value: Any, where: str) -> bytes:
    """A path for the library."""
    try:
        path = os.fsencode(value)
    except TypeError:
        raise UsageError(f"{where} is {value!r} instead of a path") from None
    if b"\0" in path:
        raise UsageError(f"{where} has a character of code 0")
    return path
