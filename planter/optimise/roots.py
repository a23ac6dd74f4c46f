"""Many roots at once: Newton's method kept inside brackets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array

MOST_STEPS = 100
SMALL = 1e-6
"""Steps below this share of the root's size that no longer shrink are rounding."""


def newton(function: Callable[[Array], tuple[Array, Array]], low: Array, high: Array, start: Array) -> Array:
    """Roots (m,) of m functions, each in its own bracket [low, high] with a change of sign.

    `function` gives values and derivatives, (m,) each, at m points; a Newton step that leaves its bracket is replaced
    by halving. A root is found where the step is at rounding level, of the angle or of the function. Raises
    ComputationError if that is never reached.
    """
    low, high, at = low.copy(), high.copy(), start.copy()
    rising = function(low)[0] < 0
    size = np.maximum(np.abs(low), np.abs(high))
    last, open_ = np.full(len(at), np.inf), np.ones(len(at), dtype=bool)
    for _ in range(MOST_STEPS):
        value, slope = function(at)
        below = (value < 0) == rising
        low, high = np.where(below, at, low), np.where(below, high, at)
        aim = at - np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0)
        following = np.where((low <= aim) & (aim <= high), aim, (low + high) / 2)
        following = np.where((value == 0) | ~open_, at, following)
        moved = np.abs(following - at)
        open_ &= (moved > 4 * np.finfo(float).eps * size) & ~((moved >= last) & (moved <= SMALL * size))
        at, last = following, moved
        if not open_.any():
            return at
    raise ComputationError(f"a root was not found in {MOST_STEPS} steps, near {at[open_][0]:.6g}")
