#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Selections of assets/plush.ply as docs/formats.md#edits defines them, in plain double precision.

Writes selections.edits.json: steps with the counts and hashes that quadsplat must find.
"""
import json
import math
import struct
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ASSETS = HERE.parent.parent / "assets"


def read_ply(path):
    """Rows as dictionaries of columns."""
    content = path.read_bytes()
    head, body = content.split(b"end_header\n", 1)
    names = [line.split()[2].decode() for line in head.splitlines() if line.startswith(b"property float")]
    count = next(int(line.split()[2]) for line in head.splitlines() if line.startswith(b"element vertex"))
    columns = {name: [] for name in names}
    for row in struct.iter_unpack(f"<{len(names)}f", body[:4 * len(names) * count]):
        for name, value in zip(names, row):
            columns[name].append(value)
    return columns, count


PLUSH, COUNT = read_ply(ASSETS / "plush.ply")
CENTRES = list(zip(PLUSH["x"], PLUSH["y"], PLUSH["z"]))


def picture_of(camera):
    """The pixel of each centre; None behind the near plane at 0.2."""
    turn, place = camera["rotation"], camera["position"]
    cx = camera["cx"] - 0.5 if "cx" in camera else (camera["width"] - 1) / 2
    cy = camera["cy"] - 0.5 if "cy" in camera else (camera["height"] - 1) / 2
    pixels = []
    for centre in CENTRES:
        offset = [centre[i] - place[i] for i in range(3)]
        x, y, z = (sum(turn[row][axis] * offset[row] for row in range(3)) for axis in range(3))
        pixels.append((x / z * camera["fx"] + cx, y / z * camera["fy"] + cy) if z > 0.2 else None)
    return pixels


def in_polygon(point, corners):
    inside = False
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        if (ay > point[1]) != (by > point[1]) and point[0] < (bx - ax) * (point[1] - ay) / (by - ay) + ax:
            inside = not inside
    return inside


def near_stroke(point, points, radius):
    for (ax, ay), (bx, by) in zip(points[:1] + points, points):
        length2 = (bx - ax) ** 2 + (by - ay) ** 2
        at = min(max(((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / length2, 0), 1) if length2 else 0
        if math.hypot(point[0] - ax - at * (bx - ax), point[1] - ay - at * (by - ay)) <= radius:
            return True
    return False


def lab(color):
    """CIELAB of D65 from sRGB."""
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
               for c in (min(max(c, 0), 1) for c in color))
    xyz = ((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047,
           0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
           (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883)
    x, y, z = (t ** (1 / 3) if t > (6 / 29) ** 3 else t / (3 * (6 / 29) ** 2) + 4 / 29 for t in xyz)
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


def found(step):
    """True for each Gaussian that the tool meets."""
    tool = step["tool"]
    if "pixels" in step:
        corners = [tuple(pixel) for pixel in step["pixels"]]
        if tool == "rectangle":
            (ax, ay), (bx, by) = corners
            corners = [(ax, ay), (bx, ay), (bx, by), (ax, by)]
        inside = (lambda p: near_stroke(p, corners, step["radius"])) if tool == "brush" else (
            lambda p: in_polygon(p, corners))
        return [pixel is not None and inside(pixel) for pixel in picture_of(step["camera"])]
    if tool == "sphere":
        return [math.dist(centre, step["point"]) <= step["radius"] for centre in CENTRES]
    if tool == "box":
        return [all(low <= c <= high for low, c, high in zip(step["box"][0], centre, step["box"][1]))
                for centre in CENTRES]
    if tool == "color":
        want = lab(step["color"])
        return [math.dist(lab([0.5 + 0.28209479177387814 * PLUSH[f"f_dc_{c}"][i] for c in range(3)]), want)
                <= step["tolerance"] for i in range(COUNT)]
    if tool == "distance":
        length = math.hypot(*step["normal"])
        values = [sum((c - p) * n for c, p, n in zip(centre, step["point"], step["normal"])) / length
                  for centre in CENTRES]
    if tool == "opacity":
        values = [1 / (1 + math.exp(-logit)) for logit in PLUSH["opacity"]]
    if tool == "size":
        values = [math.exp(max(PLUSH[f"scale_{axis}"][i] for axis in range(3))) for i in range(COUNT)]
    return [step.get("low", -math.inf) <= value <= step.get("high", math.inf) for value in values]


def single(value):
    """The value in single precision, in which boxes are kept."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def main():
    cameras = json.loads((ASSETS / "cameras.json").read_text())
    picture = {"kind": "through", "camera": cameras[0]}
    star = [[800, 200], [960, 700], [520, 380], [1080, 380], [640, 700]]  # crosses itself
    hook = [[500, 300], [1100, 300], [1100, 900], [900, 900], [900, 500], [500, 500]]  # concave
    steps = [
        {"tool": "rectangle", "pixels": [[900.5, 250], [600, 820.25]], **picture},
        {"tool": "polygon", "pixels": star, **picture},
        {"tool": "lasso", "how": "add", "pixels": hook, **picture},
        {"tool": "brush", "how": "take away", "radius": 35.5, "pixels": [[620, 300], [800, 620], [1000, 640]], **picture},
        {"tool": "brush", "radius": 60, "pixels": [[800, 600]], **{**picture, "camera": cameras[48]}},
        {"tool": "sphere", "how": "add", "point": [-2, 2, 1], "radius": 2.5},
        {"tool": "box", "how": "common", "box": [[single(v) for v in (-3.1, 0, -1.5)], [single(v) for v in (0.5, 3.3, 2.9)]]},
        {"tool": "opacity", "how": "take away", "low": 0.25, "high": 0.9},
        {"tool": "size", "low": 0.05},
        {"tool": "distance", "point": [0, 1, 0], "normal": [0, -2, 1], "low": -0.5, "high": 0.125},
        {"tool": "color", "color": [0.8, 0.3, 0.4], "tolerance": 20},
        {"tool": "invert"},
        {"tool": "none"},
        {"tool": "all"},
    ]
    selected = [False] * COUNT
    for step in steps:
        tool = step["tool"]
        if tool in ("invert", "none", "all"):
            selected = [{"invert": not was, "none": False, "all": True}[tool] for was in selected]
        else:
            met = found(step)
            how = step.setdefault("how", "replace")
            selected = {"replace": lambda: met,
                        "add": lambda: [a or b for a, b in zip(selected, met)],
                        "take away": lambda: [a and not b for a, b in zip(selected, met)],
                        "common": lambda: [a and b for a, b in zip(selected, met)]}[how]()
        bits = bytearray((COUNT + 7) // 8)
        for i in range(COUNT):
            bits[i // 8] |= selected[i] << i % 8
        step.update(count=sum(selected), crc=f"crc32:{zlib.crc32(bits):08x}")
    lines = ",\n  ".join(json.dumps({"step": "select", **step}) for step in steps)
    (HERE / "selections.edits.json").write_text(f'{{"version": 1, "steps": [\n  {lines}\n]}}\n')


if __name__ == "__main__":
    main()
