#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Numbers of tests of lenses, independently of the program: golden points, and shares of pictures.

Usage: lenses.py   (only Python; run from anywhere; prints one line per number)
Written from the formulas of COLMAP's src/colmap/sensor/models, of nerfstudio's pull request 3779 (it cites Metashape's manual 2.3), and of
FisheyeRadTanThinPrism in Project Aria's documentation; shares no code with src/. Pixels count from the picture's corner here.
tests/io/camera and tests/app/session/undistort_test.cpp have the values.
"""
from math import atan, atan2, ceil, cos, hypot, pi, radians, sin, sqrt, tan

HALF = tan(radians(48))  # half a face of 96 degrees at distance 1
# x right, y down, z forward, for the point (a, b) of a face, each up to HALF.
FACES = {"front": lambda a, b: (a, b, 1), "right": lambda a, b: (1, b, -a), "back": lambda a, b: (-a, b, -1),
         "left": lambda a, b: (-1, b, a), "up": lambda a, b: (a, -1, b), "down": lambda a, b: (a, 1, -b)}
MARGIN = 1.5  # the smallest distance from the edge, in pixels, of a point whose 4 x 4 neighbours are all in the photograph


def even(s, *k):
    return 1 + sum(c * s ** (i + 1) for i, c in enumerate(k))


# Metashape, with its order of p1 and p2: u = width / 2 + cx + x f + x b1 + y b2, v = height / 2 + cy + y f.
# Its fisheye has the angle to the axis in place of its tangent.
def metashape(ray, f, b1, b2, center, k, p1, p2, is_fisheye=False):
    x, y = ray[0] / ray[2], ray[1] / ray[2]
    if is_fisheye:
        r0 = hypot(x, y)
        x, y = x * atan(r0) / r0, y * atan(r0) / r0
    r2 = x * x + y * y
    u = x * even(r2, *k) + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y
    v = y * even(r2, *k) + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y
    return center[0] + u * f + u * b1 + v * b2, center[1] + v * f


# Project Aria: tangential and prism terms belong to the point that the radial terms moved.
def aria(ray, focal, center, k, p, s):
    r, theta = hypot(ray[0], ray[1]), atan2(hypot(ray[0], ray[1]), ray[2])
    length = theta * even(theta**2, *k)
    u, v = length * ray[0] / r, length * ray[1] / r
    q = u * u + v * v
    return (focal[0] * (u + (2 * u * u + q) * p[0] + 2 * u * v * p[1] + s[0] * q + s[1] * q * q) + center[0],
            focal[1] * (v + (2 * v * v + q) * p[1] + 2 * u * v * p[0] + s[2] * q + s[3] * q * q) + center[1])


def lens(radius, focal, center, size, prism=0, limit=pi):
    """A lens that shows the angle theta to the axis at radius(theta); `prism` times radius^2 is added to x."""
    def project(x, y, z):
        r, theta = hypot(x, y), atan2(hypot(x, y), z)
        if theta > limit:
            return None
        length = radius(theta)
        u, v = (length * x / r, length * y / r) if r else (0, 0)
        return focal[0] * (u + prism * length**2) + center[0], focal[1] * v + center[1]
    return project, size


def fisheye(*k):
    return lambda t: t * even(t * t, *k)


def fov(w):
    return lambda t: atan(2 * tan(t) * tan(w / 2)) / w


def division(k):
    return lambda t: 2 * tan(t) / (1 + sqrt(1 - 4 * k * tan(t) ** 2))


def eucm(alpha, beta):
    return lambda t: sin(t) / (alpha * sqrt(beta * sin(t) ** 2 + cos(t) ** 2) + (1 - alpha) * cos(t))


def rational(k1, k6):
    return lambda t: tan(t) * (1 + k1 * tan(t) ** 2) / (1 + k6 * tan(t) ** 6)


def panorama(size):
    def project(x, y, z):
        return (atan2(x, z) / (2 * pi) + 0.5) * size[0], (0.5 + atan2(y, hypot(x, z)) / pi) * size[1]
    return project, size


def fold(radius):
    """The first angle at which the radius stops growing."""
    step = 1e-4
    t = step
    while t < pi and radius(t) > radius(t - step):
        t += step
    return t


def pinhole_share(camera, focal, center):
    """The share of a photograph within the border of the largest pinhole picture that it fills: the area of the border's polygon."""
    project, (width, height) = camera
    n = 1000
    border = [(i * width / n, 0) for i in range(n)] + [(width, i * height / n) for i in range(n)]
    border += [(width - x, height - y) for x, y in border]

    def points(factor):
        return [project((x - center[0]) / focal[0] / factor, (y - center[1]) / focal[1] / factor, 1) for x, y in border]

    low, high = 0.5, 2
    for _ in range(40):
        middle = (low + high) / 2
        if all(-1e-9 <= u <= width + 1e-9 and -1e-9 <= v <= height + 1e-9 for u, v in points(middle)):
            high = middle
        else:
            low = middle
    p = points(high)
    return abs(sum(p[i - 1][0] * p[i][1] - p[i][0] * p[i - 1][1] for i in range(len(p)))) / 2 / (width * height)


def face_shares(camera, focal, border=MARGIN):
    """Faces of which a photograph shows a tenth at least: the share of pixels whose corners it shows, without `border` pixels at its edge."""
    project, (width, height) = camera
    n = ceil(2 * focal * HALF)
    shares = {}
    for name, direction in FACES.items():
        def shown(i, j):
            point = project(*direction((2 * i / n - 1) * HALF, (2 * j / n - 1) * HALF))
            return point and border <= point[0] <= width - border and border <= point[1] <= height - border
        count = sum(all(shown(x + 0.5 + 0.45 * a, y + 0.5 + 0.45 * b) for a in (-1, 1) for b in (-1, 1)) for x in range(n) for y in range(n))
        if count >= 0.1 * n * n:
            shares[name] = count / (n * n)
    return shares


def photograph_share(inverse, size, faces):
    """The share of a photograph's pixels whose direction is in one of the faces; inverse(u, v) is a direction or None."""
    n, count = 400, 0
    for i in range(n):
        for j in range(n):
            ray = inverse((i + 0.5) * size[0] / n, (j + 0.5) * size[1] / n)
            axes = ray and {"front": (0, 1, 2), "right": (2, 1, 0), "back": (0, 1, 2), "left": (2, 1, 0), "up": (0, 2, 1), "down": (0, 2, 1)}
            for face in faces if ray else ():
                a, b, ahead = axes[face]
                depth = ray[ahead] if face in ("front", "right", "down") else -ray[ahead]
                if depth > 0 and abs(ray[a]) <= HALF * depth and abs(ray[b]) <= HALF * depth:
                    count += 1
                    break
    return count / n**2


def equidistant(focal, center):
    def inverse(u, v):
        x, y = (u - center[0]) / focal, (v - center[1]) / focal
        t = hypot(x, y)
        return (x * sin(t) / t, y * sin(t) / t, cos(t)) if 0 < t <= pi else None
    return inverse


def main():
    rays = [(0.3, -0.2, 1), (-0.7, 0.5, 1), (0.1, 0.6, 1)]
    for ray in rays:
        print("METASHAPE %.3f %.3f" % metashape(ray, 510, -10, 3, (320, 240), (0.05, -0.02, 0.004, -0.001), 0.002, -0.003))
    for ray in rays:
        print("METASHAPE_FISHEYE %.3f %.3f" % metashape(ray, 510, -10, 3, (320, 240), (0.05, -0.02, 0.004, -0.001), 0.002, -0.003, True))
    for ray in rays:
        print("FISHEYE624 %.3f %.3f" % aria(ray, (500, 510), (320, 240), (0.05, -0.02, 0.004, -0.001, 0.0005, -0.0002), (0.002, -0.003),
                                            (0.001, -0.0005, -0.002, 0.0003)))
    size, center = (100, 75), (50, 37.5)
    for name, radius, fy, prism in (("SIMPLE_FISHEYE", fisheye(), 80, 0), ("OPENCV_FISHEYE", fisheye(0.01), 81, 0), ("FOV", fov(0.9), 81, 0),
                                    ("DIVISION", division(-0.1), 81, 0), ("EUCM", eucm(0.6, 1.1), 81, 0),
                                    ("FULL_OPENCV", rational(-0.1, 0.01), 81, 0), ("RAD_TAN_THIN_PRISM_FISHEYE", fisheye(0.01), 81, 0.001)):
        camera = lens(radius, (80, fy), center, size, prism)
        print(f"{name} as one pinhole picture: {pinhole_share(camera, (80, fy), center):.4f} of the photograph")
    for name, focal, side in (("180 degrees", 31.83, 100), ("360 degrees", 31.83, 200), ("40 x 40", 12.73, 40)):
        camera = lens(fisheye(), (focal, focal), (side / 2, side / 2), (side, side))
        shares = face_shares(camera, focal)
        used = photograph_share(equidistant(focal, (side / 2, side / 2)), (side, side), shares)
        print(f"fisheye, {name}: {used:.4f} of the photograph; faces {shares}")
    for name, camera, density in (
            ("EQUIRECTANGULAR", panorama((600, 300)), 600 / (2 * pi)),
            ("FISHEYE", lens(fisheye(), (127.3, 127.3), (200, 200), (400, 400)), 127.3),
            ("OPENCV_FISHEYE", lens(fisheye(0.02, -0.005, 0.001, -0.0002), (125, 127), (198.5, 201.5), (400, 400),
                                    limit=fold(fisheye(0.02, -0.005, 0.001, -0.0002))), 127),
            ("EUCM", lens(eucm(0.6, 1.1), (120, 121), (199.5, 150.5), (400, 300), limit=fold(eucm(0.6, 1.1))), 121)):
        shares = face_shares(camera, density, 0 if name == "EQUIRECTANGULAR" else MARGIN)
        print(f"{name} of undistort_test: {len(shares)} faces, {sum(shares.values()) / len(shares):.4f} of their pixels")


if __name__ == "__main__":
    main()
