# SPDX-License-Identifier: MIT
"""Sentences about interfaces that are not replaced."""

TAMING = ("taming-3dgs's rasterizer returns 13 values, which quadsplat does not have: train with "
          "the variant 3dgs_accel, or with `quadsplat train --strategy fastgs`")
