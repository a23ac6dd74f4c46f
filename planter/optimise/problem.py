"""The optimisation problem in box-scaled variables: u in [0, 1]^p, whatever the units of the design."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.conditions import Conditions, Local, Look, Turn
from planter.optimise.constraints import KEPT, Constraints, Required
from planter.optimise.directions import Insensitive, sensitivity
from planter.optimise.objective import Evaluation, Objective
from planter.optimise.refined import Refined
from planter.optimise.response import Response
from planter.optimise.samples import Hold, Samples

MOST_STEPS = 1e3
"""Violations above this many steps are all as bad."""
Sampling = int | Literal["refined"]


@dataclass
class Counts:
    """How often a whole turn was evaluated: its force, its gradients, its Hessians."""

    objective: int = 0
    gradient: int = 0
    hessian: int = 0

    @property
    def total(self) -> int:
        return self.objective + self.gradient + self.hessian

    def __add__(self, other: Counts) -> Counts:
        return Counts(self.objective + other.objective, self.gradient + other.gradient, self.hessian + other.hessian)


@dataclass(frozen=True)
class Best:
    """A point u (p,) and its objective."""

    u: Array
    objective: float


@dataclass
class Problem:
    """An objective of a response within its box.

    Parameters without effect on the force at the response's own design are not searched: they keep that design's
    values, taken into the box. `free` (f,) holds the indices of the others; searches run over those. With `constraints`
    all are searched. Points u are (p,). `best` is the best point met so far that keeps the constraints, `history` when
    each best was met: (turns evaluated, objective).
    """

    response: Response
    objective: Objective
    sampling: Sampling
    constraints: Constraints | None = None
    counts: Counts = field(default_factory=Counts)
    best: Best | None = None
    history: list[tuple[int, float]] = field(default_factory=list)

    @cached_property
    def turn(self) -> Turn:
        return Refined(self.response) if self.sampling == "refined" else Samples(self.response, int(self.sampling))

    @cached_property
    def width(self) -> Array:
        return self.response.upper - self.response.lower

    @cached_property
    def start(self) -> Array:
        """The response's own design, taken into the box, (p,)."""
        return np.clip((self.response.design - self.response.lower) / self.width, 0, 1)

    @cached_property
    def insensitive(self) -> Insensitive:
        return sensitivity(self.response, self.response.design, self.samples)

    @property
    def samples(self) -> int:
        return 360 if self.sampling == "refined" else int(self.sampling)

    @cached_property
    def free(self) -> Integers:
        if self.constraints is not None:
            return np.arange(len(self.response.design))
        return np.flatnonzero(~self.insensitive.zero)

    def design(self, u: Array) -> Array:
        """The design x (p,) in SI at a point of the box; on a bound it is that bound to the last bit."""
        lower, upper = self.response.lower, self.response.upper
        return np.clip(np.where(u >= 1, upper, lower + u * self.width), lower, upper)

    def point(self, free: Array) -> Array:
        """The point u (p,) with the given free coordinates (f,)."""
        u = self.start.copy()
        u[self.free] = free
        return u

    def local(self, u: Array, holds: tuple[Hold, ...] = ()) -> Local:
        """The force near a point as smooth functions, joints held as told, with the rows of the constraints."""
        x = self.design(u)
        found = self.turn.local(x).held(holds) if isinstance(self.turn, Samples) else self.turn.local(x)
        return found if self.constraints is None else Required(found, self.constraints)

    def violation(self, u: Array) -> float:
        """By how many steps the worst constraint is violated at a point, 0 where all are kept."""
        return 0.0 if self.constraints is None else self.constraints.violation(self.design(u))

    def kept(self, u: Array) -> bool:
        """Whether a point keeps all constraints."""
        return self.violation(u) <= KEPT

    def merit(self, u: Array) -> float:
        """The objective, and as much again as that of the machine's own design for each step of the worst violation."""
        return self.evaluate(u).objective + (
            min(self.violation(u), MOST_STEPS) * self.scale if self.constraints else 0.0
        )

    def evaluate(self, u: Array) -> Evaluation:
        """The objective at a point."""
        self.counts.objective += 1
        return self.met(u, self.turn.look(self.design(u)))

    def met(self, u: Array, look: Look) -> Evaluation:
        """The objective of a turn that was looked at on the way, kept if it is the best so far."""
        found = self._evaluation(look)
        if (self.best is None or found.objective < self.best.objective) and self.kept(u):
            self.best = Best(u.copy(), found.objective)
            self.history.append((self.counts.total, found.objective))
        return found

    def _evaluation(self, look: Look) -> Evaluation:
        span = look.high - look.low
        value = self.objective.value(span, look.variance)
        return Evaluation(value, span, look.variance, look.high, look.low, look.mean)

    @cached_property
    def reference(self) -> Evaluation:
        """The response's own design: the measure of what is large and what is small."""
        return self._evaluation(self.turn.look(self.response.design))

    @property
    def scale(self) -> float:
        """Unit of the objective in residuals and tolerances: its value at the response's own design."""
        return self.reference.objective or 1.0

    def conditions(self, u: Array) -> Conditions:
        """First-order data at a point; gradients with respect to u."""
        found = self.turn.conditions(self.design(u))
        return replace(
            found,
            upper_gradients=found.upper_gradients * self.width,
            lower_gradients=found.lower_gradients * self.width,
            variance=found.variance * self.width,
            kinks=found.kinks * self.width,
        )
