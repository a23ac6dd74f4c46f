"""Periodic curve F(phi, x), such as a force over a machine cycle, with exact derivatives and
breakpoints.

Breakpoints are the angles where derivatives of the curve jump. Like smooth peaks, and unlike
samples at fixed angles, they move with the design x. At a point with the angle psi(x), f(x) =
F(psi(x), x) has the derivatives

    f_x  = F_x + F_phi psi_x
    f_xx = F_xx + F_xphi psi_x + psi_x' F_phix + F_phiphi psi_x' psi_x + F_phi psi_xx.

At a smooth peak F_phi = 0 and psi_x = -F_phix / F_phiphi, so that f_x = F_x (envelope theorem) and
f_xx = F_xx - F_xphi F_phix / F_phiphi. At a breakpoint both sides of F give the same f_x and f_xx,
as F is continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import TURN
from planter.numerics.roots import find_crossings


@dataclass(frozen=True)
class BreakpointEvent:
    """A kind of breakpoint: the curve is smooth in (phi, x) except where g(phi, x) is an integer
    multiple of `period`.

    If `period` is None, the breakpoints are the zeros of g. `order` is the order of the first
    derivative of F in phi that jumps there: 1 or 2, or 0 if F itself jumps; such a curve can be
    evaluated but not optimised.
    """

    name: str
    order: int
    period: float | None


class AngleFunctions(Protocol):
    """Functions (m,) of the angle and the design, at angles phi (n,) of a design given by its
    invariants `at`.

    Loose results are NaN where something is not finite, as beside a root.
    """

    def values(self, at: Any, phi: Array) -> Array:
        """Return the functions, (m, n)."""

    def derivatives(self, at: Any, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the functions and their derivatives in phi, (m, n) each."""

    def rates(self, at: Any, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the first and second derivatives in phi, (m, n) each."""

    def slopes(self, at: Any, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the functions, (m, n), and their Jacobian in (phi, x), (m, n, 1 + p)."""

    def list_passages(self, at: Any) -> list[tuple[str, float]]:
        """Return the names and angles [rad] of events that a free motion has already located."""

    def curvature(self, at: Any, phi: Array, weights: Array) -> Array:
        """Return the sum over functions and angles of weights (m, n) times Hessians in (phi, x),
        (1 + p, 1 + p).
        """

    def curvatures(self, at: Any, phi: Array, weights: Array) -> Array:
        """Return the sum over functions of weights (m, n) times Hessians in (phi, x), (n, 1 + p,
        1 + p).
        """

    def curvature_along(self, at: Any, phi: Array, weights: Array, angle_slopes: Array) -> Array:
        """Return the weighted sum of the Hessians in x alone, (p, p), at angles with slopes (n,
        p).
        """


class CycleResponse(Protocol):
    """Curves F(phi, x), (m,), periodic in phi with `period` [rad]; designs x are (p,), angles (n,).

    The result of `prologue` is the argument `at` of the functions. The k-th of the `event_functions` is
    that of the k-th event, whose breakpoints lie at angles in [0, turn), less each of the `shifts`, and
    recur with the `period` of F. Parts of the period are those on which conditions (c,) hold, whose
    ends are breakpoints too. `is_closed` says whether the curves are at the end of a period what
    they are at its beginning.
    """

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def lower(self) -> Array: ...
    @property
    def upper(self) -> Array: ...
    @property
    def design(self) -> Array: ...
    @property
    def period(self) -> float: ...
    @property
    def turn(self) -> float: ...
    @property
    def shifts(self) -> tuple[float, ...]: ...
    @property
    def events(self) -> tuple[BreakpointEvent, ...]: ...
    @property
    def curves(self) -> AngleFunctions: ...
    @property
    def event_functions(self) -> AngleFunctions: ...
    @property
    def is_closed(self) -> bool: ...
    @property
    def count(self) -> int: ...

    def restart(self) -> None:
        """Forget all designs so far, on which the last digits may depend."""

    def prologue(self, x: Array) -> Any:
        """Return the invariants of the angle at a design x (p,)."""

    def misses(self, at: Any, phi: Array) -> Array:
        """Return by how much each condition is missed at angles, (c, n), not positive where it
        holds.
        """


BREAKPOINT_GRID = 360
"""Intervals of a revolution in which breakpoints are bracketed; two of the same event in one
interval are missed.
"""
ONE_SIDED_OFFSET = 1e-9
"""Distance from a breakpoint at which one-sided derivatives are evaluated [rad]."""


@dataclass(frozen=True)
class BreakpointPosition:
    """A breakpoint of one side, the first of which is 1, at its angle of a turn [rad]."""

    name: str
    side: int
    angle: float
    is_touch: bool


@dataclass(frozen=True)
class Breakpoints:
    """Breakpoints at a design: `angles` (m,) of side 1 in [0, turn) [rad], `events` (m,) index of
    the event.

    They lie at these angles less the shift of a side, one of `sides` (m,). `is_touch` (m,) marks those at which
    the function of an event comes to zero and turns round: there its derivative vanishes, by which
    the breakpoint moves.
    """

    response: CycleResponse
    at: Any
    angles: Array
    events: Integers
    sides: Integers
    is_touch: Flags

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.response.events[k].name for k in self.events)

    @property
    def orders(self) -> Integers:
        """Order of the first derivative of F in phi that jumps, (m,)."""
        return np.array([self.response.events[k].order for k in self.events], dtype=np.int64)

    @property
    def folded(self) -> Array:
        """Angles modulo the period of the curve [rad], (m,)."""
        return np.mod(self._shifted, self.response.period)

    @property
    def _shifted(self) -> Array:
        shifted: Array = self.angles - np.array(self.response.shifts)[self.sides]
        return shifted

    def list_positions(self) -> list[BreakpointPosition]:
        """Return the breakpoints of all sides over a turn, sorted by angle; those of a total recur
        with its period.
        """
        turn, period = self.response.turn, self.response.period
        positions = [
            BreakpointPosition(
                name, side + k + 1, float(np.mod(angle + k * period, turn)), is_touch
            )
            for k in range(round(turn / period))
            for name, side, angle, is_touch in zip(
                self.names, self.sides.tolist(), self._shifted, self.is_touch.tolist(), strict=True
            )
        ]
        return sorted(positions, key=lambda position: position.angle)

    @cached_property
    def _slopes(self) -> Array:
        if not len(self.angles):
            return np.empty((0, 1 + len(self.response.names)))
        slopes = self.response.event_functions.slopes(self.at, self.angles, is_loose=True)[1]
        slopes = slopes[self.events, np.arange(len(self.events))]
        for k in np.flatnonzero(self.is_touch):
            slopes[k] = self._bend(int(k))[0]
        return slopes

    def _bend(self, index: int) -> Array:
        """Return the Hessian (1 + p, 1 + p) of the function of a breakpoint's event in (phi, x)."""
        event = self.events[index]
        weights = np.eye(len(self.response.events))[:, event : event + 1]
        return self.response.event_functions.curvature(
            self.at, self.angles[index : index + 1], weights
        )

    @cached_property
    def velocity(self) -> Array:
        """Derivative of the angles in the design, -g_x / g_phi, (m, p)."""
        slopes = np.where(self.is_regular[:, None], self._slopes, 0.0)
        rises = np.where(self.is_regular, slopes[:, 0], 1.0)
        velocity: Array = -slopes[:, 1:] / rises[:, None]
        return velocity

    @cached_property
    def is_regular(self) -> Flags:
        """Flags (m,) of breakpoints at which the function of the event has a slope, by which they
        move.
        """
        flags: Flags = np.isfinite(self._slopes).all(axis=1) & (self._slopes[:, 0] != 0)
        return flags

    def acceleration(self, picked: Integers) -> Array:
        """Return the second derivatives of the angles of the `picked` (k,) breakpoints in the
        design, (k, p, p).

        Those of touches are left out: nothing jumps there.
        """
        size = self.velocity.shape[1]
        accelerations = np.zeros((len(picked), size, size))
        for i, j in enumerate(picked):
            if self.is_touch[j] or not self.is_regular[j]:
                continue
            path = np.vstack([self.velocity[j], np.eye(size)])
            accelerations[i] = -(path.T @ self._bend(int(j)) @ path) / self._slopes[j, 0]
        return accelerations


def find_breakpoints(response: CycleResponse, at: Any) -> Breakpoints:
    """Return all breakpoints at a design, given its invariants."""
    periods = np.array([event.period or np.inf for event in response.events])
    count, sides = round(BREAKPOINT_GRID * response.turn / TURN), len(response.shifts)
    crossings = find_crossings(
        lambda phi: response.event_functions.derivatives(at, phi, is_loose=True),
        periods,
        count,
        response.turn,
        lambda phi: response.event_functions.rates(at, phi, is_loose=True),
    )
    names = [event.name for event in response.events]
    passages = response.event_functions.list_passages(at)
    located = np.array([names.index(name) for name, _ in passages], dtype=np.int64)
    angles = np.concatenate([[angle for _, angle in passages], crossings.angles, crossings.touches])
    events = np.concatenate([located, crossings.rows, crossings.touch_rows])
    is_touch = np.arange(len(angles)) >= len(passages) + len(crossings.angles)
    searched = np.arange(len(angles)) >= len(passages)
    is_left = ~(searched & np.isin(events, located))  # a motion knows its own events
    angles, events, is_touch = angles[is_left], events[is_left], is_touch[is_left]
    return Breakpoints(
        response,
        at,
        np.tile(angles, sides),
        np.tile(events, sides),
        np.repeat(np.arange(sides), len(angles)),
        np.tile(is_touch, sides),
    )


def list_breakpoints(response: CycleResponse, at: Any) -> list[BreakpointPosition]:
    """Return the breakpoints of all sides over a turn at a design, given its invariants."""
    return find_breakpoints(response, at).list_positions()


@dataclass(frozen=True)
class PointMotion:
    """First derivatives `velocity` (m, p) and second derivatives `acceleration` (m, p, p) of m
    angles in the design.
    """

    velocity: Array
    acceleration: Array


def gradients_along(slopes: Array, velocity: Array) -> Array:
    """Return the gradients (..., p) at moving points from Jacobians (..., 1 + p) in (phi, x)."""
    total: Array = slopes[..., 1:] + slopes[..., :1] * velocity
    return total


def hessians_along(slopes: Array, second: Array, motion: PointMotion) -> Array:
    """Return Hessians (m, p, p) at moving points from Jacobians (m, 1 + p) and Hessians `second` in
    (phi, x).
    """
    mixed = second[:, 1:, :1] * motion.velocity[:, None, :]
    squared = motion.velocity[:, :, None] * motion.velocity[:, None, :]
    total: Array = (
        second[:, 1:, 1:] + mixed + mixed.transpose(0, 2, 1) + second[:, :1, :1] * squared
    )
    return total + slopes[:, :1, None] * motion.acceleration


def peak_velocity(second: Array) -> Array:
    """Return the velocity (m, p) of smooth peaks, -F_phix / F_phiphi, from Hessians (m, 1 + p, 1 +
    p).

    Where a curve is level no place is better than another: the peak stays.
    """
    bend = second[:, :1, 0]
    velocity: Array = np.divide(
        -second[:, 0, 1:], bend, out=np.zeros_like(second[:, 0, 1:]), where=bend != 0
    )
    return velocity


def fixed_motion(count: int, size: int) -> PointMotion:
    """Return the zero motion of `count` points at fixed angles, in `size` parameters."""
    return PointMotion(np.zeros((count, size)), np.zeros((count, size, size)))
