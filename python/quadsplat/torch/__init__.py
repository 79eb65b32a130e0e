# SPDX-License-Identifier: MIT
"""The differentiable rasterizer for torch, 1.12 or later.

    import torch
    from quadsplat.torch import rasterize
    picture = rasterize(means, scales, rotations, opacities, sh, camera=camera).color
    (picture - photograph).abs().mean().backward()

Tensors are on the CPU, or on a GPU of CUDA. docs/python.md, chapter Gradients, is the guide.
"""
from ._parts import SparseAdam, ssim, ssim_and_l1
from ._rasterize import Boundary, Rasterized, rasterize
from ._rules import Rules

__all__ = ["Boundary", "Rasterized", "Rules", "SparseAdam", "rasterize", "ssim", "ssim_and_l1"]
