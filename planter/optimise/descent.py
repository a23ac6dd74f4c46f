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
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planter.kernels import Array
from planter.optimise import certificate, direct, ipopt, sequential
from planter.optimise.conditions import Local
from planter.optimise.constraints import KEPT
from planter.optimise.epigraph import Epigraph
from planter.optimise.objective import Evaluation, Kinks
from planter.optimise.problem import Counts, Problem
from planter.optimise.samples import MARGIN, Hold

ROUNDS, CELLS = 12, 100
"""Most times that rows are added, and most cells that are visited."""
CONSTRAINED_CELLS = 4
"""The same where constraints are kept, whose rows take longer than the objective's."""
VIOLATED = 1e-9
"""A row violates an extreme if it exceeds it by more than this share of the range."""
STATIONARY = 1e-6
"""Residual of the certificate below which a point counts as optimal."""
FALLS = 1e-12
"""The objective falls if it does by more than this share of the problem's scale."""
SNAPS = (0.0, 1e-7, 1e-5, 1e-3)
"""Coordinates this close to their bounds, in the box's unit, are set onto them if that makes a better point."""


@dataclass(frozen=True)
class Minimum:
    """Where a descent ended: point u (p,), its evaluation, its residual (dimensionless) and the iterations it took.

    `violation` is that of the constraints, in steps; `converged` is what the solver says of the run that ended there.
    """

    u: Array
    evaluation: Evaluation
    residual: float
    iterations: int
    violation: float = 0.0
    converged: bool = True

    @property
    def stationary(self) -> bool:
        return self.residual < STATIONARY

    @property
    def settled(self) -> bool:
        """Whether the solver converged here, and the constraints are kept."""
        return self.violation <= KEPT and self.converged

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """The least of several is the best: one that keeps the constraints, is stationary, has the least objective."""
        return self.violation > KEPT, not self.stationary, self.objective

    @property
    def objective(self) -> float:
        return self.evaluation.objective

    def after(self, earlier: Minimum) -> Minimum:
        """With the iterations that went before."""
        return replace(self, iterations=self.iterations + earlier.iterations)


def descend(problem: Problem, start: Array, most_iterations: int | None = None, rounds: int = ROUNDS) -> Minimum:
    """Return the local minimum reached from a point u (p,) of the box.

    `most_iterations` limits each of the runs, the problem's own number if None, `rounds` how often rows are added.
    """
    most_iterations = problem.most_iterations if most_iterations is None else most_iterations
    found = _complete(problem, start, (), most_iterations, rounds)
    kinks = problem.objective.kinks
    if found.stationary or kinks is None:
        return found
    return _through_cells(problem, kinks, found, most_iterations)


def _complete(
    problem: Problem, start: Array, holds: Sequence[Hold], most_iterations: int, rounds: int = ROUNDS
) -> Minimum:
    """The minimum with joints held as told."""
    objective, constrained = problem.objective, problem.constraints is not None
    if objective.windows or holds or (constrained and objective.kinks is not None):
        found = sequential.minimum(problem, start, holds, 2 * most_iterations)
        return replace(_minimum(problem, found.u, found.iterations), converged=found.converged)
    return _interior(problem, start, problem.local(start, holds), most_iterations, rounds)


def _interior(problem: Problem, start: Array, local: Local, most_iterations: int, rounds: int) -> Minimum:
    """By IPOPT, with rows added until no other exceeds the bounds on them."""
    u, iterations, found = start, 0, []
    for _ in range(rounds):
        programme = Epigraph(problem, local, u)
        solution = _solved(programme, most_iterations)
        iterations += solution.iterations
        u = problem.box.inside(programme.point(solution.z))
        found.append(replace(_minimum(problem, u, iterations), converged=solution.converged))
        high, low = programme.limits(solution.z, VIOLATED)
        look = found[-1].evaluation.look
        complete = look.high <= high and look.low >= low
        if found[-1].stationary or complete or not solution.converged:
            break
        local = local.grown(problem.design(u), high, low)
    best = min(found, key=lambda minimum: minimum.rank)
    return replace(best, iterations=iterations)


def _solved(programme: Epigraph, most_iterations: int) -> ipopt.Solution:
    """By compiled functions where the programme has them; they do their own counting."""
    compiled = direct.functions(programme)
    solution = ipopt.solve(programme, programme.start, most_iterations, compiled)
    if compiled:
        called = Counts(*(solution.calls[name] for name in ("nlp_f", "nlp_grad_f", "nlp_hess_l")))
        programme.problem.counts = programme.problem.counts + called
    return solution


def _through_cells(problem: Problem, kinks: Kinks, found: Minimum, most_iterations: int) -> Minimum:
    """From cell to cell until a minimum inside one or on a kink is found, or the objective falls no more."""

    def solved(minimum: Minimum, holds: list[Hold]) -> Minimum:
        return _complete(problem, minimum.u, tuple(holds), most_iterations).after(minimum)

    here = solved(found, [kinks.wall(pin, distance) for pin, distance in kinks.near(problem.design(found.u))])
    for _ in range(CELLS if problem.constraints is None else CONSTRAINED_CELLS):
        near = kinks.near(problem.design(here.u))
        touching = [i for i, (_, distance) in enumerate(near) if abs(distance) < 2 * MARGIN]
        if here.stationary or not touching:
            break
        walls = [kinks.wall(pin, distance) for pin, distance in near]
        on_kink = solved(here, [near[i][0] if i in touching else wall for i, wall in enumerate(walls)])
        if on_kink.stationary:
            return on_kink
        across = [kinks.wall(pin, -distance) for pin, distance in near]
        limit, spent = here.objective - FALLS * problem.scale, replace(here, iterations=on_kink.iterations)
        crossed = (solved(spent, [across[i] if i in choice else wall for i, wall in enumerate(walls)])
                   for choice in _choices(touching))  # fmt: skip
        following = next((minimum for minimum in crossed if minimum.objective < limit), None)
        if following is None:
            break
        here = following
    return min(found, here, key=lambda minimum: minimum.rank)


def _choices(touching: list[int]) -> list[list[int]]:
    """Which walls to cross: all that are touched, else one alone."""
    return [touching, *([i] for i in touching)] if len(touching) > 1 else [touching]


def at(problem: Problem, u: Array, iterations: int) -> Minimum:
    """What a point is as a minimum."""
    residual = certificate.kkt_residual(problem, u)
    return Minimum(u, problem.evaluate(u), residual, iterations, problem.violation(u))


def _minimum(problem: Problem, u: Array, iterations: int) -> Minimum:
    """Return a point with coordinates beside their bounds set onto them: an interior point is never quite there."""
    points = {p.tobytes(): p for p in (problem.complete(problem.box.snapped(u, s)) for s in SNAPS)}
    return min((at(problem, p, iterations) for p in points.values()), key=lambda minimum: minimum.rank)
