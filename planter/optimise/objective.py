"""Rows and a smooth function: what objectives offer to the optimisers and to the certificate.

The maximum is the largest of some rows, the minimum the least of others, and a smooth function stands beside them: of a
turn of a response it is the variance.

What a problem makes small: a weighted range of rows, if it has any, and what it makes of a smooth function.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from planter.kernels import Array
from planter.numerics.arrays import Flags


@dataclass(frozen=True)
class ObjectiveSummary:
    """The smooth function at a design, the extremes of all rows there and a level between these.

    Of a turn of a response they are variance, extremes and mean; where there are no rows, the extremes are those of
    the empty set and the range is 0.
    """

    smooth: float
    high: float = -math.inf
    low: float = math.inf
    mean: float = math.nan

    @classmethod
    def at(cls, values: Array) -> ObjectiveSummary:
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
class ModelValues:
    """The smooth function, the rows that bound the maximum (a,) and the minimum (b,), what is held in bounds (k,)."""

    smooth: float
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class ModelGradients:
    """Gradients in the design of what `Values` holds: (p,), (a, p), (b, p), (k, p)."""

    smooth: Array
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class BreakpointHold:
    """Keeps a joint, psi, of an event: low <= psi(x) - phi_sample <= high [rad]. A pin if both are 0, else a wall."""

    sample: int
    event: int
    low: float = 0.0
    high: float = 0.0

    @property
    def pin(self) -> bool:
        return self.low == self.high == 0.0


class LocalModel(Protocol):
    """Functions of the design that are smooth near one: a fixed set of rows.

    `bounds` (2, k) are those of the values' `holds`.
    """

    @property
    def bounds(self) -> Array: ...

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def grown(self, x: Array, high: float, low: float) -> LocalModel:
        """With the rows that are missing if those at x are to stay within [low, high]."""

    def values(self, x: Array) -> ModelValues:
        """Return the values of the smooth function, rows and holds at a design x (p,)."""

    def slopes(self, x: Array) -> ModelGradients:
        """Return the gradients of the smooth function, rows and holds at a design x (p,)."""

    def curvature(self, x: Array, weights: ModelValues) -> Array:
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


class CycleEvaluation(Protocol):
    """A way to take a turn of a response: its samples, or its true extremes and integrals. Designs x (p,) in SI."""

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""


@dataclass(frozen=True)
class ObjectiveEvaluation:
    """The objective at a design, and what it is made of."""

    objective: float
    look: ObjectiveSummary


class Kinks(Protocol):
    """Where an objective has kinks: joints that pass its rows, to be kept on one side of them or on the kink."""

    def find_pins(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Return the pins of the nearest breakpoints with their distances from the samples [rad]."""

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """Return the hold which keeps the breakpoint of a pin on the side given by its distance."""


class Objective(Protocol):
    """weight * (largest upper row - least lower row) + outer(a smooth function), over designs x (p,).

    `unit` is what counts as one in residuals and tolerances; None: its value at the design to start from. `felt` (p,)
    marks the parameters that it feels at all. `windows` says that its rows move with the design, so that none of them
    serves a whole descent. `kinks` is None where it is smooth but for its rows.
    """

    @property
    def weight(self) -> float: ...
    @property
    def unit(self) -> float | None: ...
    @property
    def felt(self) -> Flags: ...
    @property
    def windows(self) -> bool: ...
    @property
    def kinks(self) -> Kinks | None: ...

    def outer(self, smooth: float) -> tuple[float, float, float]:
        """What the smooth function's value adds to the objective, with first and second derivative."""

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """The objective near a design, joints held as told."""

    def conditions(self, x: Array) -> Conditions:
        """First-order data at a design; gradients in the design."""

    def flat(self, x: Array) -> Array:
        """Directions (k, p) in the design that the objective does not feel at one, to first order."""


def evaluate_summary(objective: Objective, look: ObjectiveSummary) -> ObjectiveEvaluation:
    """What an objective makes of a look at a design."""
    return ObjectiveEvaluation(objective.weight * look.range + objective.outer(look.smooth)[0], look)
