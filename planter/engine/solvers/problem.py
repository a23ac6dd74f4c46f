"""Optimisation problem in the variables of its box, with the counts and the best point of a
search.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from planter.engine.solvers.constraints import (
    FEASIBILITY_TOLERANCE,
    ConstrainedModel,
    Constraints,
    DesignBox,
    project_onto_equations,
)
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    LocalModel,
    Objective,
    ObjectiveEvaluation,
    ObjectiveSummary,
    evaluate_summary,
)
from planter.errors import ComputationError
from planter.kernels import Array, Integers

DIRECTION_TOLERANCE = 1e-6
"""Components of a direction below this count as zero."""
SPREAD_SHARE = 1e-3
"""Share of the spreads of its rows that the unit of an objective is at least, whose initial value
may cancel to 0.
"""
MAX_VIOLATION = 1e3
"""Upper limit of the violation in a merit, in steps."""


@dataclass
class Counts:
    """Numbers of evaluations of the objective, its gradient and its Hessian."""

    objective: int = 0
    gradient: int = 0
    hessian: int = 0

    @property
    def total(self) -> int:
        return self.objective + self.gradient + self.hessian

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            self.objective + other.objective,
            self.gradient + other.gradient,
            self.hessian + other.hessian,
        )


@dataclass(frozen=True)
class BestPoint:
    """A point u (p,) and its objective."""

    u: Array
    objective: float


@dataclass(frozen=True)
class ClosestPoint:
    """A point u (p,) and its largest violation of a constraint, in steps; `constraint` names that
    one if it is known.
    """

    u: Array
    violation: float
    constraint: str = ""


@dataclass
class Problem:
    """An objective within a box.

    Without `constraints`, parameters that do not affect the objective are not searched: they have
    the values of the initial design, clipped to the box. `free` (f,) holds the indices of the
    parameters that are searched. Points u are (p,). `best` is the best feasible point evaluated so
    far and `history` lists the improvements: (number of evaluations, objective); while there is
    none, `closest` is the point that violates the constraints least. `heard` is called with the
    best objective so far after each evaluation.
    """

    objective: Objective
    box: DesignBox
    constraints: Constraints | None = None
    counts: Counts = field(default_factory=Counts)
    best: BestPoint | None = None
    history: list[tuple[int, float]] = field(default_factory=list)
    closest: ClosestPoint | None = None
    heard: Callable[[float | None], None] | None = None

    most_iterations: ClassVar[int] = 60
    """Maximum number of iterations of each run of a local search."""

    def anew(self) -> Self:
        """Return a copy without counts, best and closest point, and history."""
        fresh = copy.copy(self)
        fresh.counts, fresh.best, fresh.history, fresh.heard, fresh.closest = (
            Counts(),
            None,
            [],
            None,
            None,
        )
        return fresh

    def with_box(self, lower: Array, upper: Array, u: Array) -> Self:
        """Return a copy within other bounds (p,) on designs, whose initial design is that at a
        point u (p,) of this one.
        """
        other = self.anew()
        other.box = DesignBox.shares(self.box.names, lower, upper, self.design(u))
        return other

    def restart(self) -> None:
        """Discard the state of earlier evaluations, so that the next one does not depend on them to
        the last digit.
        """

    def absorb(
        self,
        counts: Counts,
        best: BestPoint | None,
        history: Sequence[tuple[int, float]],
        closest: ClosestPoint | None,
    ) -> None:
        """Append the counts, best point, history and closest point of a copy of this problem to its
        own.
        """
        before, best_objective = self.counts.total, self.best_objective
        self.history += [
            (before + n, value)
            for n, value in history
            if best_objective is None or value < best_objective
        ]
        self.counts = self.counts + counts
        if best is not None and (best_objective is None or best.objective < best_objective):
            self.best = best
        if closest is not None and (
            self.closest is None or closest.violation < self.closest.violation
        ):
            self.closest = closest

    @property
    def start(self) -> Array:
        """Point (p,) of the initial design."""
        return self.box.start

    @cached_property
    def free(self) -> Integers:
        """Indices of the parameters that are searched, (f,)."""
        if self.constraints is not None:
            return np.arange(len(self.box.names))
        return np.flatnonzero(self.objective.sensitive)

    def design(self, u: Array) -> Array:
        """Return the design x (p,) at a point u (p,) of the box."""
        return self.box.at(u)

    def point(self, free: Array) -> Array:
        """Return the point u (p,) with the free coordinates `free` (f,)."""
        u = self.start.copy()
        u[self.free] = free
        return u

    @property
    def independent(self) -> Integers:
        """Free coordinates (i,) that starts and individuals vary; `complete` sets the others."""
        return self.free

    def complete(self, u: Array) -> Array:
        """Return a point (p,) with the same independent coordinates and the best values of the
        others.
        """
        return u

    def interpolate(self, shares: Array) -> Array:
        """Return the point (p,) at shares (i,) of the way from the lower to the upper independent
        bounds.
        """
        chosen, u = self.independent, self.start.copy()
        bottom, top = self.box.bottom[chosen], self.box.top[chosen]
        u[chosen] = bottom + shares * (top - bottom)
        return self.complete(u)

    @cached_property
    def equations(self) -> Constraints | None:
        """Equality constraints, or None without any."""
        return None if self.constraints is None else self.constraints.equations

    def onto(self, u: Array) -> Array:
        """Return the projection (p,) of a point u (p,) onto the equality constraints, within the
        box.
        """
        return u if self.equations is None else project_onto_equations(self.box, self.equations, u)

    def local(self, u: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the smooth local model of objective and constraints, with breakpoints constrained
        by `holds`.
        """
        x = self.design(u)
        model = self.objective.local(x, holds)
        return (
            model if self.constraints is None else ConstrainedModel(model, self.constraints.at(x))
        )

    def violation(self, u: Array) -> float:
        """Return the largest violation of a constraint at a point in steps, 0 if all are
        satisfied.
        """
        return 0.0 if self.constraints is None else self.constraints.violation(self.design(u))

    def is_feasible(self, u: Array) -> bool:
        """Return whether a point u (p,) satisfies all constraints."""
        return self.violation(u) <= FEASIBILITY_TOLERANCE

    def merit(self, u: Array) -> float:
        """Return the objective, and one unit more for each step of the worst violation; inf without
        an objective.
        """
        try:
            objective = self.evaluate(u).objective
        except ComputationError:
            return math.inf
        return objective + (
            min(self.violation(u), MAX_VIOLATION) * self.scale if self.constraints else 0.0
        )

    def merits(self, points: Sequence[Array]) -> Array:
        """Return the merits (n,) of the points (p,) of a population."""
        return np.array([self.merit(u) for u in points])

    def evaluate(self, u: Array) -> ObjectiveEvaluation:
        """Return the objective at a point u (p,) and count the evaluation."""
        self.counts.objective += 1
        return self.record(u, self.objective.summarise(self.design(u)))

    def record(self, u: Array, summary: ObjectiveSummary) -> ObjectiveEvaluation:
        """Return the objective at a point u (p,) from its summary, and record the point if it is
        the best so far.
        """
        evaluation = evaluate_summary(self.objective, summary)
        if self.best is None or evaluation.objective < self.best.objective:
            violation = self.violation(u)
            if violation <= FEASIBILITY_TOLERANCE:
                self.best = BestPoint(u.copy(), evaluation.objective)
                self.history.append((self.counts.total, evaluation.objective))
            else:
                self._keep_closest(u, violation)
        if self.heard is not None:
            self.heard(self.best_objective)
        return evaluation

    def record_violation(self, u: Array, violation: float, constraint: str = "") -> None:
        """Record a point u (p,) by the largest violation of a constraint alone, in steps, 0 if all
        are satisfied; `constraint` names that one.
        """
        self._keep_closest(u, violation, constraint)
        if self.heard is not None:
            self.heard(self.best_objective)

    def _keep_closest(self, u: Array, violation: float, constraint: str = "") -> None:
        if self.best is not None or not math.isfinite(violation):
            return
        if self.closest is None or violation < self.closest.violation:
            self.closest = ClosestPoint(u.copy(), violation, constraint)

    @property
    def best_objective(self) -> float | None:
        """Best objective so far, or None."""
        return None if self.best is None else self.best.objective

    def score(self, x: Array) -> ObjectiveEvaluation:
        """Return the objective of a design x (p,) without counting or recording it."""
        return evaluate_summary(self.objective, self.objective.summarise(x))

    @cached_property
    def reference(self) -> ObjectiveEvaluation:
        """Evaluation of the initial design."""
        return self.score(self.box.design)

    @property
    def scale(self) -> float:
        """Unit of the objective in residuals and tolerances."""
        if self.objective.unit is not None:
            return self.objective.unit
        spreads = float(np.abs(self.objective.weights) @ self.objective.units)
        return max(abs(self.reference.objective), SPREAD_SHARE * spreads) or 1.0

    def null_space(self, u: Array) -> Array:
        """Return orthonormal insensitive directions (k, p) of the free coordinates at a point u
        (p,).
        """
        directions = self.objective.null_space(self.design(u)) / self.box.unit
        fixed = np.setdiff1d(np.arange(len(u)), self.free)
        if not len(directions) or not len(fixed):
            return np.linalg.qr(directions.T)[0].T
        _, sizes, right = np.linalg.svd(directions[:, fixed].T)
        restricted = right[int((sizes > DIRECTION_TOLERANCE).sum()) :] @ directions
        return np.linalg.qr(restricted.T)[0].T

    def conditions(self, u: Array) -> Conditions:
        """Return first-order data at a point u (p,), with gradients in u."""
        conditions = self.objective.conditions(self.design(u))
        return replace(
            conditions,
            gradients=conditions.gradients * self.box.unit,
            smooth=conditions.smooth * self.box.unit,
            kinks=conditions.kinks * self.box.unit,
        )
