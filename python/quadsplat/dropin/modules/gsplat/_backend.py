# SPDX-License-Identifier: MIT
"""gsplat's extension if it was built at install. gsplat from 1.6 compiles it for minutes while it is
imported, but its functions that trainers call are replaced."""
try:
    from gsplat import csrc as _C
except ImportError:
    _C = None

__all__ = ["_C"]
