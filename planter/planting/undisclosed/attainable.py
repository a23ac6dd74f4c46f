"""What range and variance of the force some inputs can give at all: the most variance within caps on the range.

L-BFGS-B with exact gradients from many starts, range and contact held by growing penalties. It is a heuristic search:
every point of a front is reached by inputs that are known, and nothing proves that no point lies beyond.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from planter.kernels import Array
from planter.planting.undisclosed.force import Curve, Force

PENALTIES = (0.1, 100.0)
"""Weights of what is broken, beside the variance: small ones first, which let a search pass."""
MARGIN = 0.5
"""Force by which the cam is asked to push more than not at all [N], so that penalties end on the right side."""
UNIT = 100.0
"""Unit of the force in a search [N]."""
MOST_ITERATIONS = 200


@dataclass(frozen=True)
class Reached:
    """A point z of the unit box with its range [N], its variance [N2] and the least force of cam on roller [N]."""

    z: Array
    range: float
    variance: float
    push: float


class MostVariance:
    """The variance, less penalties for a range above a cap [N] and, where it must push, for a cam that pulls.

    A point is (z, m): the force must stay within half the cap about m, which is free.
    """

    def __init__(self, force: Force, cap: float, pushing: bool) -> None:
        self.force, self.cap, self.pushing = force, cap, pushing
        self.bounds = [*[(0.0, 1.0)] * len(force.inputs), (None, None)]

    def start(self, z: Array) -> Array:
        curve = self.force(z)
        return np.append(z, (curve.force.max() + curve.force.min()) / 2 / UNIT)

    def cost(self, w: Array, weight: float) -> tuple[float, Array]:
        """What is to be made small, in squares of the unit, and its gradient."""
        curve = self.force(w[:-1])
        beside = curve.force - UNIT * w[-1]
        out = np.sign(beside) * np.maximum(np.abs(beside) - self.cap / 2, 0)
        pulled = np.maximum(MARGIN - curve.push, 0) if self.pushing else np.zeros(1)
        value = -curve.variance + weight * float(out @ out + pulled @ pulled / 10)
        along = -curve.variance_slopes + weight * 2 * out @ curve.slopes
        if self.pushing:
            along -= weight * 2 * pulled @ curve.push_slopes / 10
        return value / UNIT**2, np.append(along, -weight * 2 * UNIT * out.sum()) / UNIT**2

    def climbed(self, z: Array) -> Reached:
        """Where the search from a point ends."""
        w = self.start(z)
        for weight in PENALTIES:
            settings = {"maxiter": MOST_ITERATIONS}
            w = minimize(self.cost, w, (weight,), "L-BFGS-B", jac=True, bounds=self.bounds, options=settings).x
        curve: Curve = self.force(w[:-1])
        return Reached(w[:-1], curve.range, curve.variance, float(curve.push.min()))


def most_variance(force: Force, cap: float, pushing: bool, starts: Iterable[Array]) -> Reached | None:
    """The most variance that was reached; with `pushing`, where the cam never has to pull.

    None where no search ended so.
    """
    search = MostVariance(force, cap, pushing)
    found = [search.climbed(z) for z in starts]
    kept = [one for one in found if not pushing or one.push >= 0]
    return max(kept, key=lambda one: one.variance, default=None)


def largest_range(force: Force, pushing: bool, starts: Iterable[Array]) -> Reached | None:
    """The largest range that was reached; None where no search ended with a cam that pushes, if it must."""
    found = [_stretched(force, pushing, z) for z in starts]
    kept = [one for one in found if not pushing or one.push >= 0]
    return max(kept, key=lambda one: one.range, default=None)


def _stretched(force: Force, pushing: bool, z: Array) -> Reached:
    """Where a search for the largest range ends."""

    def cost(z: Array, weight: float) -> tuple[float, Array]:
        curve = force(z)
        high, low = int(curve.force.argmax()), int(curve.force.argmin())
        value, along = -curve.range, curve.slopes[low] - curve.slopes[high]
        if pushing:
            pulled = np.maximum(MARGIN - curve.push, 0)
            value += weight * float(pulled @ pulled) / UNIT
            along = along - weight * 2 * pulled @ curve.push_slopes / UNIT
        return value / UNIT, along / UNIT

    bounds = [(0.0, 1.0)] * len(z)
    for weight in PENALTIES:
        z = minimize(cost, z, (weight,), "L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": MOST_ITERATIONS}).x
    curve = force(z)
    return Reached(z, curve.range, curve.variance, float(curve.push.min()))
