"""Rows and a smooth function: what objectives offer to the optimisers and to the certificate.

The maximum is the largest of some rows, the minimum the least of others, and a smooth function stands beside them: of a
turn of a response it is the variance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from planter.kernels import Array


@dataclass(frozen=True)
class Look:
    """The smooth function at a design, the extremes of all rows there and a level between these.

    Of a turn of a response they are variance, extremes and mean; where there are no rows, the extremes are those of
    the empty set and the range is 0.
    """

    smooth: float
    high: float = -math.inf
    low: float = math.inf
    mean: float = math.nan

    @classmethod
    def at(cls, values: Array) -> Look:
        """Of samples (n,) of a turn."""
        return cls(float(values.var()), float(values.max()), float(values.min()), float(values.mean()))

    @property
    def range(self) -> float:
        return max(self.high - self.low, 0.0)

    @property
    def variance(self) -> float:
        """The smooth function of a turn: the population variance of the response."""
        return self.smooth


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


class Local(Protocol):
    """Functions of the design that are smooth near one: a fixed set of rows.

    `bounds` (2, k) are those of the values' `holds`.
    """

    @property
    def bounds(self) -> Array: ...

    def look(self, x: Array) -> Look: ...

    def grown(self, x: Array, high: float, low: float) -> Local:
        """With the rows that are missing if those at x are to stay within [low, high]."""

    def values(self, x: Array) -> Values: ...

    def slopes(self, x: Array) -> Slopes: ...

    def curvature(self, x: Array, weights: Values) -> Array:
        """Weighted sum (p, p) of the Hessians of all that `values` gives."""


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
