# SPDX-License-Identifier: MIT
"""The count of pixels that -w-pose's rasterizer returns."""
from __future__ import annotations

from typing import Any

import torch

from ..torch import rasterize

_TILE = 16
_ALPHA_MIN, _TRANSMITTANCE_MIN = 1 / 255, 1e-4


@torch.no_grad()
def touched(given: Any, options: Any) -> torch.Tensor:
    """N, int32: the pixels that blend a Gaussian with a transmittance above 0.5 behind it.

    It composites every tile again with tensors, which takes longer than the picture.
    """
    camera, rules = options["camera"], options["rules"]
    drawn = rasterize(**given, camera=camera, view_from_world=options["view_from_world"],
                      rules=rules, boundary=True)
    edge = drawn.boundary
    assert edge is not None
    counts = torch.zeros(len(drawn.radii), dtype=torch.int32)
    seen = torch.nonzero(drawn.radii[:, 0] > 0).squeeze(1)
    seen = seen[torch.sort(edge.depths[seen], stable=True)[1]]
    low = edge.means_px[seen] - drawn.radii[seen]
    high = edge.means_px[seen] + drawn.radii[seen]
    for top in range(0, camera.height, _TILE):
        in_row = (high[:, 1] >= top) & (low[:, 1] <= top + _TILE)
        for left in range(0, camera.width, _TILE):
            near = seen[in_row & (high[:, 0] >= left) & (low[:, 0] <= left + _TILE)]
            if len(near) == 0:
                continue
            y, x = torch.meshgrid(torch.arange(top, min(top + _TILE, camera.height)),
                                  torch.arange(left, min(left + _TILE, camera.width)),
                                  indexing="ij")
            dx = edge.means_px[near, :1] - x.reshape(1, -1)
            dy = edge.means_px[near, 1:] - y.reshape(1, -1)
            a, b, c = edge.conics[near].unbind(1)
            power = -0.5 * (a[:, None] * dx * dx + c[:, None] * dy * dy) - b[:, None] * dx * dy
            alpha = (edge.opacities[near, None] * power.exp()).clamp(max=rules.alpha_max)
            alpha[(power > 0) | (alpha < _ALPHA_MIN)] = 0
            behind = torch.cumprod(1 - alpha, 0)
            # A pixel stops in front of the first Gaussian that would leave less.
            blends = (alpha > 0) & (behind >= _TRANSMITTANCE_MIN) & (behind > 0.5)
            counts[near] += blends.sum(1).to(torch.int32)
    return counts
