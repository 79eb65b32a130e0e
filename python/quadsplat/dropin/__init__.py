# SPDX-License-Identifier: MIT
"""Trainers that were written for other rasterizers run with quadsplat, without a change.

    python -m quadsplat.dropin [--cull MODE] [--variant NAME] [--device cpu] train.py -s data

The modules diff_gaussian_rasterization (and its _abs), simple_knn and fused_ssim are quadsplat's
then, and so are the functions of gsplat that need its extension. docs/python.md, chapter Drop-in,
lists the trainers and differences.
"""
from ._finder import install
from ._options import DEVICES, VARIANTS

__all__ = ["DEVICES", "VARIANTS", "install"]
