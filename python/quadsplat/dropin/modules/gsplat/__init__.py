# SPDX-License-Identifier: MIT
"""The part of gsplat that quadsplat has, where gsplat is not installed."""
from quadsplat.dropin._gsplat import quat_scale_to_covar_preci

from .rendering import rasterization

__version__ = "1.5.3"
__all__ = ["quat_scale_to_covar_preci", "rasterization"]
