"""Which of many equal optima is told: the one nearest to the design to start from.

Along some directions an objective may not change at all: a pair of gears scaled as a whole leaves the curve as it was.
Where a search happens to end along them is chance; the rule makes it a fact of the problem.

What an optimisation found, how sure it is and how it got there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise import certificate, sqp
from planter.optimise.certificate import ActiveBound, ActiveConstraint
from planter.optimise.local_search import AGREEMENT_TOLERANCE, LocalMinimum
from planter.optimise.objective import ObjectiveEvaluation
from planter.optimise.problem import Counts, Problem

EQUALITY_TOLERANCE = 1e-10
"""Objectives are equal that differ by less than this share of the problem's scale."""
MOVE_TOLERANCE = 1e-9
"""A move below this, in the box's unit, is none."""
MAX_MOVES = 4


def select_nearest_optimum(problem: Problem, u: Array) -> Array:
    """The point (p,) nearest to the design to start from, of those that flat directions join to an optimum u (p,).

    Each move is to first order, then onto the equations; one that costs more than rounding, or breaks a constraint, is
    halved until it does not.
    """
    least = problem.evaluate(u).objective
    for _ in range(MAX_MOVES):
        move = _compute_move(problem, u)
        while np.abs(move).max(initial=0.0) > MOVE_TOLERANCE and not _is_equal_optimum(
            problem, _apply_move(problem, u, move), least
        ):
            move = move / 2
        if np.abs(move).max(initial=0.0) <= MOVE_TOLERANCE:
            break
        u = _apply_move(problem, u, move)
    return u


def _apply_move(problem: Problem, u: Array, move: Array) -> Array:
    return problem.onto(problem.box.inside(u + move))


def _is_equal_optimum(problem: Problem, u: Array, least: float) -> bool:
    return problem.kept(u) and problem.evaluate(u).objective - least <= EQUALITY_TOLERANCE * problem.scale


def _compute_move(problem: Problem, u: Array) -> Array:
    """The move (p,) along the flat directions that comes nearest to the start in the box, constraints to first order.

    Over shares c of the directions, the least |u + directions' c - start|^2.
    """
    directions = problem.flat(u)
    if not len(directions):
        return np.zeros(len(u))
    below, above = (np.maximum(room, 0.0) for room in problem.box.room(u))
    rows, most = [directions.T, -directions.T], [above, below]
    if problem.constraints is not None:
        x = problem.design(u)
        slopes = problem.constraints.slopes(x) * problem.box.unit @ directions.T
        values = problem.constraints.values(x)
        for sign, room in ((1, problem.constraints.upper - values), (-1, values - problem.constraints.lower)):
            finite = np.isfinite(room)
            rows.append(sign * slopes[finite])
            most.append(np.maximum(room[finite], 0.0))
    anywhere = np.full(len(directions), np.inf)
    slope = directions @ (u - problem.start)
    bounds = (-anywhere, anywhere)
    found = sqp.solve_quadratic_program(directions @ directions.T, slope, np.vstack(rows), np.concatenate(most), bounds)
    return np.zeros(len(u)) if found is None else found.z @ directions


History = list[tuple[int, float]]
"""When each best so far was met: (evaluations, objective)."""


@dataclass(frozen=True)
class OptimalityCertificate:
    """How sure an optimum is.

    `kkt_residual` is dimensionless, below 1e-6 at a local optimum. Of `starts` descents, `agreeing_starts` ended at the
    optimum's objective to 1e-6 of the problem's scale; `spread` is the difference between the largest and the least
    objective they ended at. A method without starts has 0, 0 and 0.
    """

    kkt_residual: float
    active_bounds: list[ActiveBound]
    active_constraints: list[ActiveConstraint]
    starts: int
    agreeing_starts: int
    spread: float


def certify_candidates(problem: Problem, u: Array, minima: Sequence[LocalMinimum]) -> OptimalityCertificate:
    """The certificate of a point u (p,), beside the minima that the starts ended at."""
    multipliers = certificate.estimate_multipliers(problem, u)
    least = problem.score(problem.design(u)).objective
    reached = [minimum.objective for minimum in minima if problem.kept(minimum.u)]
    return OptimalityCertificate(
        kkt_residual=certificate.check_conditions(problem, u, multipliers).worst,
        active_bounds=certificate.find_active_bounds(problem, multipliers),
        active_constraints=certificate.find_active_constraints(problem, multipliers),
        starts=len(minima),
        agreeing_starts=sum(value - least <= AGREEMENT_TOLERANCE * problem.scale for value in reached),
        spread=max(reached) - min(reached) if reached else 0.0,
    )


@dataclass(frozen=True)
class OptimiserResult:
    """An optimum: `design` x (p,), its evaluation, and how it was found.

    `history` has one entry for each method that ran.
    """

    method: str
    seed: int
    design: Array
    evaluation: ObjectiveEvaluation
    start_objective: float
    evaluations: Counts
    seconds: float
    certificate: OptimalityCertificate
    history: dict[str, History]

    @property
    def objective(self) -> float:
        return self.evaluation.objective


@dataclass(frozen=True)
class Candidates:
    """What the methods brought home: points u (p,) of the box to choose from, minima of the starts, traces."""

    points: list[Array]
    minima: list[LocalMinimum]
    counts: Counts
    history: dict[str, History]


class NoFeasiblePointError(ComputationError):
    """No method ended at a feasible point; `points` (p,) are where they ended."""

    def __init__(self, points: Sequence[Array]) -> None:
        super().__init__("no design was found that satisfies the constraints")
        self.points = points


def build_result(problem: Problem, method: str, seed: int, found: Candidates, seconds: float) -> OptimiserResult:
    """The best of the points that were found, with its certificate.

    Of equal objectives the one with the least residual is taken, and of all that flat directions join to it the one
    nearest to the design to start from. Equations are kept to rounding. The evaluations needed here are not counted.
    Raises NoFeasiblePointError if no point is feasible.
    """
    judged = problem.anew()
    judged.restart()
    points = [judged.onto(u) for u in found.points if judged.kept(u)]
    if not points:
        raise NoFeasiblePointError(found.points)
    objectives = [judged.evaluate(u).objective for u in points]  # once: digits depend on where loops closed before
    ties = [u for u, objective in zip(points, objectives, strict=True) if objective == min(objectives)]
    u = select_nearest_optimum(judged, min(ties, key=lambda point: certificate.kkt_residual(judged, point)))
    return OptimiserResult(
        method=method, seed=seed, design=judged.design(u), evaluation=judged.evaluate(u),
        start_objective=problem.reference.objective, evaluations=found.counts, seconds=seconds,
        certificate=certify_candidates(judged, u, found.minima), history=found.history,
    )  # fmt: skip
