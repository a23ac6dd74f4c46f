"""The problem over the design of a machine: a sum of measures under limits, within its bounds."""

from __future__ import annotations

from collections.abc import Sequence

from planter.engine.curves import QuantityCurves
from planter.engine.goal import Goal
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.errors import InputError
from planter.optimise.constraints import Constraints, DesignBox, join_constraints
from planter.optimise.problem import Problem
from planter.optimise.range_variance import CurveSumObjective, Sampling


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

    @property
    def is_slow(self) -> bool:
        """Whether evaluations take so long that other searches are better run beside them."""
        parts = self.goal.objective.parts
        curves = [part.response for part in parts if isinstance(part, CurveSumObjective)]
        return any(
            c.response.slopes_kernel.way != "lanes" for c in curves if isinstance(c, QuantityCurves)
        )


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
