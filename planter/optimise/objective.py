"""Interfaces of objectives: a weighted range of components plus a function of a smooth value.

The range is the maximum of the upper components minus the minimum of the lower ones. For a response over a cycle, the
components are its extremes or samples, and the smooth value is the variance.
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
    """Smooth value, extremes of all components, and mean at a design.

    For a response over a cycle the smooth value is the variance. Without components the extremes are those of the empty
    set and the range is 0.
    """

    smooth: float
    high: float = -math.inf
    low: float = math.inf
    mean: float = math.nan

    @classmethod
    def at(cls, values: Array) -> ObjectiveSummary:
        """Return the summary of samples (n,) of a cycle."""
        return cls(float(values.var()), float(values.max()), float(values.min()), float(values.mean()))

    @property
    def range(self) -> float:
        return max(self.high - self.low, 0.0)

    @property
    def variance(self) -> float:
        """Smooth value of a cycle: the population variance of the response."""
        return self.smooth


@dataclass(frozen=True)
class ModelValues:
    """Smooth value, components of the maximum (a,) and of the minimum (b,), and bounded functions (k,)."""

    smooth: float
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class ModelGradients:
    """Gradients of `ModelValues` in the design: (p,), (a, p), (b, p), (k, p)."""

    smooth: Array
    upper: Array
    lower: Array
    holds: Array


@dataclass(frozen=True)
class BreakpointHold:
    """Constraint low <= psi(x) - phi_sample <= high [rad] on a breakpoint psi: a pin if both are 0, else a wall."""

    sample: int
    event: int
    low: float = 0.0
    high: float = 0.0

    @property
    def pin(self) -> bool:
        return self.low == self.high == 0.0


class LocalModel(Protocol):
    """Functions that are smooth near a design, with a fixed set of components.

    `bounds` (2, k) are the lower and upper bounds of the `holds` of the values.
    """

    @property
    def bounds(self) -> Array: ...

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def grown(self, x: Array, high: float, low: float) -> LocalModel:
        """Return a copy which also has the components that are outside [low, high] at x (p,)."""

    def values(self, x: Array) -> ModelValues:
        """Return the values of the smooth function, rows and holds at a design x (p,)."""

    def slopes(self, x: Array) -> ModelGradients:
        """Return the gradients of the smooth function, rows and holds at a design x (p,)."""

    def curvature(self, x: Array, weights: ModelValues) -> Array:
        """Return the weighted sum (p, p) of the Hessians of all `values`."""


@dataclass(frozen=True)
class Conditions:
    """First-order data of all components, active or not, and all kinks at a design.

    The largest of `upper` (a,) is the maximum and the smallest of `lower` (b,) the minimum, with gradients (a, p) and
    (b, p). A sample at a breakpoint is listed twice, with the gradients of both sides. `smooth` (p,) is the gradient of
    the smooth value with all such samples on the first side; `kinks` (k, p) are the changes on the second side.
    """

    upper: Array
    upper_gradients: Array
    lower: Array
    lower_gradients: Array
    smooth: Array
    kinks: Array


class CycleEvaluation(Protocol):
    """Evaluation of a response over a cycle, by samples or by continuous extrema and integrals."""

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""


@dataclass(frozen=True)
class ObjectiveEvaluation:
    """The objective at a design and the summary from which it is computed."""

    objective: float
    look: ObjectiveSummary


class Kinks(Protocol):
    """Points of a sampled objective without a gradient, where breakpoints pass samples."""

    def find_pins(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Return the pins of the nearest breakpoints with their distances from the samples [rad]."""

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """Return the hold which confines the breakpoint of a pin to the side of its distance [rad]."""


class Objective(Protocol):
    """Objective weight * (largest upper - smallest lower component) + outer(smooth value), over designs x (p,).

    `unit` is the unit of residuals and tolerances, None for the value at the initial design. `felt` (p,) marks the
    parameters that affect the objective. `windows` is true if the components move with the design, so that a set of
    them does not serve a complete local search. `kinks` is None if components and smooth value are differentiable.
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
        """Return the contribution of the smooth value to the objective, with first and second derivative."""

    def look(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the local model near a design x (p,), with breakpoints constrained by `holds`."""

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,), with gradients in the design."""

    def flat(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first order."""


def evaluate_summary(objective: Objective, look: ObjectiveSummary) -> ObjectiveEvaluation:
    """Return the evaluation of an objective from its summary at a design."""
    return ObjectiveEvaluation(objective.weight * look.range + objective.outer(look.smooth)[0], look)
