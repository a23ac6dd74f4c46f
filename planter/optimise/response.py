"""A closed curve F(phi, x), such as a force over a machine's turn, with exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca

from planter.kernels import Array


@dataclass(frozen=True)
class Event:
    """A kind of joint: the force is smooth in (phi, x) but where g(phi, x) is a whole multiple of `period`.

    `period` None: where g = 0. `order` is the order of the first derivative of F in phi that jumps there: 1 or 2, or 0
    where F itself jumps, which can be looked at but not optimised.
    """

    name: str
    order: int
    period: float | None


@dataclass(frozen=True)
class Compiled:
    """A response over n angles as compiled functions, for the use in CasADi's graphs; it has constants c.

    The force is a sum of equal shares: F(phi) is that of `force` at phi + each of `offsets` [rad], its lanes.
    """

    constants: Array
    offsets: tuple[float, ...]
    prologue: ca.Function
    """(x, c) -> h, dh: what no angle changes, and its sparse Jacobian in x."""
    curvature: ca.Function
    """(x, c, weights) -> Hessian (p, p) of weights . h in x."""
    force: ca.Function
    """(phi, x, c, h) -> the share of each lane."""
    slopes: ca.Function
    """(phi, x, c, h, dh) -> shares, and their Jacobian in (phi, x)."""
    bending: ca.Function
    """(phi, x, c, h, dh, weights) -> weighted sum of the Hessians in (phi, x), packed, and the weighted slope in h."""


class Response(Protocol):
    """A force F(phi, x) [N], continuous, periodic in phi with `period` [rad]; designs x are (p,), angles (n,).

    `prologue` does once for a design what no angle changes; its result is handed to all the rest as `at`.
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
    def events(self) -> tuple[Event, ...]: ...

    def prologue(self, x: Array) -> Any: ...

    def support(self, at: Any, phi: Array) -> Array:
        """F, (n,)."""

    def support_rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """F and its derivative in phi, (n,) each."""

    def support_rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """First and second derivative of F in phi, (n,) each."""

    def support_slopes(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """F, (n,), and its Jacobian in (phi, x), (n, 1 + p)."""

    def support_hessian(self, at: Any, phi: Array, weights: Array) -> Array:
        """Weighted sum over the angles of the Hessian of F in (phi, x), (1 + p, 1 + p)."""

    def support_hessians(self, at: Any, phi: Array) -> Array:
        """Hessian of F in (phi, x) at each angle, (n, 1 + p, 1 + p)."""

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """g of every event and its derivative in phi, (k, n) each."""

    def event_slopes(self, at: Any, phi: Array) -> Array:
        """Jacobian of g in (phi, x), (k, n, 1 + p)."""

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        """Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""

    def compiled(self, angles: int) -> Compiled | None:
        """The response over so many angles without Python; None where it is not all compiled."""
