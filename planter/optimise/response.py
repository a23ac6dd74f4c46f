"""A closed curve F(phi, x), such as a force over a machine's turn, with exact derivatives.

Joints of a curve: the angles where its derivatives jump, and how they move with the design.

The curve along points that move with the design: a sample stands still, a peak or a joint does not.

With the angle psi(x) of a point, f(x) = F(psi(x), x) has

    f_x  = F_x + F_phi psi_x
    f_xx = F_xx + F_xphi psi_x + psi_x' F_phix + F_phiphi psi_x' psi_x + F_phi psi_xx.

At a smooth peak F_phi = 0 and psi_x = -F_phix / F_phiphi, which leaves the envelope theorem, f_x = F_x, and
f_xx = F_xx - F_xphi F_phix / F_phiphi. On a joint both sides of F give the same f_x and f_xx, since F is continuous.
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
    """A kind of joint: the curve is smooth in (phi, x) except where g(phi, x) is a whole multiple of `period`.

    `period` None: where g = 0. `order` is the order of the first derivative of F in phi that jumps there: 1 or 2, or 0
    if F itself jumps, which can be looked at but not optimised.
    """

    name: str
    order: int
    period: float | None


@dataclass(frozen=True)
class CompiledResponse:
    """A response over n angles as compiled functions, for use in CasADi's graphs; d (v,) are all values of a machine.

    x stands at `moved` in `data` (v,). The curve is a sum of equal shares: F(phi) is that of `value` at phi + each of
    `offsets` [rad], its lanes.
    """

    data: Array
    moved: tuple[int, ...]
    offsets: tuple[float, ...]
    prologue: ca.Function
    """(d) -> h, dh: what no angle changes, and its sparse Jacobian in x."""
    curvature: ca.Function
    """(d, weights) -> Hessian (p, p) of weights . h in x."""
    value: ca.Function
    """(phi, d, h) -> the share of each lane."""
    slopes: ca.Function
    """(phi, d, h, dh) -> shares, and their Jacobian in (phi, x)."""
    bending: ca.Function
    """(phi, d, h, dh, weights) -> weighted sum of the Hessians in (phi, x), packed, and the weighted slope in h."""


class CycleResponse(Protocol):
    """A curve F(phi, x), continuous, periodic in phi with `period` [rad]; designs x are (p,), angles (n,).

    `prologue` does once for a design what no angle changes; its result is handed to all other methods as `at`.
    Joints of the k-th event lie at angles in [0, 2 pi), and again at every `period` of F from there.
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

    def prologue(self, x: Array) -> Any: ...

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
        """Return the response over so many angles without Python, or None if it is not all compiled."""


BREAKPOINT_GRID = 72
"""Angles of a turn between which joints are looked for; two joints of one event closer than this are missed."""
ONE_SIDED_OFFSET = 1e-9
"""How far beside a joint one-sided derivatives are taken [rad]."""


@dataclass(frozen=True)
class Breakpoints:
    """Joints of side 1 at one design, by angle: `angles` (m,) in [0, 2 pi), `events` (m,) index of the event."""

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
        """The angles taken into the first period of the curve, (m,)."""
        return np.mod(self.angles, self.response.period)

    @cached_property
    def _slopes(self) -> Array:
        if not len(self.angles):
            return np.empty((0, 1 + len(self.response.names)))
        return self.response.event_slopes(self.at, self.angles)[self.events, np.arange(len(self.events))]

    @cached_property
    def velocity(self) -> Array:
        """Derivative of the angles in the design, (m, p): -g_x / g_phi."""
        slopes = self._slopes
        velocity: Array = -slopes[:, 1:] / slopes[:, :1]
        return velocity

    def acceleration(self, picked: Integers) -> Array:
        """Second derivative of the angles of the picked joints in the design, (k, p, p)."""
        size = self.velocity.shape[1]
        found = np.empty((len(picked), size, size))
        for i, j in enumerate(picked):
            path = np.vstack([self.velocity[j], np.eye(size)])
            bent = self.response.event_hessian(self.at, float(self.angles[j]), int(self.events[j]))
            found[i] = -(path.T @ bent @ path) / self._slopes[j, 0]
        return found


def find_breakpoints(response: CycleResponse, at: Any) -> Breakpoints:
    """Return all joints of a design."""
    periods = np.array([event.period or np.inf for event in response.events])
    angles, events = find_crossings(
        lambda phi: response.event_values(at, phi)[0],
        lambda phi: response.event_values(at, phi),
        periods,
        BREAKPOINT_GRID,
        TURN,
    )
    return Breakpoints(response, at, angles, events)


@dataclass(frozen=True)
class BreakpointPosition:
    """A joint of one side: its angle in [0, 2 pi) and the angle's derivative in the design, (p,)."""

    name: str
    side: int
    order: int
    angle: float
    velocity: Array


def list_breakpoints(response: CycleResponse, at: Any) -> list[BreakpointPosition]:
    """Joints of all sides over a turn, by angle: side 1, and the others each one period of the curve later."""
    found = find_breakpoints(response, at)
    sides = round(TURN / response.period)
    every = [
        BreakpointPosition(name, side, int(order), float(np.mod(angle + (side - 1) * response.period, TURN)), velocity)
        for side in range(1, sides + 1)
        for name, order, angle, velocity in zip(found.names, found.orders, found.angles, found.velocity, strict=True)
    ]
    return sorted(every, key=lambda place: place.angle)


@dataclass(frozen=True)
class PointMotion:
    """How m points move: `velocity` (m, p) and `acceleration` (m, p, p), derivatives of their angles in the design."""

    velocity: Array
    acceleration: Array


def gradients_along(slopes: Array, velocity: Array) -> Array:
    """Gradients (m, p) along moving points from Jacobians (m, 1 + p) in (phi, x)."""
    total: Array = slopes[:, 1:] + slopes[:, :1] * velocity
    return total


def hessians_along(slopes: Array, second: Array, motion: PointMotion) -> Array:
    """Hessians (m, p, p) along moving points from Jacobians (m, 1 + p) and Hessians (m, 1 + p, 1 + p) in (phi, x)."""
    mixed = second[:, 1:, :1] * motion.velocity[:, None, :]
    squared = motion.velocity[:, :, None] * motion.velocity[:, None, :]
    total: Array = second[:, 1:, 1:] + mixed + mixed.transpose(0, 2, 1) + second[:, :1, :1] * squared
    return total + slopes[:, :1, None] * motion.acceleration


def peak_velocity(second: Array) -> Array:
    """Velocity (m, p) of smooth peaks from Hessians (m, 1 + p, 1 + p): -F_phix / F_phiphi."""
    velocity: Array = -second[:, 0, 1:] / second[:, :1, 0]
    return velocity


def fixed_motion(count: int, size: int) -> PointMotion:
    """Points that stand still."""
    return PointMotion(np.zeros((count, size)), np.zeros((count, size, size)))
