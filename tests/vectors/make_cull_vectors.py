#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes cull.json: footprints with the tiles that each culling mode lists, for ports to check themselves.
Usage: make_cull_vectors.py > cull.json   (standard library only; docs/check_your_port.md describes the format)

Nothing here comes from the modes' sources. Sets of tiles are evaluated in rational arithmetic from the definitions of
docs/culling.md and docs/peers.md, the pixels of `needed` one by one in double precision. Every set is evaluated twice:
for an ellipse that is a little smaller, whose tiles a port must list, and for one that is a little larger, which bounds
what rounding may add."""
import json
import math
import random
import struct
import sys
from fractions import Fraction
from math import isqrt

TILE = 16
SHIFT = Fraction(1, 1000)  # px: the rounding of positions in single precision
KINDS = {"round": 50, "needle": 50, "axis": 25, "huge": 30, "tiny": 30, "off-screen": 30, "border": 50, "faint": 30,
         "last-tile": 25, "threshold": 10, "first-tile": 20}
SIZES = [(185, 140), (160, 128), (97, 64), (17, 33), (1, 1)]
SIZE_OF_TRY = [0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 0, 4]
MAPS = ["needed", "3dgs", "adr", "dualbox", "quadbox", "exact", "accutile"]
MODES = {"3dgs": "3dgs", "adr": "adr", "dualbox": "dualbox", "quadbox-naive": "quadbox", "quadbox": "quadbox",
         "exact": "exact", "snugbox": "adr", "accutile": "accutile", "flashgs": "accutile", "stopthepop": "exact",
         "faster-gs": "exact"}


def single(value):
    return struct.unpack("f", struct.pack("f", value))[0]


def root(value):
    """sqrt(value) of a Fraction >= 0, to 2^-100."""
    return Fraction(isqrt((value.numerator << 200) // value.denominator), 1 << 100)


class Footprint:
    def __init__(self, size, mean, covariance, opacity):
        self.size, self.mean, self.covariance, self.opacity = size, mean, covariance, opacity
        self.gamma = single(2 * math.log(255 * opacity))
        self.columns, self.rows = -(-size[0] // TILE), -(-size[1] // TILE)
        self.sxx, self.sxy, self.syy = map(Fraction, covariance)
        self.determinant = self.sxx * self.syy - self.sxy ** 2
        self.f2 = self.determinant / (self.sxx * self.syy)
        # The factor by which single precision may change lengths: the conic of a thin Gaussian is known to 2^-24 / f^2.
        self.slack = Fraction(1, 1000) + 16 / self.f2 / (1 << 24)
        self.mx, self.my = map(Fraction, mean)

    def half(self, variance, sign):
        """A half extent sqrt(gamma variance), changed by the slack."""
        if self.gamma <= 0:
            return Fraction(-1)
        return root(Fraction(self.gamma) * variance) * (1 + sign * self.slack) + sign * SHIFT

    def tiles(self, lists):
        return {(c, r) for r in range(self.rows) for c in range(self.columns) if lists(c, r)}

    # ---- the maps; sign -1: tiles that a port must list, +1: tiles that it may list
    # ---------------------------------------------
    def map_adr(self, sign):
        hx, hy = self.half(self.sxx, sign), self.half(self.syy, sign)
        if hx <= 0 or hy <= 0:
            return set()
        return self.tiles(lambda c, r: meets(self.mx - hx, self.mx + hx, c) and meets(self.my - hy, self.my + hy, r))

    def map_boxes(self, sign, minor_too):
        # 1/a = det/Syy and 1/c = det/Sxx: the ellipse crosses the axes at sqrt(gamma/a) and sqrt(gamma/c).
        major = self.half(self.sxx, sign), self.half(self.syy, sign)
        minor = self.half(self.determinant / self.syy, sign), self.half(self.determinant / self.sxx, sign)
        found = set()
        for dx, dy in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
            is_major = (dx == dy) == (self.sxy > 0)  # b < 0 if and only if Sxy > 0
            if not (is_major or minor_too):
                continue
            reach = major if is_major else minor
            if min(reach) <= 0:
                continue
            x, y = sorted((self.mx, self.mx + dx * reach[0])), sorted((self.my, self.my + dy * reach[1]))
            found |= self.tiles(lambda c, r, x=x, y=y: meets(*x, c) and meets(*y, r))
        return found

    def map_dualbox(self, sign):
        return self.map_boxes(sign, False)

    def map_quadbox(self, sign):
        return self.map_boxes(sign, True)

    def map_ellipse(self, sign, last):
        if self.gamma <= 0:
            return set()
        gamma = Fraction(self.gamma) * (1 + sign * self.slack) ** 2
        return self.tiles(lambda c, r: self.smallest(c, r, last, sign * SHIFT) <= gamma)

    def map_exact(self, sign):
        return self.map_ellipse(sign, TILE - 1)

    def map_accutile(self, sign):
        return self.map_ellipse(sign, TILE)

    def map_3dgs(self, sign):
        middle = (self.sxx + self.syy) / 2
        largest = middle + root(max(Fraction(1, 10), middle ** 2 - self.determinant))
        radius = math.ceil(3 * root(largest) * (1 + sign * Fraction(1, 100000)))
        nudge = sign * SHIFT if any(v != round(v * 64) / 64 for v in self.mean) else 0

        def run(mean, limit):
            low, high = (mean - nudge - radius) / TILE, (mean + nudge + radius + TILE - 1) / TILE
            return min(max(math.trunc(low), 0), limit), min(max(math.trunc(high), 0), limit)
        (left, right), (top, bottom) = run(self.mx, self.columns), run(self.my, self.rows)
        return self.tiles(lambda c, r: left <= c < right and top <= r < bottom)

    def map_needed(self, sign):
        if self.gamma <= 0:
            return set()
        gamma = self.gamma * (1 + sign * float(self.slack)) ** 2
        a, b, c = (float(v / self.determinant) for v in (self.syy, -self.sxy, self.sxx))
        found = set()
        for y in range(self.size[1]):
            dy = y - self.mean[1]
            for x in range(self.size[0]):
                dx = x - self.mean[0]
                if a * dx * dx + 2 * b * dx * dy + c * dy * dy <= gamma:
                    found.add((x // TILE, y // TILE))
        return found

    def smallest(self, column, row, last, wider):
        """The smallest q = (x, y) conic (x, y)^T over the square [TILE t, TILE t + last]^2 around the mean."""
        x0, y0 = TILE * column - wider - self.mx, TILE * row - wider - self.my
        x1, y1 = x0 + last + 2 * wider, y0 + last + 2 * wider
        if x0 <= 0 <= x1 and y0 <= 0 <= y1:
            return Fraction(0)

        def q(x, y):
            return (self.syy * x * x - 2 * self.sxy * x * y + self.sxx * y * y) / self.determinant
        on_edges = []
        for x in (x0, x1):  # q is smallest at y = x Sxy / Sxx on the line of this x
            on_edges.append(q(x, min(max(x * self.sxy / self.sxx, y0), y1)))
        for y in (y0, y1):
            on_edges.append(q(min(max(y * self.sxy / self.syy, x0), x1), y))
        return min(on_edges)

    def maps(self):
        result = {}
        for name in MAPS:
            must = getattr(self, "map_" + name)(-1)
            may = getattr(self, "map_" + name)(1)
            if not must <= may:
                raise ValueError(name)
            result[name] = "/".join(
                "".join("#" if (c, r) in must else "?" if (c, r) in may else "." for c in range(self.columns))
                for r in range(self.rows))
        return result


def meets(low, high, tile):
    """True if [low, high] meets the open interval of a tile."""
    return low < TILE * tile + TILE and high > TILE * tile


def ellipse(size, mean, major, minor, angle, opacity):
    c, s = math.cos(angle), math.sin(angle)
    u, v = major ** 2, minor ** 2
    covariance = (c * c * u + s * s * v + 0.3, c * s * (u - v), s * s * u + c * c * v + 0.3)
    return Footprint(size, tuple(map(single, mean)), tuple(map(single, covariance)), single(opacity))


def draw(kind, size, number, rng):
    w, h = size

    def log_uniform(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))
    mean = rng.uniform(-8, w + 8), rng.uniform(-8, h + 8)
    angle = rng.uniform(0, 2 * math.pi)
    opacity = 1.0 if number % 4 == 0 else log_uniform(1.2 / 255, 1)
    if kind == "round":
        major = log_uniform(0.5, 40)
        return ellipse(size, mean, major, major * rng.uniform(0.5, 1), angle, opacity)
    if kind == "needle":  # up to 150 times as long as wide
        return ellipse(size, mean, log_uniform(10, 80), 0, angle, opacity)
    if kind == "axis":  # b = 0: x and y are independent
        a, b = (math.sqrt(log_uniform(0.3, 3000)) for _ in range(2))
        return Footprint(size, tuple(map(single, mean)), (single(a * a + 0.3), 0.0, single(b * b + 0.3)), single(opacity))
    if kind == "huge":
        major = log_uniform(100, 5000)
        return ellipse(size, (mean[0] * 3 - w, mean[1] * 3 - h), major, major * rng.uniform(0.05, 1), angle, opacity)
    if kind == "tiny":
        return ellipse(size, mean, log_uniform(1e-4, 0.3), 0, angle, opacity)
    if kind == "off-screen":
        major, way, far = log_uniform(1, 120), rng.uniform(0, 2 * math.pi), max(w, h) * rng.uniform(0.6, 3)
        return ellipse(size, (w / 2 + far * math.cos(way), h / 2 + far * math.sin(way)), major,
                       major * rng.uniform(0.1, 1), angle, opacity)
    if kind == "border":  # means on the corners of tiles
        major = log_uniform(0.5, 30)
        mean = 16 * rng.randrange(-1, w // 16 + 2), 16 * rng.randrange(-1, h // 16 + 2)
        return ellipse(size, mean, major, major * rng.uniform(0.05, 1), angle, opacity)
    if kind == "faint":
        major = log_uniform(5, 150)
        return ellipse(size, mean, major, major * rng.uniform(0.1, 1), angle, rng.uniform(1.02, 1.5) / 255)
    if kind == "last-tile":  # at the right and lower ends of the grid
        major = log_uniform(0.5, 12)
        mean = w + rng.uniform(-20, 12), h + rng.uniform(-20, 12)
        return ellipse(size, mean, major, major * rng.uniform(0.2, 1), angle, opacity)
    if kind == "first-tile":  # at the left and upper ends, or just outside
        major = log_uniform(0.5, 5)
        mean = rng.uniform(-15, 5), rng.uniform(-15, 5)
        return ellipse(size, mean, major, major * rng.uniform(0.2, 1), angle, opacity)
    opacity = [0.5, 0.9, 0.99, 0.9999, 1.0, 1.0001, 1.01, 1.1, 2, 254][number] / 255
    return ellipse(size, (w / 2, h / 2), 12, 5, 0.6, opacity)


def is_kept(kind, maps, tries):
    """False if rounding may decide about many tiles; and for four of five footprints that no tile needs."""
    if kind == "threshold":
        return True
    if any(text.count("?") > 3 for text in maps.values()):
        return False
    return kind in ("off-screen", "first-tile") or "#" in maps["adr"] or tries % 5 == 0


def main():
    rng = random.Random(20260504)
    lines = []
    for kind, count in KINDS.items():
        number = tries = 0
        while number < count:
            size = SIZES[0] if kind == "threshold" else SIZES[SIZE_OF_TRY[tries % len(SIZE_OF_TRY)]]
            tries += 1
            footprint = draw(kind, size, number, rng)
            if footprint.f2 < Fraction(1, 100000):  # the covariance no longer determines the conic
                continue
            maps = footprint.maps()
            if not is_kept(kind, maps, tries):
                continue
            number += 1
            values = {"name": f"{kind}-{number:02}", "image": size, "mean": footprint.mean,
                      "covariance": footprint.covariance, "opacity": footprint.opacity, "gamma": footprint.gamma}
            for key in ("mean", "covariance"):
                values[key] = [float(f"{v:.9g}") for v in values[key]]
            for key in ("opacity", "gamma"):
                values[key] = float(f"{values[key]:.9g}")
            lines.append(json.dumps({**values, "maps": maps}))
        print(kind, count, "of", tries, file=sys.stderr)
    head = {"format": "quadsplat culling vectors", "version": 1, "tile": TILE, "modes": MODES}
    print(json.dumps(head)[:-1] + ', "vectors": [')
    print(",\n".join(lines))
    print("]}")


if __name__ == "__main__":
    main()
