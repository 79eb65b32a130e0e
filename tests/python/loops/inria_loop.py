# SPDX-License-Identifier: MIT
"""A trainer against the interface of diff_gaussian_rasterization, simple_knn and fused_ssim."""
import torch
from diff_gaussian_rasterization import GaussianRasterizationSettings, GaussianRasterizer
from fused_ssim import fused_ssim
from simple_knn._C import distCUDA2
from training import main


def projection(tanfovx, tanfovy, near=0.01, far=100.0):
    matrix = torch.zeros(4, 4)
    matrix[0, 0], matrix[1, 1], matrix[3, 2] = 1 / tanfovx, 1 / tanfovy, 1
    matrix[2, 2], matrix[2, 3] = far / (far - near), -far * near / (far - near)
    return matrix


def draw_of(data):
    height, width = data.images.shape[1:3]
    tangents = width / (2 * data.focal[0]), height / (2 * data.focal[1])

    def draw(gaussians, view, degree):
        matrix = data.views[view].transpose(0, 1)
        rasterizer = GaussianRasterizer(raster_settings=GaussianRasterizationSettings(
            image_height=height, image_width=width, tanfovx=tangents[0], tanfovy=tangents[1],
            bg=torch.zeros(3), scale_modifier=1.0, viewmatrix=matrix,
            projmatrix=matrix @ projection(*tangents).transpose(0, 1), sh_degree=degree,
            campos=matrix.inverse()[3, :3], prefiltered=False, debug=False))
        means2D = torch.zeros_like(gaussians["means"], requires_grad=True)
        color, radii = rasterizer(
            means3D=gaussians["means"], means2D=means2D, shs=gaussians["sh"],
            opacities=gaussians["opacities"], scales=gaussians["scales"],
            rotations=gaussians["rotations"])
        return color.permute(1, 2, 0), radii > 0, lambda: means2D.grad[:, :2]

    return draw


if __name__ == "__main__":
    main(draw_of, distCUDA2, fused_ssim)
