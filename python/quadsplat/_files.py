# SPDX-License-Identifier: MIT
"""Files of pictures."""
from __future__ import annotations

import ctypes
from os import PathLike
from typing import Union

import numpy as np

from . import _ffi
from ._arrays import copy_of
from ._checks import encoded_path


def read_picture(path: Union[str, PathLike[str]]) -> np.ndarray:
    """A file of a picture as height x width x channels, 1 to 4, float32, integers as 0..1.

    Raises InputError if the file is missing or damaged, and DeviceError if the format needs a
    missing module.
    """
    handle, values = ctypes.c_void_p(), _ffi.QsArray()
    _ffi.call("read_picture", "qs_picture_open", encoded_path(path, "read_picture: path"),
              ctypes.byref(handle), ctypes.byref(values))
    try:
        return copy_of(values)
    finally:
        _ffi.library.qs_picture_close(handle)
