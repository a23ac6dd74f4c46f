"""Many roots at once: Newton's method kept inside brackets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array

Rates = Callable[[Array], tuple[Array, Array]]

MOST_STEPS = 100
SMALL = 1e-9
"""After a Newton step below this share of the bracket's ends the next would be rounding."""
FLAT = 1e-6
"""Newton steps below this share that no longer shrink are rounding of the function."""


def newton(function: Rates, low: Array, high: Array, ends: tuple[Array, Array]) -> Array:
    """Roots (m,) of m functions, each in its own bracket [low, high].

    `ends` are the values there, of opposite sign or zero. `function` gives values and derivatives, (m,) each, at m
    points. A Newton step that leaves its bracket is replaced by halving. Raises ComputationError if a root is not found
    to rounding level, of the angle or of the function.
    """
    low, high, rising = low.copy(), high.copy(), ends[0] < ends[1]
    size = np.maximum(np.abs(low), np.abs(high))
    apart = ends[1] - ends[0]
    share = np.divide(-ends[0], apart, out=np.zeros_like(apart), where=apart != 0)
    at = np.clip(low + share * (high - low), low, high)
    last, open_ = np.full(len(at), np.inf), np.ones(len(at), dtype=bool)
    for _ in range(MOST_STEPS):
        value, slope = function(at)
        below = (value < 0) == rising
        low, high = np.where(below, at, low), np.where(below, high, at)
        aim = at - np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0)
        inside = (low <= aim) & (aim <= high)
        following = np.where(inside, aim, (low + high) / 2)
        following = np.where((value == 0) | ~open_, at, following)
        moved = np.abs(following - at)
        at, halved = following, ~inside & (moved > 4 * np.finfo(float).eps * size)
        open_ &= halved | ~(moved <= np.where(moved >= last, FLAT, SMALL) * size)
        last = moved
        if not open_.any():
            return at
    raise ComputationError(f"a root was not found in {MOST_STEPS} steps, near {at[open_][0]:.6g}")
