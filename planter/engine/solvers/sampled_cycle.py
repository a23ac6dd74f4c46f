"""A cycle as N samples at phi = 2 pi i / N.

F_i(x) is smooth except where a breakpoint passes sample i. If its order is 1, the gradient of F_i
jumps there by a multiple of the gradient of psi, the angle of the breakpoint, and the objective is
not differentiable; at breakpoints of order 2 only the second derivative jumps, which a Newton
method tolerates. Derivatives in this module are exact and one-sided, on the side of the design. Two
kinds of `BreakpointHold` confine a solver to one side, or to the breakpoint itself:

* a wall confines a breakpoint to the interval between two samples, within which every F_i is
  smooth;
* a pin fixes a breakpoint at a sample, which is then evaluated there, F(psi(x), x): smooth again,
  with psi(x) = phi_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from planter.engine.solvers.curve_sum import CurvePart, CurveSum, SmoothSum
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    ObjectiveSummary,
)
from planter.engine.solvers.response import (
    ONE_SIDED_OFFSET,
    Breakpoints,
    CycleResponse,
    PointMotion,
    find_breakpoints,
    gradients_along,
    hessians_along,
)
from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import TURN, LastCallCache, wrap_angle

COINCIDENCE_TOLERANCE = 1e-8
"""Breakpoints closer to a sample than this coincide with it [rad]."""
WALL_MARGIN = 1e-7
"""Distance of a wall from the samples, so that rounding moves no breakpoint across [rad]."""
INITIAL_ROW_SHARE = 0.25
"""Samples within this share of the range from an extreme are in the first working set."""


def sample_angles(samples: int, period: float, turn: float = TURN) -> Array:
    """Return the sample angles of a turn that differ modulo the period [rad], (n,).

    N samples of a cycle have n = N / 2 such angles if N is even and the period is half a turn.
    """
    periods = round(turn / period)
    count = samples // periods if samples % periods == 0 else samples
    angles: Array = turn * np.arange(count) / samples
    return angles


class SampledCycle(CurvePart):
    """A sum over curves by N samples of a cycle. Implements `ObjectivePart` and `Kinks`."""

    windows = False

    def __init__(self, response: CycleResponse, total: CurveSum, samples: int) -> None:
        super().__init__(response, total, samples)
        self.angles = sample_angles(samples, response.period, response.turn)
        self.spacing = response.period / len(self.angles)

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return summarise_samples(
            self.total, self.response.curves.values(self.response.prologue(x), self.angles)
        )

    @property
    def kinks(self) -> SampledCycle:
        return self

    def coarse(self, x: Array) -> None:
        """Return None: the samples are few already."""

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> SampledRows:
        """Return all samples near an extreme as rows, with breakpoints constrained by `holds`."""
        values, total = (
            self.response.curves.values(self.response.prologue(x), self.angles),
            self.total,
        )
        tops = summarise_samples(total, values).tops[total.groups]
        reach = INITIAL_ROW_SHARE * np.ptp(values, axis=1)[total.rows]
        signed = total.signs[:, None] * values[total.rows]
        chosen = signed >= (tops - reach)[:, None]
        return SampledRows(self.response, total, self.angles, chosen, tuple(holds))

    def find_pins(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Return each breakpoint of order 1 as a pin at the nearest sample, with the distance psi -
        phi [rad].
        """
        breakpoints = find_breakpoints(self.response, self.response.prologue(x))
        gaps = wrap_angle(breakpoints.folded[:, None] - self.angles, self.response.period)
        samples = np.abs(gaps).argmin(axis=1)
        distance = gaps[np.arange(len(samples)), samples]
        kinks = np.flatnonzero(breakpoints.orders == 1)
        return [
            (BreakpointHold(int(samples[j]), int(breakpoints.events[j])), float(distance[j]))
            for j in kinks
        ]

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """Return the wall around a breakpoint at `distance` psi - phi [rad] from the sample of a
        pin.
        """
        ends = (WALL_MARGIN, self.spacing - WALL_MARGIN)
        low, high = ends if distance >= 0 else (-ends[1], -ends[0])
        return BreakpointHold(pin.sample, pin.event, low, high)

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        at, total = self.response.prologue(x), self.total
        values, slopes = self.response.curves.slopes(at, self.angles)
        gradients = slopes[:, :, 1:]
        samples = np.array(
            [
                pin.sample
                for pin, distance in self.find_pins(x)
                if abs(distance) <= COINCIDENCE_TOLERANCE
            ],
            dtype=np.int64,
        )
        before, after = (self._one_sided_gradients(at, samples, side) for side in (-1, 1))
        gradients[:, samples] = before
        smooth = SmoothSum(total.statistics, values)
        rows = np.hstack([values, values[:, samples]])[total.rows] * total.signs[:, None]
        both = np.concatenate([gradients, after], axis=1)[total.rows] * total.signs[:, None, None]
        groups = np.repeat(total.groups, rows.shape[1])
        kinks = np.einsum("mk,mkp->kp", smooth.slope[:, samples], after - before)
        return Conditions(
            rows.ravel(), groups, both.reshape(-1, len(x)), smooth.gradient(gradients), kinks
        )

    def _one_sided_gradients(self, at: Any, samples: Integers, side: int) -> Array:
        """Return the gradients (m, k, p) of samples at breakpoints, on side -1 or 1 of these."""
        if not len(samples):
            return np.empty((self.response.count, 0, len(self.response.names)))
        return self.response.curves.slopes(
            at, self.angles[samples] + side * 2 * COINCIDENCE_TOLERANCE
        )[1][:, :, 1:]


def summarise_samples(total: CurveSum, values: Array) -> ObjectiveSummary:
    """Return the summary of samples (m, n) of a cycle."""
    high, low = values.max(axis=1), values.min(axis=1)
    tops = np.where(total.signs > 0, high[total.rows], -low[total.rows])
    return total.summarise(SmoothSum(total.statistics, values), tops)


class SampledRows:
    """The samples that `chosen` (s, n) marks of each side as rows, with breakpoints constrained by
    `holds`.
    """

    def __init__(
        self,
        response: CycleResponse,
        total: CurveSum,
        phi: Array,
        chosen: Flags,
        holds: tuple[BreakpointHold, ...] = (),
    ) -> None:
        self.response, self.total, self.angles, self.chosen, self.holds = (
            response,
            total,
            phi,
            chosen,
            holds,
        )
        self.sides, self.samples = np.nonzero(chosen)
        self.curves, self.groups = total.rows[self.sides], total.groups[self.sides]
        self.signs = total.signs[self.sides]
        self.bounds = np.array([[h.low for h in holds], [h.high for h in holds]])
        self._state = LastCallCache(lambda x: _SampleState(self, x))

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return summarise_samples(self.total, self._state(x).values)

    def extended(self, x: Array, tops: Array) -> SampledRows:
        """Return a copy which also has the samples that exceed the tops (g,) of their groups as
        rows.
        """
        signed = self.total.signs[:, None] * self._state(x).values[self.total.rows]
        chosen = self.chosen | (signed > tops[self.total.groups][:, None])
        return SampledRows(self.response, self.total, self.angles, chosen, self.holds)

    def values(self, x: Array) -> Array:
        """Return the smooth value, the rows and the holds at a design x (p,)."""
        state = self._state(x)
        rows = self.signs * state.values[self.curves, self.samples]
        return np.concatenate([[state.smooth.value], rows, state.gaps])

    def slopes(self, x: Array) -> Array:
        """Return their gradients (n, p) at a design x (p,)."""
        state = self._state(x)
        rows = self.signs[:, None] * state.gradients[self.curves, self.samples]
        return np.vstack([state.smooth.gradient(state.gradients), rows, state.velocity])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (n,)."""
        state = self._state(x)
        smooth, (rows, holds) = weights[0], np.split(weights[1:], [len(self.signs)])
        each = smooth * state.smooth.slope
        np.add.at(each, (self.curves, self.samples), self.signs * rows)
        squared = smooth * state.smooth.squared(state.gradients)
        return squared + state.hessian(each, holds)


class _SampleState:
    """Values, gradients and Hessians of the samples at one design, pinned samples at their
    breakpoints.
    """

    def __init__(self, rows: SampledRows, x: Array) -> None:
        self.response, self.at, self.total = rows.response, rows.response.prologue(x), rows.total
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

    @cached_property
    def values(self) -> Array:
        """Values (m, n), from the slopes if these are known."""
        return (
            self._both[0]
            if "_both" in vars(self)
            else self.response.curves.values(self.at, self.phi)
        )

    @cached_property
    def _both(self) -> tuple[Array, Array]:
        return self.response.curves.slopes(self.at, self.phi)

    @property
    def jacobian(self) -> Array:
        return self._both[1]

    @cached_property
    def gradients(self) -> Array:
        """Gradients of the samples, (m, n, p)."""
        gradients = self.jacobian[:, :, 1:].copy()
        gradients[:, self.picked] = gradients_along(
            self.jacobian[:, self.picked], self.velocity[self.pins]
        )
        return gradients

    @cached_property
    def smooth(self) -> SmoothSum:
        return SmoothSum(self.total.statistics, self.values)

    @cached_property
    def acceleration(self) -> Array:
        """Second derivatives of the angles of the constrained breakpoints, (k, p, p)."""
        return self.breakpoints.acceleration(self.chosen)

    def hessian(self, weights: Array, holds: Array) -> Array:
        """Return the weighted sum (p, p) of the Hessians of samples and angles of constrained
        breakpoints.

        `weights` (m, n) belong to the samples, `holds` (k,) to the breakpoints.
        """
        fixed = weights.copy()
        fixed[:, self.picked] = 0
        total: Array = self.response.curves.curvature(self.at, self.phi, fixed)[1:, 1:]
        if len(self.picked):
            motion = PointMotion(self.velocity[self.pins], self.acceleration[self.pins])
            moved = weights[:, self.picked]
            second = self.response.curves.curvatures(self.at, self.phi[self.picked], moved)
            slopes = np.einsum("mk,mkp->kp", moved, self.jacobian[:, self.picked])
            total = total + hessians_along(slopes, second, motion).sum(axis=0)
        if len(holds):
            total = total + np.tensordot(holds, self.acceleration, 1)
        return total


def _select_breakpoints(breakpoints: Breakpoints, rows: SampledRows) -> tuple[Integers, Array]:
    """Return, for each hold, the nearest breakpoint of its event and its distance from the sample
    of the hold [rad].
    """
    chosen, gaps = [], []
    for hold in rows.holds:
        middle = (hold.low + hold.high) / 2
        gap = wrap_angle(
            breakpoints.folded - rows.angles[hold.sample] - middle, breakpoints.response.period
        )
        chosen.append(int(np.where(breakpoints.events == hold.event, np.abs(gap), np.inf).argmin()))
        gaps.append(float(gap[chosen[-1]] + middle))
    return np.array(chosen, dtype=np.int64), np.array(gaps)
