"""Local search from one or several starts, with an exact treatment of kinks.

Components. Smooth objectives and sampled cycles without constraints are minimised by IPOPT in
epigraph form. Samples that violate t_max or t_min become further components until none does.
Continuous extrema, and samples with constraints or constrained breakpoints, are minimised by `sqp`,
which determines the components at each point.

Kinks. A sampled objective has a kink in x at each design where a breakpoint of order 1 passes a
sample. The search first ignores kinks and uses one-sided derivatives, which suffices if the optimum
lies on no kink. If the certificate rejects the result, the search continues from cell to cell; in a
cell, each breakpoint lies between two samples and all is smooth:

1. solve within the cell;
2. if breakpoints end at walls, pin them at their samples and solve on the kink; stop if zero is in
  Clarke's subdifferential;
3. otherwise cross these walls while the objective decreases.

Several starts are the initial design and points of a Latin hypercube in the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.engine.solvers import certificate, ipopt, sqp
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE, ConstrainedModel
from planter.engine.solvers.epigraph import Epigraph
from planter.engine.solvers.feasibility import ViolationMinimum, approach_limits
from planter.engine.solvers.objective import BreakpointHold, Kinks, LocalModel, ObjectiveEvaluation
from planter.engine.solvers.problem import BestPoint, ClosestPoint, Counts, Problem
from planter.engine.solvers.sampled_cycle import WALL_MARGIN
from planter.errors import ComputationError
from planter.jobs import run_in_order
from planter.kernels import Array
from planter.numerics.latin_hypercube import draw_latin_hypercube
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means, Task

MAX_ROW_ROUNDS, MAX_CELLS = 12, 100
"""Maximum number of rounds with additional components, and of cells visited."""
MAX_CONSTRAINED_CELLS = 4
"""Maximum number of cells with constraints, which take longer to evaluate than the objective."""
VIOLATION_TOLERANCE = 1e-9
"""Components violate an extreme which they exceed by more than this share of the range."""
GLIDE_ITERATIONS, GLIDE_TOLERANCE = 12, 1e-2
"""Most iterations of the search over few samples that precedes a local one, and its tolerance."""
STATIONARITY_TOLERANCE = 1e-6
"""Residual of the certificate below which a point counts as optimal."""
DECREASE_TOLERANCE = 1e-12
"""Smallest decrease of the objective, as a share of the scale of the problem."""
SNAP_MARGINS = (0.0, 1e-7, 1e-5, 1e-3)
"""Coordinates this close to a bound, in units of the box, are set onto it if that yields a better
point.
"""


@dataclass(frozen=True)
class LocalMinimum:
    """End of a local search: point u (p,), evaluation, residual (dimensionless) and number of
    iterations.

    `violation` is that of the constraints in steps; `converged` is the status of the last run of
    the solver.
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
        """Whether the solver converged to a feasible point."""
        return self.violation <= FEASIBILITY_TOLERANCE and self.converged

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """Sort key, smallest for the best: feasible, then stationary, then the smallest
        objective.
        """
        return self.violation > FEASIBILITY_TOLERANCE, not self.stationary, self.objective

    @property
    def objective(self) -> float:
        return self.evaluation.objective

    def after(self, earlier: LocalMinimum) -> LocalMinimum:
        """Return a copy which includes the iterations of an earlier search."""
        return replace(self, iterations=self.iterations + earlier.iterations)


def glide_over_samples(problem: Problem, start: Array) -> Array:
    """Return the end (p,) of a short interior-point search from a point over few samples.

    Its barrier keeps away from the corners of a maximum, and so passes shallow minima in which a
    search along these corners ends. Where there is no such search, the start is returned.
    """
    local = problem.objective.coarse(problem.design(start))
    if local is None:
        return start
    if problem.constraints is not None:
        local = ConstrainedModel(local, problem.constraints.at(problem.design(start)))
    scratch = problem.anew()
    programme = Epigraph(scratch, local, start)
    solution = ipopt.solve_program(
        programme, programme.start, GLIDE_ITERATIONS, tolerance=GLIDE_TOLERANCE
    )
    problem.counts = problem.counts + scratch.counts
    return problem.box.inside(programme.point(solution.z))


def search_locally(
    problem: Problem, start: Array, most_iterations: int | None = None, rounds: int = MAX_ROW_ROUNDS
) -> LocalMinimum:
    """Return the local minimum reached from a point u (p,) of the box.

    `most_iterations` limits each of the runs, the problem's own number if None, `rounds` how often
    rows are added.
    """
    most_iterations = problem.most_iterations if most_iterations is None else most_iterations
    minimum = _search_with_holds(problem, start, (), most_iterations, rounds)
    kinks = problem.objective.kinks
    if minimum.stationary or kinks is None:
        return minimum
    return _search_cells(problem, kinks, minimum, most_iterations)


def _search_with_holds(
    problem: Problem,
    start: Array,
    holds: Sequence[BreakpointHold],
    most_iterations: int,
    rounds: int = MAX_ROW_ROUNDS,
) -> LocalMinimum:
    """Return the minimum with breakpoints constrained by `holds`."""
    objective, constraints = problem.objective, problem.constraints
    is_moving = constraints is not None and (constraints.windows or objective.kinks is not None)
    if objective.windows or holds or is_moving:
        solution = sqp.minimise_by_sqp(problem, start, holds, 2 * most_iterations)
        return replace(
            _snap_to_bounds(problem, solution.u, solution.iterations), converged=solution.converged
        )
    return _search_by_ipopt(problem, start, problem.local(start, holds), most_iterations, rounds)


def _search_by_ipopt(
    problem: Problem, start: Array, local: LocalModel, most_iterations: int, rounds: int
) -> LocalMinimum:
    """Return the minimum by IPOPT, adding components until none violates t_max or t_min."""
    u, iterations, minima = start, 0, []
    for _ in range(rounds):
        programme = Epigraph(problem, local, u)
        solution = ipopt.solve_program(programme, programme.start, most_iterations)
        iterations += solution.iterations
        u = problem.box.inside(programme.point(solution.z))
        minima.append(
            replace(_snap_to_bounds(problem, u, iterations), converged=solution.converged)
        )
        tops = programme.tops(solution.z, VIOLATION_TOLERANCE)
        complete = bool((minima[-1].evaluation.summary.tops <= tops).all())
        if minima[-1].stationary or complete or not solution.converged:
            break
        local = local.extended(problem.design(u), tops)
    best = min(minima, key=lambda minimum: minimum.rank)
    return replace(best, iterations=iterations)


def _search_cells(
    problem: Problem, kinks: Kinks, first: LocalMinimum, most_iterations: int
) -> LocalMinimum:
    """Search from cell to cell until a minimum is stationary or the objective no longer
    decreases.
    """

    def solved(minimum: LocalMinimum, holds: list[BreakpointHold]) -> LocalMinimum:
        return _search_with_holds(problem, minimum.u, tuple(holds), most_iterations).after(minimum)

    current = solved(
        first,
        [kinks.wall(pin, distance) for pin, distance in kinks.find_pins(problem.design(first.u))],
    )
    for _ in range(MAX_CELLS if problem.constraints is None else MAX_CONSTRAINED_CELLS):
        pins = kinks.find_pins(problem.design(current.u))
        touching = [i for i, (_, distance) in enumerate(pins) if abs(distance) < 2 * WALL_MARGIN]
        if current.stationary or not touching:
            break
        walls = [kinks.wall(pin, distance) for pin, distance in pins]
        on_kink = solved(
            current, [pins[i][0] if i in touching else wall for i, wall in enumerate(walls)]
        )
        if on_kink.stationary:
            return on_kink
        across = [kinks.wall(pin, -distance) for pin, distance in pins]
        limit, spent = (
            current.objective - DECREASE_TOLERANCE * problem.scale,
            replace(current, iterations=on_kink.iterations),
        )
        crossed = (
            solved(spent, [across[i] if i in choice else wall for i, wall in enumerate(walls)])
            for choice in _list_crossings(touching)
        )
        following = next((minimum for minimum in crossed if minimum.objective < limit), None)
        if following is None:
            break
        current = following
    return min(first, current, key=lambda minimum: minimum.rank)


def _list_crossings(touching: list[int]) -> list[list[int]]:
    """Return the sets of walls to cross: first all that are touched, then each alone."""
    return [touching, *([i] for i in touching)] if len(touching) > 1 else [touching]


def evaluate_minimum(problem: Problem, u: Array, iterations: int) -> LocalMinimum:
    """Return a point u (p,) with its objective, residual and violation."""
    residual = certificate.kkt_residual(problem, u)
    return LocalMinimum(u, problem.evaluate(u), residual, iterations, problem.violation(u))


def _snap_to_bounds(problem: Problem, u: Array, iterations: int) -> LocalMinimum:
    """Return the best point with coordinates near bounds set onto these, which interior points do
    not reach.
    """
    points = {
        p.tobytes(): p for p in (problem.complete(problem.box.snapped(u, s)) for s in SNAP_MARGINS)
    }
    return min(
        (evaluate_minimum(problem, p, iterations) for p in points.values()),
        key=lambda minimum: minimum.rank,
    )


DEFAULT_STARTS = 8
SAME_START = 1e-7
"""Starts closer than this in every coordinate are the same, in units of the box."""
AGREEMENT_TOLERANCE = 1e-6
"""Starts agree if their objectives differ by less than this share of the scale of the problem."""


def sample_starts(problem: Problem, count: int, seed: int) -> list[Array]:
    """Return starting points u (p,), that of the design first; the same seed and count give the
    same points.
    """
    problem.restart()
    first = problem.complete(problem.start)
    if count < 2:
        return [first]
    generator = np.random.default_rng(seed)
    cube = draw_latin_hypercube(count - 1, len(problem.independent), generator)
    return [first, *(problem.interpolate(v) for v in cube)]


@dataclass(frozen=True)
class Descent:
    """The job of a local search: its start u (p,), and whether it glides first."""

    start: Array
    glides: bool = False


def list_descents(starts: Sequence[Array]) -> list[Descent]:
    """Return the descents from starts u (p,), of which every other one glides.

    Searches of one kind may all end in a minimum that is none for the other: only where both kinds
    agree does the agreement of starts mean something.
    """
    return [Descent(start, k % 2 == 1) for k, start in enumerate(starts)]


@dataclass(frozen=True)
class Approach:
    """The job of a search for a feasible point from a start u (p,)."""

    start: Array


def select_start(problem: Problem, start: Array) -> Array:
    """Return a start on the equality constraints or, if it is infeasible, a feasible point or the
    smallest violation reached from there.
    """
    return approach_feasible(problem, start).u


def approach_feasible(problem: Problem, start: Array) -> ViolationMinimum:
    """Return a point u (p,) projected onto the equality constraints if that is feasible, else the
    first feasible point or the smallest violation that a search from there reaches.
    """
    start, constraints = problem.onto(start), problem.constraints
    if constraints is None or problem.is_feasible(start):
        kinds = 0 if constraints is None else len(constraints.kinds)
        return ViolationMinimum(start, np.zeros(kinds), stationary=True)
    return approach_limits(problem, constraints, start, stops=True)


@dataclass(frozen=True)
class SearchRecord:
    """The end or the error of a search, with its counts, best point, history and closest point."""

    end: LocalMinimum | ViolationMinimum | ComputationError
    counts: Counts
    best: BestPoint | None
    history: list[tuple[int, float]]
    closest: ClosestPoint | None

    def join(self, problem: Problem) -> LocalMinimum | ViolationMinimum | ComputationError:
        """Add counts, best point, history and closest point to a problem and return the end."""
        problem.absorb(self.counts, self.best, self.history, self.closest)
        return self.end


def run_search(problem: Problem, job: Descent | Approach) -> SearchRecord:
    """Return the search of a worker, on a copy of the problem."""
    problem = problem.anew()
    end = _run_job(problem, job)
    return SearchRecord(end, problem.counts, problem.best, problem.history, problem.closest)


def _run_job(
    problem: Problem, job: Descent | Approach
) -> LocalMinimum | ViolationMinimum | ComputationError:
    """Return what a job reaches, or the error, independently of earlier searches."""
    problem.restart()
    try:
        if isinstance(job, Approach):
            return approach_feasible(problem, job.start)
        start = select_start(problem, job.start)
        return search_locally(problem, glide_over_samples(problem, start) if job.glides else start)
    except ComputationError as error:
        return error


def search_from_starts(
    problem: Problem,
    count: int,
    seed: int,
    progress: Listener | None = None,
    task: Task | None = None,
    means: Means = AUTO,
) -> Iterator[LocalMinimum]:
    """Yield the local minima from `count` sampled points of the box; see `find_minima`."""
    descents = list_descents(sample_starts(problem, count, seed))
    phase = ProgressPhase("ipopt", "start", count, progress)
    return find_minima(problem, descents, phase, task, means)


def find_violation_minima(
    problem: Problem,
    starts: Sequence[Array],
    progress: Listener | None = None,
    task: Task | None = None,
    means: Means = AUTO,
) -> Iterator[ViolationMinimum | None]:
    """Yield a feasible point, or else the smallest violation, from each start u (p,), None from one
    without values.

    The progress names what the closest point so far violates most. Raises ComputationError if no
    start has values.
    """
    phase = ProgressPhase("limits", "start", len(starts), progress)
    problem.heard = lambda _: phase.report_if_slow(None, describe_closest(problem))
    error, feasible = None, 0
    ends = run_in_order(
        task,
        [Approach(start) for start in starts],
        means,
        lambda job: _run_job(problem, job),
        lambda record: record.join(problem),
        lambda: phase.report_if_slow(None, describe_closest(problem)),
    )
    errors = 0
    for done, end in enumerate(ends, 1):
        if isinstance(end, ComputationError):
            error, errors = end, errors + 1
            yield None
        else:
            feasible += end.is_feasible
            yield end
        note = f"{feasible} feasible" if feasible else describe_closest(problem)
        phase.report(done, note)
    if error is not None and errors == len(starts):
        raise ComputationError(f"no start leads anywhere: {error.message}")


def describe_closest(problem: Problem) -> str:
    """Return which constraint the closest point so far violates most, and by how much in its
    unit.
    """
    closest, constraints = problem.closest, problem.constraints
    if closest is None or constraints is None:
        return ""
    kinds = {kind.name: kind for kind in constraints.kinds}
    if closest.constraint not in kinds:
        return f"largest violation {closest.violation:.3g} steps"
    kind = kinds[closest.constraint]
    amount = closest.violation * kind.step
    return f"{kind.name} violated by {format_amount(amount, kind.unit)}"


def format_amount(value: float, unit: str) -> str:
    """Return a number of three digits with its unit, which may be 1."""
    return f"{value:.3g}" if unit in ("", "1") else f"{value:.3g} {unit}"


def find_minima(
    problem: Problem,
    descents: Sequence[Descent],
    phase: ProgressPhase,
    task: Task | None = None,
    means: Means = AUTO,
) -> Iterator[LocalMinimum]:
    """Yield the local minima of descents in their order, as they become available.

    An infeasible start is first moved to a minimum of the violation; failed searches are omitted.
    Workers run the searches of a task. Raises ComputationError if every search fails.
    """
    problem.heard = phase.report_if_slow
    minima, error = 0, None
    ends = run_in_order(
        task,
        descents,
        means,
        lambda descent: _run_job(problem, descent),
        lambda record: record.join(problem),
        lambda: phase.report_if_slow(problem.best_objective),
    )
    for done, end in enumerate(ends, 1):
        if isinstance(end, ComputationError):
            error = end
        else:
            minima += 1
            yield end
        phase.report(done, best=problem.best_objective)
    if error is not None and not minima:
        raise ComputationError(f"no start leads anywhere: {error.message}")


def search_from_points(
    problem: Problem, starts: Sequence[Array], most_iterations: int | None = None
) -> list[LocalMinimum]:
    """Return the local minima from points u (p,), with a single search for coinciding starts."""
    minima: list[LocalMinimum] = []
    for start in starts:
        twins = (
            end
            for other, end in zip(starts, minima, strict=False)
            if np.abs(other - start).max() <= SAME_START
        )
        minima.append(next(twins, None) or search_locally(problem, start, most_iterations))
    return minima
