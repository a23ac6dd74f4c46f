"""Rows and a smooth function: what objectives offer to the optimisers and to the certificate.

The maximum is the largest of some rows, the minimum the least of others, and a smooth function stands beside them: of a
turn of a response it is the variance, and an objective makes of it what it likes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from planter.kernels import Array


@dataclass(frozen=True)
class Look:
    """Extremes, mean and population variance of a response over a turn; without one, the extremes of no rows."""

    high: float = -math.inf
    low: float = math.inf
    mean: float = math.nan
    variance: float = math.nan

    @classmethod
    def at(cls, force: Array) -> Look:
        """Of samples (n,)."""
        return cls(float(force.max()), float(force.min()), float(force.mean()), float(force.var()))

    @property
    def range(self) -> float:
        return self.high - self.low


@dataclass(frozen=True)
class Values:
    """The smooth function, the rows that bound the maximum (a,) and the minimum (b,), what is held in bounds (k,)."""

    smooth: float
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class Slopes:
    """Gradients in the design of what `Values` holds: (p,), (a, p), (b, p), (k, p)."""

    smooth: Array
    upper: Array
    lower: Array
    holds: Array


class Functions(Protocol):
    """Functions of the design that are smooth near one: a fixed set of rows.

    `bounds` (2, k) are those of the values' `holds`.
    """

    @property
    def bounds(self) -> Array: ...

    def values(self, x: Array) -> Values: ...

    def slopes(self, x: Array) -> Slopes: ...

    def curvature(self, x: Array, weights: Values) -> Array:
        """Weighted sum (p, p) of the Hessians of all that `values` gives."""


class Rows(Functions, Protocol):
    """A turn of a response near a design, its variance the smooth function."""

    def look(self, x: Array) -> Look: ...

    def grown(self, x: Array, high: float, low: float) -> Rows:
        """With the rows that are missing if the response at x is to stay within [low, high]."""


@dataclass(frozen=True)
class Conditions:
    """First-order data at a design, complete: every row, active or not, and every kink.

    `upper` (a,) and `lower` (b,) are values whose largest and least are the maximum and the minimum, with gradients
    (a, p), (b, p). A sample that sits on a joint stands twice, with the gradient of either side. `smooth` (p,) is the
    gradient of the smooth function with every such sample taken on the first side, `kinks` (k, p) what each adds on
    the other.
    """

    upper: Array
    upper_gradients: Array
    lower: Array
    lower_gradients: Array
    smooth: Array
    kinks: Array


class Turn(Protocol):
    """A way to take a turn of a response: its samples, or its true extremes and integrals. Designs x (p,) in SI."""

    def look(self, x: Array) -> Look: ...

    def conditions(self, x: Array) -> Conditions: ...
