"""A local minimum from one start, on a set of rows that is complete when it ends, kinks taken exactly.

Rows. A sampled turn without constraints goes to IPOPT, in epigraph form on the rows in hand; samples that turn out to
violate t_max or t_min join the rows, until none does. So does a smooth objective, which has no rows. Everything else
that has rows, true extremes, or samples under constraints or with joints held, goes to `sequential`, whose rows are
those of each point that it comes to.

Kinks. A sampled objective has one in x wherever a joint of order 1 passes a sample. The search first ignores them: it
works with the one-sided derivatives of the side it is on, and where the optimum lies on no kink that is all. Where
the certificate does not pass what it found, it goes on from cell to cell, a cell being where every joint
stays between its two samples and everything is smooth:

1. solve within the cell;
2. if joints end at walls, pin them on their samples and solve on the kink; if zero is in Clarke's subdifferential,
   stop;
3. else cross those walls, as long as the objective falls.

Descents from several starts: the design to start from, then points of a Latin hypercube in the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise import certificate, epigraph, ipopt, sqp
from planter.optimise.constraints import FEASIBILITY_TOLERANCE
from planter.optimise.epigraph import Epigraph
from planter.optimise.feasibility import minimise_violation
from planter.optimise.objective import BreakpointHold, Kinks, LocalModel, ObjectiveEvaluation
from planter.optimise.problem import BestPoint, Counts, Problem
from planter.optimise.sampled_cycle import WALL_MARGIN
from planter.parallel.jobs import Jobs, run_in_order
from planter.parallel.task import AUTO, Means, Task
from planter.progress import Listener, ProgressPhase

MAX_ROW_ROUNDS, MAX_CELLS = 12, 100
"""Most times that rows are added, and most cells that are visited."""
MAX_CONSTRAINED_CELLS = 4
"""The same where constraints are kept, whose rows take longer than the objective's."""
VIOLATION_TOLERANCE = 1e-9
"""A row violates an extreme if it exceeds it by more than this share of the range."""
STATIONARITY_TOLERANCE = 1e-6
"""Residual of the certificate below which a point counts as optimal."""
DECREASE_TOLERANCE = 1e-12
"""The objective falls if it does by more than this share of the problem's scale."""
SNAP_MARGINS = (0.0, 1e-7, 1e-5, 1e-3)
"""Coordinates this close to their bounds, in the box's unit, are set onto them if that makes a better point."""


@dataclass(frozen=True)
class LocalMinimum:
    """Where a descent ended: point u (p,), its evaluation, its residual (dimensionless) and the iterations it took.

    `violation` is that of the constraints, in steps; `converged` is what the solver says of the run that ended there.
    """

    u: Array
    evaluation: ObjectiveEvaluation
    residual: float
    iterations: int
    violation: float = 0.0
    converged: bool = True

    @property
    def stationary(self) -> bool:
        return self.residual < STATIONARITY_TOLERANCE

    @property
    def settled(self) -> bool:
        """Whether the solver converged here, and the constraints are kept."""
        return self.violation <= FEASIBILITY_TOLERANCE and self.converged

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """The least of several is the best: one that keeps the constraints, is stationary, has the least objective."""
        return self.violation > FEASIBILITY_TOLERANCE, not self.stationary, self.objective

    @property
    def objective(self) -> float:
        return self.evaluation.objective

    def after(self, earlier: LocalMinimum) -> LocalMinimum:
        """With the iterations that went before."""
        return replace(self, iterations=self.iterations + earlier.iterations)


def search_locally(
    problem: Problem, start: Array, most_iterations: int | None = None, rounds: int = MAX_ROW_ROUNDS
) -> LocalMinimum:
    """Return the local minimum reached from a point u (p,) of the box.

    `most_iterations` limits each of the runs, the problem's own number if None, `rounds` how often rows are added.
    """
    most_iterations = problem.most_iterations if most_iterations is None else most_iterations
    found = _search_with_holds(problem, start, (), most_iterations, rounds)
    kinks = problem.objective.kinks
    if found.stationary or kinks is None:
        return found
    return _search_cells(problem, kinks, found, most_iterations)


def _search_with_holds(
    problem: Problem, start: Array, holds: Sequence[BreakpointHold], most_iterations: int, rounds: int = MAX_ROW_ROUNDS
) -> LocalMinimum:
    """The minimum with joints held as told."""
    objective, constrained = problem.objective, problem.constraints is not None
    if objective.windows or holds or (constrained and objective.kinks is not None):
        found = sqp.minimise_by_sqp(problem, start, holds, 2 * most_iterations)
        return replace(_snap_to_bounds(problem, found.u, found.iterations), converged=found.converged)
    return _search_by_ipopt(problem, start, problem.local(start, holds), most_iterations, rounds)


def _search_by_ipopt(
    problem: Problem, start: Array, local: LocalModel, most_iterations: int, rounds: int
) -> LocalMinimum:
    """By IPOPT, with rows added until no other exceeds the bounds on them."""
    u, iterations, found = start, 0, []
    for _ in range(rounds):
        programme = Epigraph(problem, local, u)
        solution = _solve_epigraph(programme, most_iterations)
        iterations += solution.iterations
        u = problem.box.inside(programme.point(solution.z))
        found.append(replace(_snap_to_bounds(problem, u, iterations), converged=solution.converged))
        high, low = programme.limits(solution.z, VIOLATION_TOLERANCE)
        look = found[-1].evaluation.look
        complete = look.high <= high and look.low >= low
        if found[-1].stationary or complete or not solution.converged:
            break
        local = local.grown(problem.design(u), high, low)
    best = min(found, key=lambda minimum: minimum.rank)
    return replace(best, iterations=iterations)


def _solve_epigraph(programme: Epigraph, most_iterations: int) -> ipopt.IpoptSolution:
    """By compiled functions where the programme has them; they do their own counting."""
    compiled = epigraph.compile_epigraph(programme)
    solution = ipopt.solve_program(programme, programme.start, most_iterations, compiled)
    if compiled:
        called = Counts(*(solution.calls[name] for name in ("nlp_f", "nlp_grad_f", "nlp_hess_l")))
        programme.problem.counts = programme.problem.counts + called
    return solution


def _search_cells(problem: Problem, kinks: Kinks, found: LocalMinimum, most_iterations: int) -> LocalMinimum:
    """From cell to cell until a minimum inside one or on a kink is found, or the objective falls no more."""

    def solved(minimum: LocalMinimum, holds: list[BreakpointHold]) -> LocalMinimum:
        return _search_with_holds(problem, minimum.u, tuple(holds), most_iterations).after(minimum)

    here = solved(found, [kinks.wall(pin, distance) for pin, distance in kinks.find_pins(problem.design(found.u))])
    for _ in range(MAX_CELLS if problem.constraints is None else MAX_CONSTRAINED_CELLS):
        near = kinks.find_pins(problem.design(here.u))
        touching = [i for i, (_, distance) in enumerate(near) if abs(distance) < 2 * WALL_MARGIN]
        if here.stationary or not touching:
            break
        walls = [kinks.wall(pin, distance) for pin, distance in near]
        on_kink = solved(here, [near[i][0] if i in touching else wall for i, wall in enumerate(walls)])
        if on_kink.stationary:
            return on_kink
        across = [kinks.wall(pin, -distance) for pin, distance in near]
        limit, spent = here.objective - DECREASE_TOLERANCE * problem.scale, replace(here, iterations=on_kink.iterations)
        crossed = (solved(spent, [across[i] if i in choice else wall for i, wall in enumerate(walls)])
                   for choice in _list_crossings(touching))  # fmt: skip
        following = next((minimum for minimum in crossed if minimum.objective < limit), None)
        if following is None:
            break
        here = following
    return min(found, here, key=lambda minimum: minimum.rank)


def _list_crossings(touching: list[int]) -> list[list[int]]:
    """Which walls to cross: all that are touched, else one alone."""
    return [touching, *([i] for i in touching)] if len(touching) > 1 else [touching]


def evaluate_minimum(problem: Problem, u: Array, iterations: int) -> LocalMinimum:
    """What a point is as a minimum."""
    residual = certificate.kkt_residual(problem, u)
    return LocalMinimum(u, problem.evaluate(u), residual, iterations, problem.violation(u))


def _snap_to_bounds(problem: Problem, u: Array, iterations: int) -> LocalMinimum:
    """Return a point with coordinates beside their bounds set onto them: an interior point is never quite there."""
    points = {p.tobytes(): p for p in (problem.complete(problem.box.snapped(u, s)) for s in SNAP_MARGINS)}
    return min((evaluate_minimum(problem, p, iterations) for p in points.values()), key=lambda minimum: minimum.rank)


DEFAULT_STARTS = 8
SAME_START = 1e-7
"""Starts closer than this in every coordinate, in the box's unit, are one."""
AGREEMENT_TOLERANCE = 1e-6
"""Starts agree whose objectives differ by less than this share of the problem's scale."""


def sample_starts(problem: Problem, count: int, seed: int) -> list[Array]:
    """Return starting points u (p,), that of the design first; the same seed and count give the same points."""
    from scipy.stats import qmc

    problem.restart()
    first = problem.complete(problem.start)
    if count < 2:
        return [first]
    cube = qmc.LatinHypercube(len(problem.independent), seed=np.random.default_rng(seed)).random(count - 1)
    return [first, *(problem.within(v) for v in cube)]


def select_start(problem: Problem, start: Array) -> Array:
    """A start on the equations, or where the constraints are violated least on the way from there."""
    start = problem.onto(start)
    if problem.constraints is None or problem.is_feasible(start):
        return start
    return minimise_violation(problem, problem.constraints, start).u


@dataclass(frozen=True)
class SearchRecord:
    """The minimum or the error by which a descent ended on a problem, with all that the problem met on the way."""

    end: LocalMinimum | ComputationError
    counts: Counts
    best: BestPoint | None
    history: list[tuple[int, float]]

    def join(self, problem: Problem) -> LocalMinimum | ComputationError:
        """Return the end, all that was met counted as met by a problem."""
        problem.absorb(self.counts, self.best, self.history)
        return self.end


def run_search(problem: Problem, start: Array) -> SearchRecord:
    """Return the descent on a problem anew from a start (p,): the job of a worker."""
    problem = problem.anew()
    return SearchRecord(_try_start(problem, start), problem.counts, problem.best, problem.history)


def _try_start(problem: Problem, start: Array) -> LocalMinimum | ComputationError:
    """Return the minimum reached from a start, or why none is; neither depends on the descents before."""
    problem.restart()
    try:
        return search_locally(problem, select_start(problem, start))
    except ComputationError as error:
        return error


def search_from_starts(
    problem: Problem, count: int, seed: int, progress: Listener | None = None, task: Task | None = None,
    means: Means = AUTO, under_way: Jobs | None = None,
) -> Iterator[LocalMinimum]:  # fmt: skip
    """Yield the local minima from `count` points of the box, as `find_minima` those of given points."""
    phase = ProgressPhase("ipopt", "start", count, progress)
    return find_minima(
        problem, sample_starts(problem, count, seed) if under_way is None else (), phase, task, means, under_way
    )


def find_minima(
    problem: Problem, starts: Sequence[Array], phase: ProgressPhase, task: Task | None = None, means: Means = AUTO,
    under_way: Jobs | None = None,
) -> Iterator[LocalMinimum]:  # fmt: skip
    """Yield the local minima from points u (p,), in their order, as they are reached.

    A start that breaks constraints is first taken to where they are violated least; one that leads nowhere is left out.
    Workers run the descents of a task, whose jobs are points, as `run_in_order`; or they are `under_way`. Raises
    ComputationError if no start leads anywhere.
    """
    problem.heard = phase.report_if_slow
    minima, error = 0, None

    def join(descent: SearchRecord) -> LocalMinimum | ComputationError:
        return descent.join(problem)

    def wait() -> None:
        phase.report_if_slow(problem.least)

    ends: Iterator[LocalMinimum | ComputationError]
    if under_way is None:
        ends = run_in_order(task, starts, means, lambda start: _try_start(problem, start), join, wait)
    else:
        ends = map(join, under_way.in_order(wait))
    for done, end in enumerate(ends, 1):
        if isinstance(end, ComputationError):
            error = end
        else:
            minima += 1
            yield end
        phase.report(done, best=problem.least)
    if error is not None and not minima:
        raise ComputationError(f"no start leads anywhere: {error.message}")


def search_from_points(
    problem: Problem, starts: Sequence[Array], most_iterations: int | None = None
) -> list[LocalMinimum]:  # fmt: skip
    """The local minima from points u (p,) as they are; starts that are one point descend as one."""
    found: list[LocalMinimum] = []
    for start in starts:
        twins = (end for other, end in zip(starts, found, strict=False) if np.abs(other - start).max() <= SAME_START)
        found.append(next(twins, None) or search_locally(problem, start, most_iterations))
    return found
