# SPDX-License-Identifier: MIT
"""The rules in which differentiable rasterizers differ."""
from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple, Optional, Tuple

from .. import _ffi
from .._checks import choice, encoded, integer, real, reals
from .._settings import with_cull


class _Rules(NamedTuple):
    cull: str = "quadbox"  #: culling mode, of quadsplat.modes(), but "reference"
    sh_degree: int = 3  #: highest degree that is evaluated, 0..3
    far_depth: float = 0.0  #: Gaussians with view z above it are not drawn; 0: no far plane
    dilation_px2: float = 0.3  #: added to both variances of a projected Gaussian, >= 0
    splat_scale: float = 1.0  #: factor on every standard deviation, > 0
    antialiased: bool = False  #: opacities are compensated for the dilation
    compensation_floor: float = 2.5e-5  #: lower bound of the ratio of determinants in it, 0..1
    alpha_max: float = 0.99  #: alpha is clamped to this, above 0 and below 1
    alpha_max_blocks: bool = False  #: a clamped alpha has gradient 0
    stops_at_equal: bool = False  #: a pixel also stops at a transmittance of exactly 1e-4
    normalises_rotations: bool = True  #: False: quaternions are used with the length they have
    zero_color_passes: bool = False  #: colours that are exactly 0 pass their gradient on
    radius_clip_px: float = 0.0  #: Gaussians whose radii are at most this are not drawn, >= 0
    radius_rule: str = "inria"  #: formula of the radii: "inria", "gsplat_1_4" or "gsplat_1_5"
    #: (x low, y low, x high, y high): bounds of x/z and y/z in the Jacobian of the projection;
    #: None: 1.3 times the half field of view, to both sides
    slopes: Optional[Tuple[float, float, float, float]] = None


class Rules(_Rules):
    """The rules of rasterize(). `quadsplat train` has the default ones.

    The near plane belongs to the camera. `mode` is an older name of `cull`.
    """

    __slots__ = ()

    def __new__(cls, *members: Any, **named: Any) -> Rules:
        return super().__new__(cls, *members, **with_cull(named, "Rules"))


#: Types of members whose values cannot change.
_FIXED = {str, int, float, bool}


def struct_of(who: str, rules: Rules) -> _ffi.QsRules:
    """The struct of rules, which is not to be changed: equal rules share one.

    The library checks their ranges. Raises UsageError.
    """
    slopes = None if rules.slopes is None else reals(rules.slopes, f"{who}: rules.slopes", 4)
    members = rules[:-1]
    if _FIXED.issuperset(map(type, members)):
        return _remembered(who, slopes, *members)
    return _made(who, slopes, *members)


def _made(who: str, slopes: Optional[Tuple[float, ...]], *members: Any) -> _ffi.QsRules:
    rules = Rules(*members)
    struct = _ffi.QsRules()
    struct.cull = encoded(rules.cull, f"{who}: rules.cull")
    struct.sh_degree = integer(rules.sh_degree, f"{who}: rules.sh_degree", 0, 3)
    for name in ("far_depth", "dilation_px2", "splat_scale", "compensation_floor", "alpha_max",
                 "radius_clip_px"):
        setattr(struct, name, real(getattr(rules, name), f"{who}: rules.{name}"))
    for name in ("antialiased", "alpha_max_blocks", "stops_at_equal", "zero_color_passes"):
        setattr(struct, name, bool(getattr(rules, name)))
    struct.keeps_rotation_length = not rules.normalises_rotations
    struct.radius_rule = choice(rules.radius_rule, f"{who}: rules.radius_rule", _ffi.RADII)
    if slopes is not None:
        struct.slope_low[:], struct.slope_high[:] = slopes[:2], slopes[2:]
    return struct


# `typed`: 3.0 is no degree, although it equals 3.
_remembered = lru_cache(maxsize=256, typed=True)(_made)
