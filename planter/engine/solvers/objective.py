"""Interfaces of objectives: a smooth function plus the weighted largest rows of groups.

    f(x) = smooth(x) + sum_g weight_g max_i row_gi(x)

A greatest value of a curve is a group whose rows are its peaks, a least value one whose rows are
its valleys with the opposite sign, a range is both, and the greatest size of a curve one group of
peaks and of valleys.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from planter.kernels import Array, Flags, Integers

NO_ROWS: Array = np.empty(0)
NO_GROUPS: Integers = np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class ObjectiveSummary:
    """Smooth value and largest row of each group (g,) at a design."""

    smooth: float
    tops: Array = field(default_factory=lambda: NO_ROWS)


@dataclass(frozen=True)
class BreakpointHold:
    """Constraint low <= psi(x) - phi_sample <= high [rad] on a breakpoint psi: a pin if both are 0,
    else a wall.
    """

    sample: int
    event: int
    low: float = 0.0
    high: float = 0.0

    @property
    def pin(self) -> bool:
        return self.low == self.high == 0.0


class LocalModel(Protocol):
    """Functions that are smooth near a design: the smooth value, a fixed set of rows, and holds.

    `groups` (r,) are the groups of the rows, `bounds` (2, k) the lower and upper bounds of the
    holds: there are n = 1 + r + k functions.
    """

    @property
    def groups(self) -> Integers: ...
    @property
    def bounds(self) -> Array: ...

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def extended(self, x: Array, tops: Array) -> LocalModel:
        """Return a copy which also has the rows that exceed the tops (g,) of their groups at x
        (p,).
        """

    def values(self, x: Array) -> Array:
        """Return the functions (n,) at a design x (p,)."""

    def slopes(self, x: Array) -> Array:
        """Return their gradients (n, p) at a design x (p,)."""

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (n,)."""


@dataclass(frozen=True)
class Conditions:
    """First-order data of all rows (r,), active or not, with groups (r,) and gradients (r, p), and
    of all kinks.

    A sample at a breakpoint is listed twice, with the gradients of both sides. `smooth` (p,) is the
    gradient of the smooth value with all such samples on the first side; `kinks` (k, p) are the
    changes on the second side.
    """

    rows: Array
    groups: Integers
    gradients: Array
    smooth: Array
    kinks: Array


@dataclass(frozen=True)
class ObjectiveEvaluation:
    """The objective at a design and the summary from which it is computed."""

    objective: float
    summary: ObjectiveSummary


class Kinks(Protocol):
    """Points of a sampled objective without a gradient, where breakpoints pass samples."""

    def find_pins(self, x: Array) -> list[tuple[BreakpointHold, float]]:
        """Return the pins of the nearest breakpoints with their distances from the samples
        [rad].
        """

    def wall(self, pin: BreakpointHold, distance: float) -> BreakpointHold:
        """Return the hold which confines the breakpoint of a pin to the side of its distance
        [rad].
        """


class ObjectivePart(Protocol):
    """Part of an objective of designs x (p,): smooth + weights (g,) . largest rows of the groups.

    `units` (g,) are what counts as one in the rows. `windows` is true if the rows move with the
    design, so that a set of them does not serve a complete local search. `kinks` is None if all is
    differentiable.
    """

    @property
    def weights(self) -> Array: ...
    @property
    def units(self) -> Array: ...
    @property
    def windows(self) -> bool: ...
    @property
    def kinks(self) -> Kinks | None: ...

    def restart(self) -> None:
        """Forget all designs so far, on which the last digits may depend."""

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the local model near a design x (p,), with breakpoints constrained by `holds`."""

    def coarse(self, x: Array) -> LocalModel | None:
        """Return the local model over few samples, all of them rows, None if there is none."""

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,), with gradients in the design."""


class Objective(ObjectivePart, Protocol):
    """A whole objective.

    `unit` is that of residuals and tolerances, None for the value at the initial design.
    `sensitive` (p,) marks the parameters that affect the objective.
    """

    @property
    def unit(self) -> float | None: ...
    @property
    def sensitive(self) -> Flags: ...

    def null_space(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first
        order.
        """


def find_tops(rows: Array, groups: Integers, count: int) -> Array:
    """Return the largest row of each of `count` groups, (g,)."""
    tops = np.full(count, -np.inf)
    np.maximum.at(tops, groups, rows)
    return tops


def evaluate_summary(objective: Objective, summary: ObjectiveSummary) -> ObjectiveEvaluation:
    """Return the evaluation of an objective from its summary at a design."""
    return ObjectiveEvaluation(float(objective.weights @ summary.tops) + summary.smooth, summary)


def find_gradient(objective: Objective, x: Array) -> Array:
    """Return the gradient (p,) of an objective at a design; a largest value that rows share has
    that of the first.
    """
    conditions = objective.conditions(x)
    gradient = conditions.smooth.copy()
    for group, weight in enumerate(objective.weights):
        rows = np.flatnonzero(conditions.groups == group)
        if len(rows):
            gradient += weight * conditions.gradients[rows[conditions.rows[rows].argmax()]]
    return gradient


def find_hessian(objective: Objective, x: Array) -> Array:
    """Return the Hessian (p, p) of an objective at a design, with the largest rows as they are
    there.
    """
    local = objective.local(x)
    values = local.values(x)
    weights = np.append(1.0, np.zeros(len(values) - 1))
    for group, weight in enumerate(objective.weights):
        rows = 1 + np.flatnonzero(local.groups == group)
        weights[rows[values[rows].argmax()]] = weight
    return local.curvature(x, weights)
