# SPDX-License-Identifier: MIT
"""A method of gsplat's DefaultStrategy without waits for the GPU, versions 1.4 to 1.6."""
from __future__ import annotations

import functools
from typing import Any, Callable, Dict

from ..torch._parts import add_view
from ._gsplat import Info


def _update_state(plain: Callable[..., None]) -> Callable[..., None]:
    """gsplat's method, which adds a picture's gradients of centres to sums per Gaussian.

    gsplat makes a list of the visible Gaussians, and three operations wait for its length. Here one
    kernel adds them. Pictures of several cameras, packed ones and radii in the state remain
    gsplat's.
    """

    @functools.wraps(plain)
    def update_state(self: Any, params: Any, state: Dict[str, Any], info: Any,
                     packed: bool = False) -> None:
        found = _gradients(self, state, info) if isinstance(info, Info) and not packed else None
        if found is None:
            plain(self, params, state, info, packed=packed)
            return
        gradients, radii = found
        for name in ("grad2d", "count"):
            if state[name] is None:
                state[name] = gradients.new_zeros(gradients.shape[0])
        add_view(gradients, radii, (info["width"] / 2, info["height"] / 2), state["grad2d"],
                 state["count"])

    return update_state


def _gradients(strategy: Any, state: Dict[str, Any], info: Info) -> Any:
    """The gradients and the radii of a picture, N x 2 each. None: gsplat's method takes the step."""
    if strategy.key_for_gradient != "means2d" or "radii" in state:
        return None
    points, radii = info["means2d"], info["radii"]
    gradients = points.absgrad if strategy.absgrad else points.grad
    if gradients is None or gradients.shape[0] != 1 or radii.shape != gradients.shape:
        return None
    return gradients[0], radii[0]

