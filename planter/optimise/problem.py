"""The optimisation problem in the variables of its box, with what a search has met so far."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.constraints import (
    FEASIBILITY_TOLERANCE,
    ConstrainedModel,
    Constraints,
    DesignBox,
    project_onto_equations,
)
from planter.optimise.objective import (
    BreakpointHold,
    Conditions,
    LocalModel,
    Objective,
    ObjectiveEvaluation,
    ObjectiveSummary,
    evaluate_summary,
)

DIRECTION_TOLERANCE = 1e-6
"""Part of a direction that counts as none of it."""
MAX_VIOLATION = 1e3
"""Violations above this many steps are all as bad."""


@dataclass
class Counts:
    """How often the objective was evaluated: its value, its gradient, its Hessian."""

    objective: int = 0
    gradient: int = 0
    hessian: int = 0

    @property
    def total(self) -> int:
        return self.objective + self.gradient + self.hessian

    def __add__(self, other: Counts) -> Counts:
        return Counts(self.objective + other.objective, self.gradient + other.gradient, self.hessian + other.hessian)


@dataclass(frozen=True)
class BestPoint:
    """A point u (p,) and its objective."""

    u: Array
    objective: float


@dataclass
class Problem:
    """An objective within a box.

    Parameters that the objective does not feel are not searched: they keep the values of the design to start from,
    taken into the box. `free` (f,) holds the indices of the others; searches run over those. With `constraints` all are
    searched. Points u are (p,). `best` is the best point met so far that keeps the constraints, `history` when each
    best was met: (evaluations, objective). `heard` is told the least objective so far at every point that is met.
    """

    objective: Objective
    box: DesignBox
    constraints: Constraints | None = None
    counts: Counts = field(default_factory=Counts)
    best: BestPoint | None = None
    history: list[tuple[int, float]] = field(default_factory=list)
    heard: Callable[[float | None], None] | None = None

    most_iterations: ClassVar[int] = 60
    """Most iterations of each run of a descent."""

    def anew(self) -> Self:
        """Return the same problem, nothing met yet."""
        fresh = copy.copy(self)
        fresh.counts, fresh.best, fresh.history, fresh.heard = Counts(), None, [], None
        return fresh

    def restart(self) -> None:
        """Forget all designs so far: what is evaluated next does not depend on them, to the last digit."""

    def absorb(self, counts: Counts, best: BestPoint | None, history: Sequence[tuple[int, float]]) -> None:
        """Count as met here, after all else, what the same problem has met anew."""
        before, least = self.counts.total, self.least
        self.history += [(before + n, value) for n, value in history if least is None or value < least]
        self.counts = self.counts + counts
        if best is not None and (least is None or best.objective < least):
            self.best = best

    @property
    def start(self) -> Array:
        """The point (p,) of the design to start from."""
        return self.box.start

    @cached_property
    def free(self) -> Integers:
        if self.constraints is not None:
            return np.arange(len(self.box.names))
        return np.flatnonzero(self.objective.felt)

    def design(self, u: Array) -> Array:
        """The design x (p,) at a point of the box."""
        return self.box.at(u)

    def point(self, free: Array) -> Array:
        """The point u (p,) with the given free coordinates (f,)."""
        u = self.start.copy()
        u[self.free] = free
        return u

    @property
    def independent(self) -> Integers:
        """The free coordinates (i,) that starts and individuals choose; `complete` sets the others."""
        return self.free

    def complete(self, u: Array) -> Array:
        """Return a point (p,) with the same independent coordinates, the others as good as they can be."""
        return u

    def within(self, shares: Array) -> Array:
        """Return the point (p,) at shares (i,) of the way from the lower to the upper independent bounds."""
        chosen, u = self.independent, self.start.copy()
        bottom, top = self.box.bottom[chosen], self.box.top[chosen]
        u[chosen] = bottom + shares * (top - bottom)
        return self.complete(u)

    @cached_property
    def equations(self) -> Constraints | None:
        """What of the constraints is equations; None where nothing is."""
        return None if self.constraints is None else self.constraints.equations

    def onto(self, u: Array) -> Array:
        """The point (p,) of the box beside a point u (p,) that keeps the equations to rounding, if one does."""
        return u if self.equations is None else project_onto_equations(self.box, self.equations, u)

    def local(self, u: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """The objective near a point as smooth functions, joints held as told, with the rows of the constraints."""
        found = self.objective.local(self.design(u), holds)
        return found if self.constraints is None else ConstrainedModel(found, self.constraints)

    def violation(self, u: Array) -> float:
        """By how many steps the worst constraint is violated at a point, 0 where all are kept."""
        return 0.0 if self.constraints is None else self.constraints.violation(self.design(u))

    def is_feasible(self, u: Array) -> bool:
        """Return whether a point u (p,) satisfies all constraints."""
        return self.violation(u) <= FEASIBILITY_TOLERANCE

    def merit(self, u: Array) -> float:
        """Return the objective, and one unit more for each step of the worst violation; inf without an objective."""
        try:
            objective = self.evaluate(u).objective
        except ComputationError:
            return math.inf
        return objective + (min(self.violation(u), MAX_VIOLATION) * self.scale if self.constraints else 0.0)

    def evaluate(self, u: Array) -> ObjectiveEvaluation:
        """The objective at a point."""
        self.counts.objective += 1
        return self.met(u, self.objective.look(self.design(u)))

    def met(self, u: Array, look: ObjectiveSummary) -> ObjectiveEvaluation:
        """The objective of a point that was looked at on the way, kept if it is the best so far."""
        found = evaluate_summary(self.objective, look)
        if (self.best is None or found.objective < self.best.objective) and self.is_feasible(u):
            self.best = BestPoint(u.copy(), found.objective)
            self.history.append((self.counts.total, found.objective))
        if self.heard is not None:
            self.heard(self.least)
        return found

    @property
    def least(self) -> float | None:
        """The least objective met so far."""
        return None if self.best is None else self.best.objective

    def score(self, x: Array) -> ObjectiveEvaluation:
        """The objective of a design x (p,), neither counted nor kept."""
        return evaluate_summary(self.objective, self.objective.look(x))

    @cached_property
    def reference(self) -> ObjectiveEvaluation:
        """The design to start from: the measure of what is large and what is small."""
        return self.score(self.box.design)

    @property
    def scale(self) -> float:
        """Unit of the objective in residuals and tolerances."""
        return self.objective.unit or self.reference.objective or 1.0

    def flat(self, u: Array) -> Array:
        """Directions (k, p) at right angles that the objective does not feel at a point, of the free coordinates."""
        directions = self.objective.flat(self.design(u)) / self.box.unit
        fixed = np.setdiff1d(np.arange(len(u)), self.free)
        if not len(directions) or not len(fixed):
            return np.linalg.qr(directions.T)[0].T
        _, sizes, right = np.linalg.svd(directions[:, fixed].T)
        kept = right[int((sizes > DIRECTION_TOLERANCE).sum()) :] @ directions
        return np.linalg.qr(kept.T)[0].T

    def conditions(self, u: Array) -> Conditions:
        """First-order data at a point; gradients with respect to u."""
        found = self.objective.conditions(self.design(u))
        return replace(
            found,
            upper_gradients=found.upper_gradients * self.box.unit,
            lower_gradients=found.lower_gradients * self.box.unit,
            smooth=found.smooth * self.box.unit,
            kinks=found.kinks * self.box.unit,
        )
