# SPDX-License-Identifier: MIT
"""A trainer against the interface of gsplat.rendering.rasterization."""
import torch
from fused_ssim import fused_ssim
from gsplat.rendering import rasterization
from simple_knn._C import distCUDA2
from training import main


def draw_of(data):
    height, width = data.images.shape[1:3]
    lens = torch.tensor([[data.focal[0], 0, width / 2], [0, data.focal[1], height / 2], [0, 0, 1]])

    def draw(gaussians, view, degree):
        colors, _, info = rasterization(
            gaussians["means"], gaussians["rotations"], gaussians["scales"],
            gaussians["opacities"][:, 0], gaussians["sh"], data.views[view][None], lens[None],
            width, height, near_plane=0.2, sh_degree=degree, packed=False)
        points = info["means2d"]
        if points.requires_grad:
            points.retain_grad()
        half = torch.tensor([info["width"] / 2, info["height"] / 2]) * info["n_cameras"]
        return colors[0], (info["radii"][0] > 0).all(-1), lambda: points.grad[0] * half

    return draw


if __name__ == "__main__":
    main(draw_of, distCUDA2, fused_ssim)
