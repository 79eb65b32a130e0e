# SPDX-License-Identifier: MIT
"""Finds the pose of a picture of known Gaussians by gradient descent, with torch on the CPU."""
import torch

import quadsplat
from quadsplat.torch import rasterize


def moved(start: torch.Tensor, turn: torch.Tensor, shift: torch.Tensor) -> torch.Tensor:
    """The pose, turned by a vector in radians and shifted, in the axes of the view."""
    x, y, z = turn
    zero = torch.zeros(())
    rows = [[zero, -z, y, shift[0]], [z, zero, -x, shift[1]], [-y, x, zero, shift[2]], [zero] * 4]
    return torch.matrix_exp(torch.stack([torch.stack(row) for row in rows])) @ start


def main() -> None:
    torch.manual_seed(1)
    count = 200
    gaussians = {"means": torch.randn(count, 3), "scales": torch.full((count, 3), 0.15),
                 "rotations": torch.tensor([[1.0, 0, 0, 0]]).expand(count, 4),
                 "opacities": torch.full((count,), 0.7), "channels": torch.rand(count, 3)}
    camera = quadsplat.Camera.look_at((0, -1, -5), (0, 0, 0), 120, 90)
    true = torch.tensor(camera.view_from_world, dtype=torch.float32)
    with torch.no_grad():
        photograph = rasterize(**gaussians, camera=camera).color

    start = moved(true, torch.tensor([0.03, -0.04, 0.02]), torch.tensor([0.1, -0.05, 0.1]))
    turn, shift = torch.zeros(3, requires_grad=True), torch.zeros(3, requires_grad=True)
    optimizer = torch.optim.Adam([turn, shift], lr=0.02)
    decay = torch.optim.lr_scheduler.ExponentialLR(optimizer, 0.98)
    for _ in range(300):
        pose = moved(start, turn, shift)
        loss = (rasterize(**gaussians, camera=camera, view_from_world=pose).color
                - photograph).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        decay.step()
    print(f"before: {(start - true).abs().max():.5f}")
    print(f"after: {(moved(start, turn, shift) - true).abs().max():.5f}")


if __name__ == "__main__":
    main()
