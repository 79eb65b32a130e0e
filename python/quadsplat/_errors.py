# SPDX-License-Identifier: MIT
"""Exceptions. Each has one sentence that names the function, the argument or file, and the reason."""


class Error(Exception):
    """The base of all exceptions of quadsplat."""


class UsageError(Error, ValueError):
    """An argument is wrong."""


class InputError(Error, OSError):
    """A file is missing, damaged or of the wrong kind, or cannot be written."""


class DeviceError(Error, RuntimeError):
    """No usable device, or not enough memory."""


class Cancelled(Error):
    """Context.stop() was called."""


#: By the result of a function of the library.
OF_RESULT = {1: UsageError, 2: InputError, 3: DeviceError, 4: Cancelled}
