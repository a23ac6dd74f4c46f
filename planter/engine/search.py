"""The design of a machine, within its bounds, that minimises a sum of measures under limits.

Descents by IPOPT on the smooth programme of `goal` from several starts, a genetic algorithm over the design alone, or
both. Where extremes are the true ones, those between nodes become nodes, until none is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.goal import Goal, GoalConstraints
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise import genetic, starts
from planter.optimise.box import Box
from planter.optimise.descent import Minimum, descend
from planter.optimise.genetic import Settings
from planter.optimise.hybrid import APART, POLISHED, Method
from planter.optimise.problem import Counts, Problem
from planter.optimise.range_and_spread import Sampling
from planter.optimise.result import Certificate, certified
from planter.optimise.sections import DEFAULT_GENETIC
from planter.optimise.smooth import Smooth
from planter.optimise.starts import Descent
from planter.parallel.jobs import run_in_order
from planter.parallel.task import HERE, Means, Task
from planter.progress import Listener, Phase

MOST_ITERATIONS = 300
REACH = 1e3
"""Variables for extremes lie within so many spreads of where they start."""
SNAP = 1e-6
"""Share of the box within which an optimum is set onto a bound."""
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


class Programme:
    """A goal as a problem: searched in shares of the bounds, and in spreads of the measures from where they start."""

    def __init__(self, goal: Goal) -> None:
        self.goal, machine = goal, goal.machine
        start = goal.start(machine.design)
        variables = start[goal.size :]
        names = (*machine.design_names, *(f"{'most' if side > 0 else 'least'} {m}" for m, side in goal.variables))
        self.box = Box(
            names,
            np.concatenate([machine.lower, variables - REACH * goal.unit]),
            np.concatenate([machine.upper, variables + REACH * goal.unit]),
            start,
            np.concatenate([machine.lower, variables]),
            np.concatenate([machine.upper - machine.lower, goal.unit]),
        )
        limits = GoalConstraints(goal) if goal.variables or goal.limits else None
        self.scale = max(abs(goal.value(start)), float(goal.unit.sum()), np.finfo(float).tiny)
        self.problem = Problem(Smooth(goal, len(start), self.scale), self.box, limits)

    def point(self, x: Array) -> Array:
        """Return the point u of a design x (p,), the measures' variables as tight as they can be."""
        return self.box.inside((self.goal.start(x) - self.box.origin) / self.box.unit)

    def begin(self, x: Array) -> Array:
        """Return the point u of a design x (p,) to descend from, whose end does not depend on descents before."""
        self.goal.restart()
        return self.point(x)

    def snapped(self, u: Array) -> Array:
        """Return the design (p,) at a point, on the bounds that it lies close to if nothing is lost by that."""
        for margin in (SNAP, 0.0):
            x = self.x(self.box.snapped(u, margin))
            tight = self.point(x)
            if self.problem.kept(tight):
                return x
        return self.x(u)

    def x(self, u: Array) -> Array:
        """Return the design (p,) at a point."""
        return self.problem.design(u)[: self.goal.size]


class DesignProblem(Problem):
    """A programme searched over the design alone, the measures' variables as tight as they can be."""

    def __init__(self, programme: Programme) -> None:
        problem = programme.problem
        super().__init__(problem.objective, problem.box, problem.constraints)
        self._programme = programme

    @cached_property
    def free(self) -> Integers:
        return np.arange(self._programme.goal.size)

    def point(self, free: Array) -> Array:
        """Return the point with the given coordinates of the design; its variables mean nothing without a cycle."""
        u = self.start.copy()
        u[self.free] = free
        try:
            return self._programme.point(self._programme.x(u))
        except ComputationError:
            return u

    def merit(self, u: Array) -> float:
        try:
            return super().merit(u)
        except ComputationError:
            return float("inf")


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
    is_refined, programme = spec.sampling == "refined", _build_programme(machine, least, limits, spec.sampling)

    def find_minima(designs: Sequence[Array], work: str) -> list[Minimum]:
        return _descend(programme, designs, work, listener, task, means)

    population, minima, points = DesignProblem(programme), [], []
    if spec.method in ("ipopt", "hybrid"):
        minima = find_minima(_starting_designs(machine, spec), "ipopt")
        points = [minimum.u for minimum in minima]
    if spec.method in ("ga", "hybrid"):
        individuals = genetic.search(population, spec.genetic, spec.seed, listener)
        if spec.method == "ga":
            points = [individuals[0].u]
        else:
            designs = [programme.x(one.u) for one in genetic.distinct(individuals, POLISHED, APART)]
            points += [minimum.u for minimum in find_minima(designs, "polish")]
    feasible = [u for u in points if programme.problem.kept(u)]
    if not feasible:
        raise ComputationError(_describe_infeasibility(programme, points))
    u = min(feasible, key=lambda point: programme.problem.score(programme.problem.design(point)).objective)
    first = certified(programme.problem, u, minima)
    counts = population.counts + programme.problem.counts
    if is_refined:
        programme, u = _refine(programme, u, polish=spec.method != "ga")
        counts = counts + programme.problem.counts
    x = programme.snapped(u)
    final = certified(programme.problem, programme.point(x) if spec.method == "ga" else u, minima)
    certificate = Certificate(
        final.kkt_residual, final.active_bounds, final.active_constraints, first.starts, first.agreeing_starts,
        first.spread,
    )  # fmt: skip
    return GoalOptimum(x, programme.goal, certificate, counts)


def _refine(programme: Programme, u: Array, polish: bool) -> tuple[Programme, Array]:
    """Return the programme with true extremes among its nodes, and the minimum beside a point of the former."""
    for _ in range(ROUNDS):
        x = programme.snapped(u)
        goal = programme.goal.refined(x, PASSED)
        if goal is None:
            break
        programme = Programme(goal)
        u = programme.point(x)
        if polish:
            u = descend(programme.problem, u, MOST_ITERATIONS).u
    return programme, u


def _starting_designs(machine: Machine, spec: SearchSpec) -> list[Array]:
    """Return the machine's own design, taken into the bounds, then a Latin hypercube in them."""
    from scipy.stats import qmc

    lower, upper = machine.lower, machine.upper
    generator = np.random.default_rng(spec.seed)
    cube = qmc.LatinHypercube(len(lower), seed=generator).random(max(spec.starts - 1, 0))
    return [np.clip(machine.design, lower, upper), *(lower + cube * (upper - lower))]


def _build_programme(
    machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> Programme:  # fmt: skip
    count = None if sampling == "refined" else sampling
    return Programme(Goal(machine, least, limits, count, with_events=count is None))


def prepare_descents(
    machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> Callable[[Array], Descent]:  # fmt: skip
    """Return the function that descends from a design (p,); arguments as those of `minimise`."""
    programme = _build_programme(machine, least, limits, sampling)
    return lambda x: starts.run_descent(programme.problem, lambda: programme.begin(x), MOST_ITERATIONS)


def _descend(
    programme: Programme, designs: Sequence[Array], work: str, listener: Listener | None, task: Task | None,
    means: Means,
) -> list[Minimum]:  # fmt: skip
    """Return the minima beside designs whose loops close. Raises ComputationError if none does."""
    step = "start" if work == "ipopt" else "individual"
    phase, minima, problem = Phase(work, step, len(designs), listener), [], programme.problem
    error = ComputationError("there are no starts")

    def run_here(x: Array) -> Descent:
        return starts.run_descent(problem, lambda: programme.begin(x), MOST_ITERATIONS)

    descents = run_in_order(task, designs, means, run_here, lambda descent: descent)
    for count, descent in enumerate(descents, 1):
        try:
            minima.append(descent.join(problem))
        except ComputationError as reason:
            error = reason
        phase.reached(count, best=problem.least)
    if not minima:
        raise ComputationError(f"no start leads anywhere: {error.message}")
    return minima


def _describe_infeasibility(programme: Programme, points: Sequence[Array]) -> str:
    """Return which limit the best of the points violates most."""
    problem, goal = programme.problem, programme.goal
    u, constraints = min(points, key=problem.violation), problem.constraints
    assert constraints is not None
    kind = constraints.kinds[int(np.argmax(constraints.excess(problem.design(u))))]
    limit = next((limit for limit in goal.limits if str(limit) == kind.name), None)
    value = None if limit is None else goal.reached(programme.x(u), limit)
    reached = "" if value is None else f": the best design found reaches {value:.6g}"
    return f"no design within the bounds satisfies {kind.name}{reached}"
