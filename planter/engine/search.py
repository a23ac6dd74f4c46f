"""The design of a machine, within its bounds, that minimises a sum of measures under limits.

Descents by IPOPT on the smooth programme of `goal` from several starts, a genetic algorithm over the design alone, or
both. Where extremes are the true ones, those between nodes become nodes, until none is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.engine.goal import Goal, GoalConstraints
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise import starts
from planter.optimise.box import Box
from planter.optimise.descent import descend
from planter.optimise.genetic import Settings
from planter.optimise.hybrid import Method, Search
from planter.optimise.problem import Counts, Problem
from planter.optimise.range_and_spread import Sampling
from planter.optimise.result import Certificate, NoFeasiblePointError, certified
from planter.optimise.sections import DEFAULT_GENETIC
from planter.optimise.smooth import Smooth
from planter.optimise.starts import Descent
from planter.parallel.task import HERE, Means, Task
from planter.progress import Listener

REACH = 1e3
"""Variables for extremes lie within so many spreads of where they start."""
PASSED = 1e-9
"""Share of a quantity's spread by which a true extreme may pass the nodes."""
ROUNDS = 10
"""Most times that extremes between nodes become nodes."""


@dataclass(frozen=True)
class SearchSpec:
    """How to search: true extremes ("refined") or a number of samples, and by which method from how many starts."""

    sampling: Sampling = "refined"
    method: Method = "ipopt"
    starts: int = starts.DEFAULT_STARTS
    seed: int = 0
    genetic: Settings = DEFAULT_GENETIC


@dataclass(frozen=True)
class GoalOptimum:
    """An optimum: the design (p,) in SI, the goal with its nodes, how sure it is and what it took.

    `certificate` is that of the optimum, with the agreement of the starts.
    """

    x: Array
    goal: Goal
    certificate: Certificate
    evaluations: Counts


class GoalProblem(Problem):
    """A goal as a problem: searched in shares of the bounds, and in spreads of the measures from where they start.

    Starts and individuals choose the design; the variables of its extremes are as tight as they can be.
    """

    most_iterations = 300

    def __init__(self, goal: Goal) -> None:
        self.goal, machine = goal, goal.machine
        start = goal.start(machine.design)
        variables = start[goal.size :]
        names = (*machine.design_names, *(f"{'most' if side > 0 else 'least'} {m}" for m, side in goal.variables))
        box = Box(
            names,
            np.concatenate([machine.lower, variables - REACH * goal.unit]),
            np.concatenate([machine.upper, variables + REACH * goal.unit]),
            start,
            np.concatenate([machine.lower, variables]),
            np.concatenate([machine.upper - machine.lower, goal.unit]),
        )
        limits = GoalConstraints(goal) if goal.variables or goal.limits else None
        scale = max(abs(goal.value(start)), float(goal.unit.sum()), np.finfo(float).tiny)
        super().__init__(Smooth(goal, len(start), scale), box, limits)

    def restart(self) -> None:
        _ = self.reference
        self.goal.restart()

    @property
    def independent(self) -> Integers:
        return np.arange(self.goal.size)

    def complete(self, u: Array) -> Array:
        """Return a point (p,) with tight variables; without a cycle they mean nothing, and stay as they are."""
        try:
            return self.find_point(self.machine_design(u))
        except ComputationError:
            return u

    def find_point(self, x: Array) -> Array:
        """Return the point (p,) of a machine's design. Raises ComputationError if its loops do not close."""
        return self.box.point(self.goal.start(x))

    def machine_design(self, u: Array) -> Array:
        """Return the machine's design at a point (p,)."""
        return self.design(u)[: self.goal.size]


def minimise(
    machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], spec: SearchSpec,
    listener: Listener | None = None, task: Task | None = None, means: Means = HERE,
) -> GoalOptimum:  # fmt: skip
    """Return the design within the bounds that minimises a sum of measures under limits.

    Measures and limits are as `goal.resolve_measure` gives them. `means` says what runs the descents, whose results do
    not depend on it; workers take those of a task, which prepares `prepare_descents` with the same arguments. Raises
    InputError for a machine without bounds; ComputationError if no start leads to a design that satisfies the limits.
    """
    if not machine.moved:
        raise InputError(f"{machine.source}: it has no [bounds], so there is nothing to search in")
    problem = _build_problem(machine, least, limits, spec.sampling)
    search = Search(problem, spec.genetic, spec.seed, spec.starts, listener, task, means)
    try:
        reached = search.run(spec.method)
    except NoFeasiblePointError as error:
        raise ComputationError(_describe_infeasibility(problem, error.points)) from None
    u, certificate, counts = problem.box.point(reached.design), reached.certificate, reached.evaluations
    if spec.sampling == "refined":
        problem, u, more = _refine(problem, u, polish=spec.method != "ga")
        refined, counts = certified(problem, u, ()), counts + more
        certificate = replace(
            certificate, kkt_residual=refined.kkt_residual, active_bounds=refined.active_bounds,
            active_constraints=refined.active_constraints,
        )  # fmt: skip
    return GoalOptimum(problem.machine_design(u), problem.goal, certificate, counts)


def _refine(problem: GoalProblem, u: Array, polish: bool) -> tuple[GoalProblem, Array, Counts]:
    """Return the problem with true extremes among its nodes, a minimum near a point of the former, and the cost."""
    counts = Counts()
    for _ in range(ROUNDS):
        x = problem.machine_design(u)
        goal = problem.goal.refined(x, PASSED)
        if goal is None:
            break
        problem = GoalProblem(goal)
        u = problem.find_point(x)
        if polish:
            u = descend(problem, u).u
        counts = counts + problem.counts
    return problem, u, counts


def _build_problem(
    machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> GoalProblem:  # fmt: skip
    count = None if sampling == "refined" else sampling
    return GoalProblem(Goal(machine, least, limits, count, with_events=count is None))


def prepare_descents(
    machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> Callable[[Array], Descent]:  # fmt: skip
    """Return the function that descends from a point (p,) of the problem; arguments as those of `minimise`."""
    problem = _build_problem(machine, least, limits, sampling)
    return lambda start: starts.run_descent(problem, start)


def _describe_infeasibility(problem: GoalProblem, points: Sequence[Array]) -> str:
    """Return which limit the best of the points violates most."""
    u, constraints = min(points, key=problem.violation), problem.constraints
    assert constraints is not None
    kind = constraints.kinds[int(np.argmax(constraints.excess(problem.design(u))))]
    limit = next((limit for limit in problem.goal.limits if str(limit) == kind.name), None)
    value = None if limit is None else problem.goal.reached(problem.machine_design(u), limit)
    reached = "" if value is None else f": the best design found reaches {value:.6g}"
    return f"no design within the bounds satisfies {kind.name}{reached}"
