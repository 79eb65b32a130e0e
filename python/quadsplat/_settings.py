# SPDX-License-Identifier: MIT
"""Everything that a frame depends on besides scene and camera."""
from __future__ import annotations

from typing import Any, Dict, NamedTuple, Optional, Sequence

from . import _ffi
from ._checks import choice, encoded, integer, real, reals
from ._errors import UsageError
from ._warn import warn


class Settings(NamedTuple):
    """The settings of render(), tile_lists() and counts(), by name, with their usual values."""

    cull: str = "quadbox"  #: culling mode: modes() lists them
    pipeline: str = "fast"  #: "fast", or "classic", which follows the published 3DGS code
    background: Optional[Sequence[float]] = None  #: RGB; None: white if the model asks, or black
    splat_scale: float = 1.0  #: factor on every standard deviation, 1e-6..1e6
    dilation_px2: float = 0.3  #: added to both variances of a projected Gaussian, 0..1e6
    sh_degree: int = 3  #: highest degree that is evaluated, 0..3
    antialiased: Optional[bool] = None  #: opacity compensation; None: as trained
    tile_px: int = 16  #: side of a tile: 16; on the CPU also 8 or 32


def with_cull(given: Dict[str, Any], who: str) -> Dict[str, Any]:
    """The settings with `cull` in place of `mode`, its name in older versions."""
    if "mode" not in given:
        return given
    if "cull" in given:
        raise UsageError(f"{who}: give cull alone: mode is its older name")
    warn(f"{who}: mode is called cull now, as on the command line", DeprecationWarning)
    return {"cull" if name == "mode" else name: value for name, value in given.items()}


def struct_of(who: str, given: Dict[str, Any], white_background: bool) -> _ffi.QsSettings:
    """The struct of settings by name. Raises UsageError."""
    given = with_cull(given, who)
    for name in given:
        if name not in Settings._fields:
            raise UsageError(f"{who}: there is no setting {name!r}: the settings are "
                             + ", ".join(Settings._fields))
    chosen = Settings(**given)
    struct = _ffi.QsSettings()
    struct.cull = encoded(chosen.cull, f"{who}: cull")
    struct.pipeline = choice(chosen.pipeline, f"{who}: pipeline", _ffi.PIPELINES)
    usual = (1.0, 1.0, 1.0) if white_background else (0.0, 0.0, 0.0)
    background = usual if chosen.background is None else chosen.background
    struct.background[:] = reals(background, f"{who}: background", 3)
    struct.splat_scale = real(chosen.splat_scale, f"{who}: splat_scale")
    struct.dilation_px2 = real(chosen.dilation_px2, f"{who}: dilation_px2")
    struct.sh_degree = integer(chosen.sh_degree, f"{who}: sh_degree", 0, 3)
    struct.antialiased = choice(chosen.antialiased, f"{who}: antialiased", _ffi.ANTIALIASED)
    struct.tile_px = integer(chosen.tile_px, f"{who}: tile_px", 1, 65535)
    return struct
