"""A closed curve F(phi, x), such as a force over a machine's turn, with exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca

from planter.kernels import Array


@dataclass(frozen=True)
class Event:
    """A kind of joint: the curve is smooth in (phi, x) except where g(phi, x) is a whole multiple of `period`.

    `period` None: where g = 0. `order` is the order of the first derivative of F in phi that jumps there: 1 or 2, or 0
    if F itself jumps, which can be looked at but not optimised.
    """

    name: str
    order: int
    period: float | None


@dataclass(frozen=True)
class Compiled:
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


class Response(Protocol):
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
    def events(self) -> tuple[Event, ...]: ...

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

    def compiled(self, angles: int) -> Compiled | None:
        """Return the response over so many angles without Python, or None if it is not all compiled."""
