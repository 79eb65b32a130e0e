#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Counts the tile pairs of the bundled scene independently of the program: float32 numpy, whole boxes, no walks.

Usage: bundled_pairs.py > bundled_pairs.json   (needs numpy; run from anywhere)
Written from the formulas of the method (docs/culling.md); shares no code with src/.
"""
import json
import pathlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CAMERAS = [0, 32, 64]
f32 = np.float32


def read_ply(path):
    with open(path, "rb") as file:
        names, count = [], 0
        while (line := file.readline().split()) != [b"end_header"]:
            if line[:2] == [b"element", b"vertex"]:
                count = int(line[2])
            if line[0] == b"property":
                names.append(line[2].decode())
        rows = np.frombuffer(file.read(), "<f4").reshape(count, len(names))
    column = {name: rows[:, i].astype(np.float64) for i, name in enumerate(names)}
    stack = lambda *keys: np.stack([column[key] for key in keys], 1)
    return (stack("x", "y", "z"), np.exp(stack("scale_0", "scale_1", "scale_2")),
            stack("rot_0", "rot_1", "rot_2", "rot_3"), 1 / (1 + np.exp(-column["opacity"])))


def footprints(camera, positions, scales, rotations, opacities):
    w, x, y, z = (rotations / np.linalg.norm(rotations, axis=1, keepdims=True)).T
    r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                  [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                  [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)
    m = r * scales[:, None, :]
    sigma = (m @ m.transpose(0, 2, 1)).astype(f32)
    view = np.array(camera["rotation"]).T  # view_from_world
    width, height, fx, fy = camera["width"], camera["height"], f32(camera["fx"]), f32(camera["fy"])
    p = ((positions - camera["position"]) @ view.T).astype(f32)
    keep = p[:, 2] > f32(0.2)
    p, sigma, opacity = p[keep], sigma[keep], opacities[keep]
    slope = p[:, :2] / p[:, 2:]
    limit = f32(1.3) * np.array([width / (2 * fx), height / (2 * fy)], f32)
    t = np.clip(slope, -limit, limit) * p[:, 2:]
    zero = np.zeros(len(p), f32)
    jacobian = np.stack([np.stack([fx / p[:, 2], zero, -fx * t[:, 0] / p[:, 2] ** 2], 1),
                         np.stack([zero, fy / p[:, 2], -fy * t[:, 1] / p[:, 2] ** 2], 1)], 1)
    jw = jacobian @ view.astype(f32)
    covariance = jw @ sigma @ jw.transpose(0, 2, 1)
    sxx, syy, sxy = covariance[:, 0, 0] + f32(0.3), covariance[:, 1, 1] + f32(0.3), covariance[:, 0, 1]
    mean = slope * np.array([fx, fy], f32) + np.array([(width - 1) / 2, (height - 1) / 2], f32)
    det = sxx * syy - sxy * sxy
    good = det > 0
    return mean[good], sxx[good], syy[good], sxy[good], det[good], opacity[good].astype(f32)


def tiles(low, high, limit):
    """Half-open range of 16-pixel tiles that the open interval (low, high) meets."""
    return (np.clip(np.floor(low / 16), 0, limit).astype(np.int64), np.clip(np.ceil(high / 16), 0, limit).astype(np.int64))


def area(x, y):
    return np.maximum(x[1] - x[0], 0) * np.maximum(y[1] - y[0], 0)


def meet(a, b):
    return np.maximum(a[0], b[0]), np.minimum(a[1], b[1])


def count(camera, scene):
    mean, sxx, syy, sxy, det, opacity = footprints(camera, *scene)
    columns, rows = -(-camera["width"] // 16), -(-camera["height"] // 16)
    middle = (sxx + syy) / 2
    radius = np.ceil(3 * np.sqrt(middle + np.sqrt(np.maximum(f32(0.1), middle * middle - det))))
    square = [(np.clip((mean[:, k] - radius) / 16, 0, n).astype(np.int64),
               np.clip((mean[:, k] + radius + 15) / 16, 0, n).astype(np.int64)) for k, n in ((0, columns), (1, rows))]
    official = area(*square).sum()

    bright = opacity > f32(1) / 255
    mean, sxx, syy, sxy, det, opacity = (a[bright] for a in (mean, sxx, syy, sxy, det, opacity))
    gamma = 2 * np.log(255 * opacity)
    x_max, y_max = np.sqrt(gamma * sxx), np.sqrt(gamma * syy)
    mx, my = mean.T
    adr = area(tiles(mx - x_max, mx + x_max, columns), tiles(my - y_max, my + y_max, rows)).sum()

    # Four boxes; the area of their union by inclusion and exclusion.
    f = np.sqrt(det / (sxx * syy))
    same = sxy > 0  # conic b < 0: the major axis runs through the quadrants with x y > 0
    boxes = []
    for sx, sy in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        reach = np.where(same == (sx * sy > 0), f32(1), f)
        ends = [(m, m + s * reach * r) for m, s, r in ((mx, sx, x_max), (my, sy, y_max))]
        boxes.append([tiles(np.minimum(*e), np.maximum(*e), n) for e, n in zip(ends, (columns, rows))])
    quadbox = 0
    for subset in range(1, 16):
        members = [boxes[i] for i in range(4) if subset >> i & 1]
        x, y = members[0]
        for other in members[1:]:
            x, y = meet(x, other[0]), meet(y, other[1])
        quadbox += (1 if len(members) % 2 else -1) * area(x, y).sum()
    return int(official), int(adr), int(quadbox)


def main():
    cameras = json.loads((ROOT / "assets/cameras.json").read_text())
    scene = read_ply(ROOT / "assets/plush.ply")
    counts = [count(cameras[i], scene) for i in CAMERAS]
    print(json.dumps({
        "what": "tile pairs of assets/plush.ply by tests/golden/bundled_pairs.py",
        "size": [cameras[0]["width"], cameras[0]["height"]],
        "cameras": CAMERAS,
        "pairs": dict(zip(("official", "adr", "quadbox"), map(list, zip(*counts)))),
    }, indent=1))


if __name__ == "__main__":
    main()
