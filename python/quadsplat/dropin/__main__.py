# SPDX-License-Identifier: MIT
"""python -m quadsplat.dropin [--cull MODE] [--variant NAME] [--device cpu] script.py|-m module ARGS"""
from __future__ import annotations

import argparse
import os
import runpy
import sys
from typing import List

from .._errors import UsageError
from . import DEVICES, VARIANTS, install


def main(words: List[str]) -> None:
    """Runs a script or module with the drop-in. Its arguments follow it."""
    parser = argparse.ArgumentParser(
        prog="python -m quadsplat.dropin", allow_abbrev=False,
        description="Runs a trainer with quadsplat in place of diff_gaussian_rasterization, "
                    "simple_knn, fused_ssim and gsplat's rasterizer.")
    parser.add_argument("--cull", metavar="MODE", help="culling mode; default: as the module culls")
    parser.add_argument("--variant", choices=VARIANTS, help="default: it follows from the settings")
    parser.add_argument("--device", choices=DEVICES,
                        help="tensors on cuda are on the CPU")
    parser.add_argument("-m", dest="is_module", action="store_true", help="the next word is a module")
    parser.add_argument("program", help="script or module")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="arguments of the program")
    options = parser.parse_args(words)
    try:
        install(options.cull, options.variant, options.device)
    except UsageError as error:
        parser.error(str(error))
    if options.is_module:
        sys.argv = [options.program, *options.arguments]
        sys.path[0] = os.getcwd()
        runpy.run_module(options.program, run_name="__main__", alter_sys=True)
    elif not os.path.exists(options.program):
        parser.error(f"{options.program} does not exist")
    else:
        sys.argv = [options.program, *options.arguments]
        sys.path[0] = os.path.dirname(os.path.abspath(options.program))
        runpy.run_path(options.program, run_name="__main__")


if __name__ == "__main__":
    main(sys.argv[1:])
