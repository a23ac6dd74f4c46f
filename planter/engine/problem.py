"""The problem over the design of a machine: a sum of measures under limits, within its bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from planter.engine.goal import Goal
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.outputs import OBJECTIVE, SampledOutputs
from planter.engine.solvers.constraints import Constraints, DesignBox, join_constraints
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.problem import MAX_VIOLATION, Problem
from planter.errors import InputError
from planter.kernels import Array


class DesignProblem(Problem):
    """A goal of a machine, searched in shares of the machine's bounds, under further constraints
    (k,) on the design.

    `sampling` says whether the sum is of true extremes and integrals ("refined") or of samples;
    limits are true.
    """

    def __init__(self, goal: Goal, sampling: Sampling, further: Sequence[Constraints] = ()) -> None:
        self.goal, self.sampling, self.further, machine = goal, sampling, further, goal.machine
        limits = [MeasureLimits(goal)] if goal.limits else []
        box = DesignBox.shares(machine.design_names, machine.lower, machine.upper, machine.design)
        super().__init__(
            goal.objective,
            box,
            join_constraints([*limits, *further]),
        )
        if machine.loops is not None:
            self.restart()
            _ = (
                self.reference,
                self.free,
                self.objective.units,
            )  # before any design of a search, on which their last digits would depend

    @property
    def machine(self) -> Machine:
        """The machine whose design is searched for."""
        return self.goal.machine

    def restart(self) -> None:
        """Forget all designs so far, on which only closed loops depend."""
        if self.machine.loops is not None:
            self.objective.restart()
            self.goal.restart()

    @cached_property
    def _population(self) -> SampledOutputs:
        """The sum over samples of the cycle, for many designs at once."""
        machine = replace(self.machine, objective=self.goal.terms)
        paths = machine.moved_paths
        return SampledOutputs(machine, paths, [OBJECTIVE], self.goal.samples or machine.samples)

    def merits(self, points: Sequence[Array]) -> Array:
        """Return the merits (n,) of the points (p,) of a population, over samples.

        Only the best of them is evaluated as the problem is, and counts as met: a search that goes
        on from there has the true values.
        """
        designs = np.array([self.design(u) for u in points]) / self.machine.scale
        self.counts.objective += len(points)
        merits = self._population.evaluated(designs, 1)[:, 0]
        merits = np.where(np.isfinite(merits), merits, np.inf)
        if self.constraints is not None:
            violations = np.array([self.violation(u) for u in points])
            merits += self.scale * np.minimum(violations, MAX_VIOLATION)
        best = int(merits.argmin())
        if np.isfinite(merits[best]):
            self.record(points[best], self.objective.summarise(self.design(points[best])))
        return merits


def build_problem(
    machine: Machine, terms: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> DesignProblem:
    """Return the problem of a sum of measures under limits, which are as `goal.resolve_measure`
    gives them.

    The requirements of the machine's file are satisfied, too. Raises InputError for a machine
    without bounds.
    """
    if not machine.moved:
        raise InputError(f"{machine.source}: it has no [bounds], so there is nothing to search in")
    further = [] if machine.requirements is None else [machine.requirements()]
    goal = Goal(machine, terms, limits, None if sampling == "refined" else sampling)
    return DesignProblem(goal, sampling, further)
