# SPDX-License-Identifier: MIT
"""3D Gaussian Splatting: reads, renders, trains, counts, converts and compares, with quadsplat.

    import quadsplat
    scene = quadsplat.load("plush.ply")
    quadsplat.render(scene, scene.cameras()[0]).save("first.png")

Importing it uses no GPU and imports nothing but numpy. docs/python.md is the guide.

Conventions: world and view axes are x right, y down, z forward. Pixel i has its centre at i.
Pictures are height x width x 3 values of RGB, nominally 0..1, and are not clamped.
"""
from ._camera import Camera, read_cameras
from ._compare import Comparison, compare
from ._context import Context
from ._errors import Cancelled, DeviceError, Error, InputError, UsageError
from ._ffi import VERSION as __version__
from ._files import read_picture
from ._lists import ModeCount, TileLists, counts, tile_lists
from ._machine import Device, Mode, Report, devices, modes, report
from ._parts import adam, neighbours, relocate, ssim, ssim_backward
from ._picture import Counts, Picture
from ._render import render
from ._scene import Edited, Scene, SceneFacts, convert, load
from ._select import SurfacePoint, measure
from ._settings import Settings
from ._train import Training, train

__all__ = [
    "Camera",
    "Cancelled",
    "Comparison",
    "Context",
    "Counts",
    "Device",
    "DeviceError",
    "Edited",
    "Error",
    "InputError",
    "Mode",
    "ModeCount",
    "Picture",
    "Report",
    "Scene",
    "SceneFacts",
    "Settings",
    "SurfacePoint",
    "TileLists",
    "Training",
    "UsageError",
    "__version__",
    "adam",
    "compare",
    "convert",
    "counts",
    "devices",
    "load",
    "measure",
    "modes",
    "neighbours",
    "read_cameras",
    "read_picture",
    "relocate",
    "render",
    "report",
    "ssim",
    "ssim_backward",
    "tile_lists",
    "train",
]
