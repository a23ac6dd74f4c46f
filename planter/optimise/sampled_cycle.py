"""A cycle as N samples at phi = 2 pi i / N.

F_i(x) is smooth except where a breakpoint passes sample i. If its order is 1, the gradient of F_i jumps there by
a multiple of the gradient of psi, the angle of the breakpoint, and the objective is not differentiable; at
breakpoints of order 2 only the second derivative jumps, which a Newton method tolerates. Derivatives in this module are
exact and one-sided, on the side of the design. Two kinds of `BreakpointHold` confine a solver to one side, or to the
breakpoint itself:

* a wall confines a breakpoint to the interval between two samples, within which every F_i is smooth;
* a pin fixes a breakpoint at a sample, which is then evaluated there, F(psi(x), x): smooth again, with psi(x) = phi_i.
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
"""Breakpoints closer to a sample than this coincide with it [rad]."""
WALL_MARGIN = 1e-7
"""Distance of a wall from the samples, so that rounding moves no breakpoint across [rad]."""
INITIAL_ROW_SHARE = 0.25
"""Samples within this share of the range from an extreme are in the first working set."""


def sample_angles(samples: int, period: float) -> Array:
    """Return the sample angles that differ modulo the period [rad], (n,).

    N samples of a cycle have n = N / 2 such angles if N is even and the period is pi.
    """
    periods = round(2 * np.pi / period)
    count = samples // periods if samples % periods == 0 else samples
    angles: Array = 2 * np.pi * np.arange(count) / samples
    return angles


class SampledCycle:
    """A cycle of the curve as N samples. Implements `CycleEvaluation` and `Kinks`."""

    def __init__(self, response: CycleResponse, samples: int) -> None:
        self.response = response
        self.angles = sample_angles(samples, response.period)
        self.spacing = response.period / len(self.angles)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return ObjectiveSummary.at(self.response.value(self.response.prologue(x), self.angles))

    def local(self, x: Array) -> SampledRows:
        """Return all samples near an extreme as components, without constrained breakpoints."""
        values = self.response.value(self.response.prologue(x), self.angles)
        margin = INITIAL_ROW_SHARE * np.ptp(values)
        upper, lower = np.flatnonzero(values >= values.max() - margin), np.flatnonzero(values <= values.min() + margin)
        return SampledRows(self.response, self.angles, upper, lower)

    def find_pins(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Return each breakpoint of order 1 as a pin at the nearest sample, with the distance psi - phi [rad]."""
        breakpoints = find_breakpoints(self.response, self.response.prologue(x))
        gaps = wrap_angle(breakpoints.folded[:, None] - self.angles, self.response.period)
        samples = np.abs(gaps).argmin(axis=1)
        distance = gaps[np.arange(len(samples)), samples]
        kinks = np.flatnonzero(breakpoints.orders == 1)
        return [(BreakpointHold(int(samples[j]), int(breakpoints.events[j])), float(distance[j])) for j in kinks]

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """Return the wall around a breakpoint at `distance` psi - phi [rad] from the sample of a pin."""
        ends = (WALL_MARGIN, self.spacing - WALL_MARGIN)
        low, high = ends if distance >= 0 else (-ends[1], -ends[0])
        return BreakpointHold(pin.sample, pin.event, low, high)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        at = self.response.prologue(x)
        values, slopes = self.response.slopes(at, self.angles)
        gradients = slopes[:, 1:]
        samples = np.array(
            [pin.sample for pin, distance in self.find_pins(x) if abs(distance) <= COINCIDENCE_TOLERANCE],
            dtype=np.int64,
        )
        before, after = (self._one_sided_gradients(at, samples, side) for side in (-1, 1))
        gradients[samples] = before
        weights = Variance(values).slope
        rows, both = np.append(values, values[samples]), np.vstack([gradients, after])
        kinks = weights[samples, None] * (after - before)
        return Conditions(rows, both, rows, both, weights @ gradients, kinks)

    def _one_sided_gradients(self, at: Any, samples: Integers, side: int) -> Array:
        """Return the gradients (k, p) of samples at breakpoints, on side -1 or 1 of these."""
        if not len(samples):
            return np.empty((0, len(self.response.names)))
        return self.response.slopes(at, self.angles[samples] + side * 2 * COINCIDENCE_TOLERANCE)[1][:, 1:]


class SampledRows:
    """Samples `upper` and `lower` as components, with breakpoints constrained by `holds`. Implements `LocalModel`."""

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

    def with_holds(self, holds: tuple[BreakpointHold, ...]) -> SampledRows:
        """Return a copy with exactly these breakpoints constrained."""
        return SampledRows(self.response, self.angles, self.upper, self.lower, holds)

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return ObjectiveSummary.at(self._state(x).values)

    def grown(self, x: Array, high: float, low: float) -> SampledRows:
        """Return a copy which also has the samples outside [low, high] as components."""
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
        sample_weights = weights.smooth * state.variance.slope
        np.add.at(sample_weights, self.upper, weights.upper)
        np.add.at(sample_weights, self.lower, weights.lower)
        return weights.smooth * state.variance.squared(state.gradients) + state.hessian(sample_weights, weights.holds)


class _SampleState:
    """Values, gradients and Hessians of the samples at one design, pinned samples at their breakpoints."""

    def __init__(self, rows: SampledRows, x: Array) -> None:
        self.response, self.at = rows.response, rows.response.prologue(x)
        self.gaps, self.velocity = np.empty(0), np.empty((0, len(x)))
        if rows.holds:
            self.breakpoints = find_breakpoints(self.response, self.at)
            self.chosen, self.gaps = _select_breakpoints(self.breakpoints, rows)
            self.velocity = self.breakpoints.velocity[self.chosen]
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
        """Second derivatives of the angles of the constrained breakpoints, (k, p, p)."""
        return self.breakpoints.acceleration(self.chosen)

    def hessian(self, weights: Array, holds: Array) -> Array:
        """Return the weighted sum (p, p) of the Hessians of samples and angles of constrained breakpoints.

        `weights` (n,) belong to the samples, `holds` (k,) to the breakpoints.
        """
        fixed = weights.copy()
        fixed[self.picked] = 0
        total: Array = self.response.hessian(self.at, self.phi, fixed)[1:, 1:]
        if len(self.picked):
            motion = PointMotion(self.velocity[self.pins], self.acceleration[self.pins])
            second = self.response.hessians(self.at, self.phi[self.picked])
            moved = hessians_along(self.jacobian[self.picked], second, motion)
            total = total + np.tensordot(weights[self.picked], moved, 1)
        if len(holds):
            total = total + np.tensordot(holds, self.acceleration, 1)
        return total


def _select_breakpoints(breakpoints: Breakpoints, rows: SampledRows) -> tuple[Integers, Array]:
    """Return, for each hold, the nearest breakpoint of its event and its distance from the sample of the hold [rad]."""
    chosen, gaps = [], []
    for hold in rows.holds:
        middle = (hold.low + hold.high) / 2
        gap = wrap_angle(breakpoints.folded - rows.angles[hold.sample] - middle, breakpoints.response.period)
        chosen.append(int(np.where(breakpoints.events == hold.event, np.abs(gap), np.inf).argmin()))
        gaps.append(float(gap[chosen[-1]] + middle))
    return np.array(chosen, dtype=np.int64), np.array(gaps)
