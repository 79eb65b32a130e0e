# SPDX-License-Identifier: MIT
"""The rasterizer of AbsGS, by quadsplat."""
from quadsplat.dropin._inria import AbsGaussianRasterizer as GaussianRasterizer
from quadsplat.dropin._inria import GaussianRasterizationSettings

__all__ = ["GaussianRasterizationSettings", "GaussianRasterizer"]
