# SPDX-License-Identifier: MIT
"""Renders one camera of a scene into a picture file: render.py SCENE OUT.png"""
import argparse

import quadsplat


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("output")
    parser.add_argument("--camera", type=int, default=0, help="number in the file of cameras")
    parser.add_argument("--size", help="WxH, pixels")
    options = parser.parse_args()

    scene = quadsplat.load(options.scene)
    camera = scene.cameras()[options.camera]
    if options.size:
        camera = camera.resized(*map(int, options.size.split("x")))
    picture = quadsplat.render(scene, camera)
    picture.save(options.output)
    print(f"wrote {options.output}: {picture.counts.tile_pairs} pairs, {picture.counts.frame_ms:.1f} ms")


if __name__ == "__main__":
    main()
