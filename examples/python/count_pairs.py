# SPDX-License-Identifier: MIT
"""Counts the (Gaussian, tile) pairs of every culling mode over many cameras: count_pairs.py SCENE"""
import argparse

import numpy as np

import quadsplat


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--cameras", type=int, default=10, help="number of cameras")
    parser.add_argument("--size", default="800x600", help="WxH, pixels")
    options = parser.parse_args()

    scene = quadsplat.load(options.scene)
    width, height = map(int, options.size.split("x"))
    cameras = scene.cameras()[: options.cameras]
    rows = [quadsplat.counts(scene, camera.resized(width, height)) for camera in cameras]
    names = list(rows[0])
    pairs = np.array([[row[name].tile_pairs for name in names] for row in rows])
    of_3dgs = pairs[:, [names.index("3dgs")]]
    print(f"{'mode':<16}{'mean pairs':>12}{'of 3dgs':>10}{'least':>8}{'most':>8}")
    for name, column, share in zip(names, pairs.T, (pairs / of_3dgs).T):
        print(f"{name:<16}{column.mean():>12.0f}{share.mean():>10.1%}{share.min():>8.1%}"
              f"{share.max():>8.1%}")


if __name__ == "__main__":
    main()
