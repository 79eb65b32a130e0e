# SPDX-License-Identifier: MIT
"""gsplat.rendering, by quadsplat."""
from quadsplat.dropin._gsplat import rasterization

__all__ = ["rasterization"]
