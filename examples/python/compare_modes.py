# SPDX-License-Identifier: MIT
"""Compares the pictures of all culling modes with that of 3dgs: compare_modes.py SCENE"""
import argparse

import quadsplat


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--camera", type=int, default=0, help="number in the file of cameras")
    parser.add_argument("--size", default="800x600", help="WxH, pixels")
    options = parser.parse_args()

    scene = quadsplat.load(options.scene)
    camera = scene.cameras()[options.camera].resized(*map(int, options.size.split("x")))
    lossless = quadsplat.render(scene, camera, cull="3dgs")
    print(f"{'mode':<16}{'pairs':>10}{'used':>10}{'PSNR [dB]':>12}")
    for mode in quadsplat.modes():
        if mode.is_peer or mode.name == "reference":
            continue
        picture = quadsplat.render(scene, camera, outputs=["color", "used"], cull=mode.name)
        counts = picture.counts
        print(f"{mode.name:<16}{counts.tile_pairs:>10}{counts.used_pairs:>10}"
              f"{picture.psnr(lossless):>12.2f}")


if __name__ == "__main__":
    main()
