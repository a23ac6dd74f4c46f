"""What the two ways to take a turn, samples and true extremes, offer to the optimisers and to the certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from planter.kernels import Array


@dataclass(frozen=True)
class Look:
    """Extremes [N], mean [N] and population variance [N2] of the force over a turn."""

    high: float
    low: float
    mean: float
    variance: float

    @classmethod
    def at(cls, force: Array) -> Look:
        """Of samples (n,)."""
        return cls(float(force.max()), float(force.min()), float(force.mean()), float(force.var()))


@dataclass(frozen=True)
class Values:
    """Variance, the force in the rows that bound the maximum (a,) and the minimum (b,), what is held in bounds (k,)."""

    variance: float
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class Slopes:
    """Gradients in the design of what `Values` holds: (p,), (a, p), (b, p), (k, p)."""

    variance: Array
    upper: Array
    lower: Array
    holds: Array


class Local(Protocol):
    """The force over a turn near a design, as functions that are smooth there: a fixed set of rows.

    `bounds` (2, k) are those of the values' `holds`.
    """

    @property
    def bounds(self) -> Array: ...

    def look(self, x: Array) -> Look: ...

    def grown(self, x: Array, high: float, low: float) -> Local:
        """With the rows that are missing if the force at x is to stay within [low, high] [N]."""

    def values(self, x: Array) -> Values: ...

    def slopes(self, x: Array) -> Slopes: ...

    def curvature(self, x: Array, weights: Values) -> Array:
        """Weighted sum (p, p) of the Hessians of all that `values` gives."""


@dataclass(frozen=True)
class Conditions:
    """First-order data of a turn at a design, complete: every row, active or not, and every kink.

    `upper` (a,) and `lower` (b,) are values whose largest and least are the maximum and the minimum [N], with gradients
    (a, p), (b, p). A sample that sits on a joint stands twice, with the gradient of either side. `variance` (p,) is the
    gradient of the variance with every such sample taken on the first side, `kinks` (k, p) what each adds on the other.
    """

    upper: Array
    upper_gradients: Array
    lower: Array
    lower_gradients: Array
    variance: Array
    kinks: Array


class Turn(Protocol):
    """A way to take a turn of the force: its samples, or its true extremes and integrals. Designs x (p,) in SI."""

    def look(self, x: Array) -> Look: ...

    def local(self, x: Array) -> Local: ...

    def conditions(self, x: Array) -> Conditions: ...
