# SPDX-License-Identifier: MIT
"""Trains Gaussians from photographs with torch: train.py CAMERAS IMAGES OUT.ply [--device cuda]"""
import argparse
from pathlib import Path

import numpy as np
import torch

import quadsplat
from quadsplat.torch import Rules, rasterize, ssim


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cameras", help="cameras.json, transforms.json, or a COLMAP model")
    parser.add_argument("images", type=Path, help="folder of photographs, named as the cameras")
    parser.add_argument("model", help="the scene to be written, .ply or another format")
    parser.add_argument("--gaussians", type=int, default=5000)
    parser.add_argument("--radius", type=float, default=1.0, help="they start in this ball, units of the scene")
    parser.add_argument("--iterations", type=int, default=1000)
    parser.add_argument("--device", default="cpu", help="cpu, or a GPU of CUDA: cuda")
    options = parser.parse_args()

    torch.manual_seed(0)
    files = {path.stem: path for path in options.images.iterdir()}
    cameras = [camera for camera in quadsplat.read_cameras(options.cameras)
               if Path(camera.name).stem in files]
    photographs = [torch.from_numpy(quadsplat.read_picture(files[Path(camera.name).stem])[..., :3].copy())
                   .to(options.device) for camera in cameras]
    cameras = [camera.resized(picture.shape[1], picture.shape[0])
               for camera, picture in zip(cameras, photographs)]

    count = options.gaussians
    means = torch.randn(count, 3) * options.radius / 2
    size = torch.from_numpy(np.sqrt(quadsplat.neighbours(means)))
    values = {"means": means, "scales": size.log()[:, None].repeat(1, 3), "rotations": torch.randn(count, 4),
              "opacities": torch.full((count,), -1.0), "sh": torch.zeros(count, 4, 3)}
    values = {name: value.to(options.device).requires_grad_() for name, value in values.items()}
    rates = {"means": 2e-3 * options.radius, "scales": 1e-2, "rotations": 2e-3, "opacities": 5e-2, "sh": 5e-3}
    optimizer = torch.optim.Adam([{"params": [value], "lr": rates[name]}
                                  for name, value in values.items()], eps=1e-15)

    def draw(camera: quadsplat.Camera) -> torch.Tensor:
        return rasterize(values["means"], values["scales"].exp(), values["rotations"],
                         values["opacities"].sigmoid(), values["sh"], camera=camera,
                         rules=Rules(antialiased=True), planar=True).color

    for iteration in range(1, options.iterations + 1):
        view = int(torch.randint(len(cameras), ()))
        picture, wanted = draw(cameras[view]), photographs[view].permute(2, 0, 1)
        loss = (picture - wanted).abs().mean() + 0.2 * (1 - ssim(picture[None], wanted[None]))
        loss.backward()
        optimizer.step()
        optimizer.zero_grad()
        if iteration == 1 or iteration % 100 == 0:
            print(f"iteration {iteration}: loss {loss.item():.4f}")

    values = {name: value.detach().cpu() for name, value in values.items()}
    scene = quadsplat.Scene.from_arrays(**values, activated=False, antialiased=True)
    quadsplat.convert(scene, options.model, overwrite=True)
    shown = quadsplat.render(scene, cameras[0], background=(0, 0, 0))
    print(f"PSNR of the first view: {shown.psnr(photographs[0].cpu()):.2f} dB")


if __name__ == "__main__":
    main()
