"""The point of a box beside another that keeps equations: by Newton's method, each step the least one in the box."""

from __future__ import annotations

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.box import Box
from planter.optimise.constraints import Constraints

MOST_STEPS = 20
SHARES = (1.0, 0.5, 0.25, 0.125, 0.0625)
"""Parts of a step that are tried: each has to take half its own part of the worst miss away."""
ROUNDING = 16 * float(np.finfo(float).eps)
"""A miss below this share of the largest right side is rounding."""
MET = 1e-6
"""What a step may leave of the worst miss to first order, and still meets the equations."""


def onto(box: Box, equations: Constraints, u: Array) -> Array:
    """The point (p,) that keeps the equations to rounding, from a point u (p,).

    Where none near by in the box keeps them, the one at which the steps end; u itself where they have no values.
    """
    here = box.inside(u)
    rounding = ROUNDING * np.abs(equations.upper).max()
    try:
        miss = equations.upper - equations.values(box.at(here))
        for _ in range(MOST_STEPS):
            if np.abs(miss).max() <= rounding:
                break
            slopes = equations.slopes(box.at(here)) * box.unit
            step = least_step(slopes, miss, box.bottom - here, box.top - here)
            following = _following(box, equations, here, step, miss)
            if following is None:
                break
            here, miss = following
    except ComputationError:
        return box.inside(u)
    return here


def _following(box: Box, equations: Constraints, here: Array, step: Array, miss: Array) -> tuple[Array, Array] | None:
    """The point that a step (p,), or a part of it, leads to, and the miss there; None where no part helps."""
    for share in SHARES:
        trial = box.inside(here + share * step)
        left = equations.upper - equations.values(box.at(trial))
        if np.abs(left).max() <= (1 - share / 2) * np.abs(miss).max():
            return trial, left
    return None


def least_step(slopes: Array, miss: Array, low: Array, high: Array) -> Array:
    """A short step d (p,) in its bounds with slopes (k, p) . d = miss (k,), as far as one can be found.

    Coordinates on a bound stay there if the others can do it alone.
    """
    inside = _stopped(slopes, miss, low, high, (low < 0) & (high > 0))
    if np.abs(slopes @ inside - miss).max() <= MET * np.abs(miss).max():
        return inside
    return _stopped(slopes, miss, low, high, np.ones(len(low), dtype=bool))


def _stopped(slopes: Array, miss: Array, low: Array, high: Array, free: Flags) -> Array:
    """The least step of the free coordinates (p,): what would pass its bounds stops there, and the others take over."""
    step = np.zeros(len(low))
    while free.any():
        rest = miss - slopes[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(slopes[:, free], rest, rcond=None)[0]
        beyond = free & ((step < low) | (step > high))
        step = np.clip(step, low, high)
        if not beyond.any():
            break
        free = free & ~beyond
    return step
