"""Many roots at once: Newton's method kept inside brackets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array

MOST_STEPS = 100


def newton(function: Callable[[Array], tuple[Array, Array]], low: Array, high: Array, start: Array) -> Array:
    """Roots (m,) of m functions, each in its own bracket [low, high] with a change of sign.

    `function` gives values and derivatives, (m,) each, at m points; a Newton step that leaves its bracket is replaced
    by halving. Stops where all steps are at rounding level. Raises ComputationError if that is never reached.
    """
    low, high, at = low.copy(), high.copy(), start.copy()
    rising = function(low)[0] < 0
    size = np.maximum(np.abs(low), np.abs(high))
    for _ in range(MOST_STEPS):
        value, slope = function(at)
        below = (value < 0) == rising
        low, high = np.where(below, at, low), np.where(below, high, at)
        step = -np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0)
        outside = ~((low <= at + step) & (at + step <= high))
        following = np.where(value == 0, at, np.where(outside, (low + high) / 2, at + step))
        moved, at = np.abs(following - at), following
        if (moved <= 4 * np.finfo(float).eps * size).all():
            return at
    raise ComputationError(f"a root was not found to rounding level in {MOST_STEPS} steps, near {at[moved.argmax()]:.6g}")
