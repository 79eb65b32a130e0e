# SPDX-License-Identifier: MIT
"""gsplat's extension if it was built at install, else None.

gsplat from 1.6 compiles it for minutes while it is imported. The drop-in replaces the functions of
the extension that trainers call, so nothing has to be compiled."""
try:
    from gsplat import csrc as _C
except ImportError:
    _C = None

__all__ = ["_C"]
