# SPDX-License-Identifier: MIT
"""INRIA's diff_gaussian_rasterization and its variants, by quadsplat."""
from quadsplat.dropin._inria import (GaussianRasterizationSettings, GaussianRasterizer,
                                     compute_relocation, rasterize_gaussians)
from quadsplat.torch import SparseAdam as SparseGaussianAdam

__all__ = ["GaussianRasterizationSettings", "GaussianRasterizer", "SparseGaussianAdam",
           "compute_relocation", "rasterize_gaussians"]
