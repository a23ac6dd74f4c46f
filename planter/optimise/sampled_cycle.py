"""The turn as N samples at phi = 2 pi i / N.

F_i(x) is smooth but where a joint passes sample i. There, for a joint of order 1, its gradient jumps by a multiple of
the gradient of psi, the joint's angle, and the objective has a kink; at joints of order 2 only the second derivative
jumps, which a Newton method bears. Derivatives here are those of the side that the design is on, and exact. Two kinds
of `BreakpointHold` keep a solver on one side, or on the kink itself:

* a wall keeps a joint between two samples: within its walls every F_i is smooth;
* a pin keeps a joint on a sample, which is then taken at the joint, F(psi(x), x): smooth again, with psi(x) = phi_i.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers, LastCallCache, wrap_angle
from planter.optimise.objective import BreakpointHold, Conditions, ModelGradients, ModelValues, ObjectiveSummary
from planter.optimise.response import (
    ONE_SIDED_OFFSET,
    Breakpoints,
    CycleResponse,
    PointMotion,
    find_breakpoints,
    gradients_along,
    hessians_along,
)
from planter.optimise.variance import Variance

COINCIDENCE_TOLERANCE = 1e-8
"""A joint closer than this to a sample sits on it [rad]."""
WALL_MARGIN = 1e-7
"""How far from its samples a wall keeps a joint, so that no rounding takes it across [rad]."""
INITIAL_ROW_SHARE = 0.25
"""Samples within this share of the range from an extreme are in the first working set."""


def sample_angles(samples: int, period: float) -> Array:
    """The samples' angles that differ modulo the period [rad], (n,): half of them where N is even and the period pi."""
    turns = round(2 * np.pi / period)
    count = samples // turns if samples % turns == 0 else samples
    found: Array = 2 * np.pi * np.arange(count) / samples
    return found


class SampledCycle:
    """A turn of the curve as N samples. Implements `Turn` and `Kinks`."""

    def __init__(self, response: CycleResponse, samples: int) -> None:
        self.response = response
        self.angles = sample_angles(samples, response.period)
        self.spacing = response.period / len(self.angles)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return ObjectiveSummary.at(self.response.value(self.response.prologue(x), self.angles))

    def local(self, x: Array) -> SampledRows:
        """All samples near an extreme as rows; nothing held."""
        values = self.response.value(self.response.prologue(x), self.angles)
        margin = INITIAL_ROW_SHARE * np.ptp(values)
        upper, lower = np.flatnonzero(values >= values.max() - margin), np.flatnonzero(values <= values.min() + margin)
        return SampledRows(self.response, self.angles, upper, lower)

    def near(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Every joint of order 1 as a pin on the sample nearest to it, with the distance psi - phi [rad]."""
        found = find_breakpoints(self.response, self.response.prologue(x))
        gaps = wrap_angle(found.folded[:, None] - self.angles, self.response.period)
        samples = np.abs(gaps).argmin(axis=1)
        distance = gaps[np.arange(len(samples)), samples]
        kinks = np.flatnonzero(found.orders == 1)
        return [(BreakpointHold(int(samples[j]), int(found.events[j])), float(distance[j])) for j in kinks]

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """The wall around a joint's cell between two samples, from its distance psi - phi to one of them [rad]."""
        ends = (WALL_MARGIN, self.spacing - WALL_MARGIN)
        low, high = ends if distance >= 0 else (-ends[1], -ends[0])
        return BreakpointHold(pin.sample, pin.event, low, high)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        at = self.response.prologue(x)
        values, slopes = self.response.slopes(at, self.angles)
        gradients = slopes[:, 1:]
        samples = np.array(
            [pin.sample for pin, distance in self.near(x) if abs(distance) <= COINCIDENCE_TOLERANCE], dtype=np.int64
        )
        before, after = (self._aside(at, samples, side) for side in (-1, 1))
        gradients[samples] = before
        weights = Variance(values).slope
        rows, both = np.append(values, values[samples]), np.vstack([gradients, after])
        kinks = weights[samples, None] * (after - before)
        return Conditions(rows, both, rows, both, weights @ gradients, kinks)

    def _aside(self, at: Any, samples: Integers, side: int) -> Array:
        """Gradients (k, p) of samples on joints, on one side of these."""
        if not len(samples):
            return np.empty((0, len(self.response.names)))
        return self.response.slopes(at, self.angles[samples] + side * 2 * COINCIDENCE_TOLERANCE)[1][:, 1:]


class SampledRows:
    """Samples `upper` and `lower` as rows; joints kept by `holds`. Implements `Local`."""

    def __init__(
        self,
        response: CycleResponse,
        phi: Array,
        upper: Integers,
        lower: Integers,
        holds: tuple[BreakpointHold, ...] = (),
    ) -> None:
        self.response, self.angles = response, phi
        self.upper, self.lower, self.holds = upper, lower, holds
        self.bounds = np.array([[h.low for h in holds], [h.high for h in holds]])
        self._state = LastCallCache(lambda x: _SampleState(self, x))

    def held(self, holds: tuple[BreakpointHold, ...]) -> SampledRows:
        """With these joints held, and no others."""
        return SampledRows(self.response, self.angles, self.upper, self.lower, holds)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return ObjectiveSummary.at(self._state(x).values)

    def grown(self, x: Array, high: float, low: float) -> SampledRows:
        """With the samples that are beyond [low, high] as further rows."""
        values = self._state(x).values
        upper = np.union1d(self.upper, np.flatnonzero(values > high))
        lower = np.union1d(self.lower, np.flatnonzero(values < low))
        return SampledRows(self.response, self.angles, upper, lower, self.holds)

    def values(self, x: Array) -> ModelValues:
        """Return the values of the smooth function, rows and holds at a design x (p,)."""
        state = self._state(x)
        return ModelValues(state.variance.value, state.values[self.upper], state.values[self.lower], state.gaps)

    def slopes(self, x: Array) -> ModelGradients:
        """Return the gradients of the smooth function, rows and holds at a design x (p,)."""
        state = self._state(x)
        gradients = state.gradients
        return ModelGradients(
            state.variance.gradient(gradients), gradients[self.upper], gradients[self.lower], state.velocity
        )

    def curvature(self, x: Array, weights: ModelValues) -> Array:
        """Return the weighted sum (p, p) of the Hessians at a design x (p,)."""
        state = self._state(x)
        each = weights.smooth * state.variance.slope
        np.add.at(each, self.upper, weights.upper)
        np.add.at(each, self.lower, weights.lower)
        return weights.smooth * state.variance.squared(state.gradients) + state.hessian(each, weights.holds)


class _SampleState:
    """The samples at one design: forces, gradients and Hessians, pinned ones at their joints."""

    def __init__(self, rows: SampledRows, x: Array) -> None:
        self.response, self.at = rows.response, rows.response.prologue(x)
        self.gaps, self.velocity = np.empty(0), np.empty((0, len(x)))
        if rows.holds:
            self.joints = find_breakpoints(self.response, self.at)
            self.chosen, self.gaps = _select_rows(self.joints, rows)
            self.velocity = self.joints.velocity[self.chosen]
        self.pins = np.flatnonzero([hold.pin for hold in rows.holds])
        self.picked = np.array([rows.holds[k].sample for k in self.pins], dtype=np.int64)
        phi = rows.angles.copy()
        phi[self.picked] += self.gaps[self.pins] + ONE_SIDED_OFFSET
        self.phi = phi
        self.values, self.jacobian = self.response.slopes(self.at, phi)
        self.gradients = self.jacobian[:, 1:].copy()
        self.gradients[self.picked] = gradients_along(self.jacobian[self.picked], self.velocity[self.pins])

    @cached_property
    def variance(self) -> Variance:
        return Variance(self.values)

    @cached_property
    def acceleration(self) -> Array:
        """Second derivatives of the held joints' angles, (k, p, p)."""
        return self.joints.acceleration(self.chosen)

    def hessian(self, weights: Array, holds: Array) -> Array:
        """Weighted sum (p, p) of the Hessians of the samples (n,) and of the held joints' angles (k,)."""
        standing = weights.copy()
        standing[self.picked] = 0
        total: Array = self.response.hessian(self.at, self.phi, standing)[1:, 1:]
        if len(self.picked):
            motion = PointMotion(self.velocity[self.pins], self.acceleration[self.pins])
            second = self.response.hessians(self.at, self.phi[self.picked])
            moved = hessians_along(self.jacobian[self.picked], second, motion)
            total = total + np.tensordot(weights[self.picked], moved, 1)
        if len(holds):
            total = total + np.tensordot(holds, self.acceleration, 1)
        return total


def _select_rows(found: Breakpoints, rows: SampledRows) -> tuple[Integers, Array]:
    """The joint that each hold keeps, the nearest of its event, and its distance from the hold's sample [rad]."""
    chosen, gaps = [], []
    for hold in rows.holds:
        middle = (hold.low + hold.high) / 2
        gap = wrap_angle(found.folded - rows.angles[hold.sample] - middle, found.response.period)
        chosen.append(int(np.where(found.events == hold.event, np.abs(gap), np.inf).argmin()))
        gaps.append(float(gap[chosen[-1]] + middle))
    return np.array(chosen, dtype=np.int64), np.array(gaps)
