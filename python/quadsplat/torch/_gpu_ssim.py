# SPDX-License-Identifier: MIT
"""SSIM of tensors on a GPU, in operations of torch.

The results equal the results of the library on the CPU within rounding.
"""
from __future__ import annotations

import math
from typing import Tuple

import torch

Tensor = torch.Tensor

_RADIUS, _SIGMA = 5, 1.5  # SSIM's window, px
_C1, _C2 = 0.01 ** 2, 0.03 ** 2


def ssim_and_gradient(a: Tensor, b: Tensor, padding: str) -> Tuple[Tensor, Tensor]:
    """The mean SSIM of pictures of batch x channels x height x width, and its derivatives by a.

    It uses the formulas of Wang et al. (2004). padding: "same" or "valid".
    """
    mean_a, mean_b, aa, bb, ab = _blurred(torch.stack((a, b, a * a, b * b, a * b)))
    top1, top2 = 2 * mean_a * mean_b + _C1, 2 * (ab - mean_a * mean_b) + _C2
    bottom1 = mean_a * mean_a + mean_b * mean_b + _C1
    bottom2 = aa - mean_a * mean_a + bb - mean_b * mean_b + _C2
    values = top1 * top2 / (bottom1 * bottom2)
    by_ab = 2 * top1 / (bottom1 * bottom2)
    by_aa = -values / bottom2
    by_mean = (2 * mean_b * (top2 - top1) / (bottom1 * bottom2)
               + 2 * mean_a * values * (1 / bottom2 - 1 / bottom1))
    counted = values
    derivatives = torch.stack((by_mean, by_aa, by_ab))
    if padding == "valid":
        inner = (..., slice(_RADIUS, -_RADIUS), slice(_RADIUS, -_RADIUS))
        counted = values[inner]
        kept = torch.zeros_like(derivatives)
        kept[inner] = derivatives[inner]
        derivatives = kept
    by_mean, by_aa, by_ab = _blurred(derivatives)
    gradient = (by_mean + 2 * a * by_aa + b * by_ab) / counted.numel()
    # The values of many pixels are summed in double precision, as on the CPU.
    return counted.double().mean().to(a.dtype), gradient


def _blurred(maps: Tensor) -> Tensor:
    """The maps convolved with the window along their last two dimensions; values outside are 0."""
    weights = [math.exp(-0.5 * (k / _SIGMA) ** 2) for k in range(-_RADIUS, _RADIUS + 1)]
    total = sum(weights)
    for dimension in (-1, -2):
        size = maps.shape[dimension]
        margin = (_RADIUS, _RADIUS) if dimension == -1 else (0, 0, _RADIUS, _RADIUS)
        wide = torch.nn.functional.pad(maps, margin)
        maps = torch.zeros_like(maps)
        for k, weight in enumerate(weights):
            maps.add_(wide.narrow(dimension, k, size), alpha=weight / total)
    return maps
