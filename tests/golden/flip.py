#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""FLIP of small pictures, independently of the program: filters with two axes, double precision.

Usage: flip.py > flip.json   (needs numpy; run from anywhere)
Written from the formulas of Andersson et al. 2020 (LDR-FLIP); shares no code with src/.
"""
import json
import math

import numpy as np

WIDTH, HEIGHT = 48, 36
RGB_TO_XYZ = np.array([[10135552, 8788810, 4435075], [2613072 * 2, 8788810 * 2, 887015 * 2],
                       [1425312 / 3, 8788810 / 3, 70074185 / 3]]) / 24577794
WHITE = RGB_TO_XYZ.sum(1)
SENSITIVITY = [[(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]]


def picture(kind):
    """8-bit values / 255, height x width x 3. The test makes the same ones."""
    y, x, c = np.meshgrid(np.arange(HEIGHT), np.arange(WIDTH), np.arange(3), indexing="ij")
    value = (5 * x + 3 * y + 40 * c + (x * y) // 16) % 200 + 20
    if kind == "shifted":
        value = value + np.where((x > 10) & (x < 30) & (y > 8) & (y < 20), 25 - 20 * c, 0)
    if kind == "dotted":
        value = np.where((x % 12 == 5) & (y % 9 == 4), 255 - 60 * c, value)
    if kind == "inverted":
        value = 255 - value
    return value / 255.0


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def opponent(rgb):
    x, y, z = np.moveaxis(rgb @ RGB_TO_XYZ.T / WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def rgb_of(opp):
    y = (opp[..., 0] + 16) / 116
    xyz = np.stack([opp[..., 1] / 500 + y, y, y - opp[..., 2] / 200], -1) * WHITE
    return xyz @ np.linalg.inv(RGB_TO_XYZ).T


def hunt_lab(rgb):
    t = rgb @ RGB_TO_XYZ.T / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    lightness = 116 * y - 16
    return np.stack([lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)], -1)


def hyab(a, b):
    d = a - b
    return np.abs(d[..., 0]) + np.sqrt(d[..., 1] ** 2 + d[..., 2] ** 2)


def convolve(plane, kernel):
    r = kernel.shape[0] // 2
    padded = np.pad(plane, r, mode="edge")
    result = np.zeros_like(plane)
    for j in range(2 * r + 1):
        for i in range(2 * r + 1):
            result += kernel[j, i] * padded[j:j + plane.shape[0], i:i + plane.shape[1]]
    return result


def seen(image, ppd):
    opp = opponent(linear(image))
    r = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi ** 2)) * ppd)
    i, j = np.meshgrid(np.arange(-r, r + 1), np.arange(-r, r + 1))
    z = (i / ppd) ** 2 + (j / ppd) ** 2
    channels = []
    for c, terms in enumerate(SENSITIVITY):
        kernel = sum(a * math.sqrt(math.pi / b) * np.exp(-math.pi ** 2 * z / b) for a, b in terms)
        channels.append(convolve(opp[..., c], kernel / kernel.sum()))
    lab = hunt_lab(np.clip(rgb_of(np.stack(channels, -1)), 0, 1))

    sd = 0.5 * 0.082 * ppd
    r = math.ceil(3 * sd)
    i, j = np.meshgrid(np.arange(-r, r + 1), np.arange(-r, r + 1))
    bell = np.exp(-(i ** 2 + j ** 2) / (2 * sd * sd))
    features = []
    for kernel in (-i * bell, (i ** 2 / sd ** 2 - 1) * bell):
        kernel = np.where(kernel > 0, kernel / kernel[kernel > 0].sum(), kernel / -kernel[kernel < 0].sum())
        luminance = (opp[..., 0] + 16) / 116
        features.append(np.sqrt(convolve(luminance, kernel) ** 2 + convolve(luminance, kernel.T) ** 2))
    return lab, features


def flip(reference, test, ppd):
    (lab_a, features_a), (lab_b, features_b) = seen(reference, ppd), seen(test, ppd)
    largest = hyab(hunt_lab(np.array([0.0, 1, 0])), hunt_lab(np.array([0.0, 0, 1]))) ** 0.7
    knee = 0.4 * largest
    distance = hyab(lab_a, lab_b) ** 0.7
    color = np.where(distance < knee, 0.95 / knee * distance,
                     0.95 + (distance - knee) / (largest - knee) * 0.05)
    feature = np.maximum(*(np.abs(a - b) for a, b in zip(features_a, features_b)))
    return color ** (1 - np.sqrt(feature / math.sqrt(2)))


result = {"means": {}, "pixels": {}}
for ppd in (0.7 * 3840 / 0.7 * math.pi / 180, 20):
    for kind in ("shifted", "dotted", "inverted"):
        error = flip(picture("plain"), picture(kind), ppd)
        name = f"{kind} at {ppd:.4f}"
        result["means"][name] = float(error.mean())
        result["pixels"][name] = {f"{x},{y}": float(error[y, x]) for x, y in ((0, 0), (17, 13), (47, 35))}
print(json.dumps(result, indent=2))
