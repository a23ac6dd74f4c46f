"""Periodic curve F(phi, x), such as a force over a machine cycle, with exact derivatives and breakpoints.

Breakpoints are the angles where derivatives of the curve jump. Like smooth peaks, and unlike samples at fixed angles,
they move with the design x. At a point with the angle psi(x), f(x) = F(psi(x), x) has the derivatives

    f_x  = F_x + F_phi psi_x
    f_xx = F_xx + F_xphi psi_x + psi_x' F_phix + F_phiphi psi_x' psi_x + F_phi psi_xx.

At a smooth peak F_phi = 0 and psi_x = -F_phix / F_phiphi, so that f_x = F_x (envelope theorem) and
f_xx = F_xx - F_xphi F_phix / F_phiphi. At a breakpoint both sides of F give the same f_x and f_xx, as F is
continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import casadi as ca
import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN, Integers
from planter.numerics.roots import find_crossings


@dataclass(frozen=True)
class BreakpointEvent:
    """A kind of breakpoint: the curve is smooth in (phi, x) except where g(phi, x) is an integer multiple of `period`.

    If `period` is None, the breakpoints are the zeros of g. `order` is the order of the first derivative of F in phi
    that jumps there: 1 or 2, or 0 if F itself jumps; such a curve can be evaluated but not optimised.
    """

    name: str
    order: int
    period: float | None


@dataclass(frozen=True)
class CompiledResponse:
    """A response at n angles as compiled functions for CasADi graphs; d (v,) are all values of a machine.

    `moved` are the positions of x in `data` (v,). F(phi) is the sum over the lanes, which are `value` at phi plus each
    of `offsets` [rad].
    """

    data: Array
    moved: tuple[int, ...]
    offsets: tuple[float, ...]
    prologue: ca.Function
    """(d) -> h, dh: the invariants of the angle, and their sparse Jacobian in x."""
    curvature: ca.Function
    """(d, weights) -> Hessian (p, p) of weights . h in x."""
    value: ca.Function
    """(phi, d, h) -> the value of each lane."""
    slopes: ca.Function
    """(phi, d, h, dh) -> values of the lanes, and their Jacobian in (phi, x)."""
    bending: ca.Function
    """(phi, d, h, dh, weights) -> weighted sum of the Hessians in (phi, x), packed, and the weighted slope in h."""


class CycleResponse(Protocol):
    """A curve F(phi, x), continuous, periodic in phi with `period` [rad]; designs x are (p,), angles (n,).

    The result of `prologue` is the argument `at` of all other methods. Breakpoints of the k-th event lie at angles in
    [0, 2 pi) and recur with the `period` of F.
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
    def events(self) -> tuple[BreakpointEvent, ...]: ...

    def prologue(self, x: Array) -> Any:
        """Return the invariants of the angle at a design x (p,)."""

    def value(self, at: Any, phi: Array) -> Array:
        """Return F, (n,)."""

    def rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """Return F and its derivative in phi, (n,) each."""

    def rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of F in phi, (n,) each."""

    def slopes(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """Return F, (n,), and its Jacobian in (phi, x), (n, 1 + p)."""

    def hessian(self, at: Any, phi: Array, weights: Array) -> Array:
        """Return the weighted sum over the angles of the Hessian of F in (phi, x), (1 + p, 1 + p)."""

    def hessians(self, at: Any, phi: Array) -> Array:
        """Return the Hessian of F in (phi, x) at each angle, (n, 1 + p, 1 + p)."""

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """Return g of every event and its derivative in phi, (k, n) each."""

    def event_slopes(self, at: Any, phi: Array) -> Array:
        """Return the Jacobian of g in (phi, x), (k, n, 1 + p)."""

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        """Return the Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""

    def compiled(self, angles: int) -> CompiledResponse | None:
        """Return the response at a number of angles as compiled functions, or None if a part of it is not compiled."""


BREAKPOINT_GRID = 72
"""Intervals of a cycle in which breakpoints are bracketed; two of the same event in one interval are missed."""
ONE_SIDED_OFFSET = 1e-9
"""Distance from a breakpoint at which one-sided derivatives are evaluated [rad]."""


@dataclass(frozen=True)
class Breakpoints:
    """Breakpoints of side 1 at a design, sorted: `angles` (m,) in [0, 2 pi) [rad], `events` (m,) index of the event."""

    response: CycleResponse
    at: Any
    angles: Array
    events: Integers

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
        return np.mod(self.angles, self.response.period)

    @cached_property
    def _slopes(self) -> Array:
        if not len(self.angles):
            return np.empty((0, 1 + len(self.response.names)))
        return self.response.event_slopes(self.at, self.angles)[self.events, np.arange(len(self.events))]

    @cached_property
    def velocity(self) -> Array:
        """Derivative of the angles in the design, -g_x / g_phi, (m, p)."""
        slopes = self._slopes
        velocity: Array = -slopes[:, 1:] / slopes[:, :1]
        return velocity

    def acceleration(self, picked: Integers) -> Array:
        """Return the second derivatives of the angles of the `picked` (k,) breakpoints in the design, (k, p, p)."""
        size = self.velocity.shape[1]
        accelerations = np.empty((len(picked), size, size))
        for i, j in enumerate(picked):
            path = np.vstack([self.velocity[j], np.eye(size)])
            hessian = self.response.event_hessian(self.at, float(self.angles[j]), int(self.events[j]))
            accelerations[i] = -(path.T @ hessian @ path) / self._slopes[j, 0]
        return accelerations


def find_breakpoints(response: CycleResponse, at: Any) -> Breakpoints:
    """Return all breakpoints at a design, given its invariants."""
    periods = np.array([event.period or np.inf for event in response.events])
    crossings = find_crossings(lambda phi: response.event_values(at, phi), periods, BREAKPOINT_GRID, TURN)
    return Breakpoints(response, at, crossings.angles, crossings.rows)


@dataclass(frozen=True)
class BreakpointPosition:
    """A breakpoint of one side: its angle in [0, 2 pi) [rad] and the derivative of the angle in the design, (p,)."""

    name: str
    side: int
    order: int
    angle: float
    velocity: Array


def list_breakpoints(response: CycleResponse, at: Any) -> list[BreakpointPosition]:
    """Return the breakpoints of all sides over a cycle, sorted by angle; each side follows the last by one period."""
    breakpoints = find_breakpoints(response, at)
    sides = round(TURN / response.period)
    positions = [
        BreakpointPosition(name, side, int(order), float(np.mod(angle + (side - 1) * response.period, TURN)), velocity)
        for side in range(1, sides + 1)
        for name, order, angle, velocity in zip(
            breakpoints.names, breakpoints.orders, breakpoints.angles, breakpoints.velocity, strict=True
        )
    ]
    return sorted(positions, key=lambda position: position.angle)


@dataclass(frozen=True)
class PointMotion:
    """First derivatives `velocity` (m, p) and second derivatives `acceleration` (m, p, p) of m angles in the design."""

    velocity: Array
    acceleration: Array


def gradients_along(slopes: Array, velocity: Array) -> Array:
    """Return the gradients (m, p) at moving points from Jacobians (m, 1 + p) in (phi, x)."""
    total: Array = slopes[:, 1:] + slopes[:, :1] * velocity
    return total


def hessians_along(slopes: Array, second: Array, motion: PointMotion) -> Array:
    """Return Hessians (m, p, p) at moving points from Jacobians (m, 1 + p) and Hessians `second` in (phi, x)."""
    mixed = second[:, 1:, :1] * motion.velocity[:, None, :]
    squared = motion.velocity[:, :, None] * motion.velocity[:, None, :]
    total: Array = second[:, 1:, 1:] + mixed + mixed.transpose(0, 2, 1) + second[:, :1, :1] * squared
    return total + slopes[:, :1, None] * motion.acceleration


def peak_velocity(second: Array) -> Array:
    """Return the velocity (m, p) of smooth peaks, -F_phix / F_phiphi, from Hessians (m, 1 + p, 1 + p)."""
    velocity: Array = -second[:, 0, 1:] / second[:, :1, 0]
    return velocity


def fixed_motion(count: int, size: int) -> PointMotion:
    """Return the zero motion of `count` points at fixed angles, in `size` parameters."""
    return PointMotion(np.zeros((count, size)), np.zeros((count, size, size)))
