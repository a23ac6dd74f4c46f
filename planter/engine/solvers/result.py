"""Result of an optimisation: optimum, certificate and history.

An objective may be constant along some directions: scaling both gears of a pair, say, leaves the
curve the same. Among equal optima, the result is the one nearest to the initial design, so that it
does not depend on where a search happens to end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.engine.solvers import certificate, sqp
from planter.engine.solvers.certificate import ActiveBound, ActiveConstraint
from planter.engine.solvers.local_search import AGREEMENT_TOLERANCE, LocalMinimum
from planter.engine.solvers.objective import ObjectiveEvaluation
from planter.engine.solvers.problem import Problem
from planter.errors import ComputationError
from planter.files.record import Record
from planter.kernels import Array

EQUALITY_TOLERANCE = 1e-10
"""Objectives that differ by less than this share of the scale of the problem are equal."""
MOVE_TOLERANCE = 1e-9
"""Moves shorter than this count as zero, in units of the box."""
MAX_MOVES = 4


def select_nearest_optimum(problem: Problem, u: Array) -> Array:
    """Return the point (p,) nearest to the initial design among the optima connected to u (p,) by
    insensitive directions.

    Each move is computed to first order and projected onto the equations. A move is halved while it
    raises the objective by more than rounding or violates a constraint.
    """
    optimum = problem.evaluate(u).objective
    for _ in range(MAX_MOVES):
        move = _compute_move(problem, u)
        while np.abs(move).max(initial=0.0) > MOVE_TOLERANCE and not _is_equal_optimum(
            problem, _apply_move(problem, u, move), optimum
        ):
            move = move / 2
        if np.abs(move).max(initial=0.0) <= MOVE_TOLERANCE:
            break
        u = _apply_move(problem, u, move)
    return u


def _apply_move(problem: Problem, u: Array, move: Array) -> Array:
    return problem.onto(problem.box.inside(u + move))


def _is_equal_optimum(problem: Problem, u: Array, optimum: float) -> bool:
    return (
        problem.is_feasible(u)
        and problem.evaluate(u).objective - optimum <= EQUALITY_TOLERANCE * problem.scale
    )


def _compute_move(problem: Problem, u: Array) -> Array:
    """Return the move (p,) along the insensitive directions that leads nearest to the start, with
    constraints to first order.

    Minimises |u + directions' c - start|^2 over the coefficients c (k,) of the directions (k, p),
    within the box.
    """
    directions = problem.null_space(u)
    if not len(directions):
        return np.zeros(len(u))
    below, above = (np.maximum(slack, 0.0) for slack in problem.box.slack(u))
    rows, limits = [directions.T, -directions.T], [above, below]
    if problem.constraints is not None:
        x = problem.design(u)
        constraints = problem.constraints.at(x)
        slopes = constraints.slopes(x) * problem.box.unit @ directions.T
        values = constraints.values(x)
        for sign, slack in ((1, constraints.upper - values), (-1, values - constraints.lower)):
            finite = np.isfinite(slack)
            rows.append(sign * slopes[finite])
            limits.append(np.maximum(slack[finite], 0.0))
    unbounded = np.full(len(directions), np.inf)
    slope = directions @ (u - problem.start)
    bounds = (-unbounded, unbounded)
    solution = sqp.solve_quadratic_program(
        directions @ directions.T, slope, np.vstack(rows), np.concatenate(limits), bounds
    )
    return np.zeros(len(u)) if solution is None else solution.z @ directions


History = list[tuple[int, float]]
"""Improvements of the best objective: (number of evaluations, objective)."""


@dataclass(frozen=True)
class EvaluationCounts(Record):
    """Numbers of evaluations of the objective, its gradient and its Hessian."""

    objective: int
    gradient: int
    hessian: int


@dataclass(frozen=True)
class OptimalityCertificate(Record):
    """Evidence that a point is an optimum.

    `kkt_residual` is dimensionless, below 1e-6 at a local optimum. Of `starts` local searches,
    `agreeing_starts` ended at the objective of the optimum to 1e-6 of the scale of the problem;
    `spread` is the difference between the largest and the smallest objective they ended at. All
    three are 0 for a method without starts.
    """

    kkt_residual: float
    active_bounds: list[ActiveBound]
    active_constraints: list[ActiveConstraint]
    starts: int
    agreeing_starts: int
    spread: float


def certify_candidates(
    problem: Problem, u: Array, minima: Sequence[LocalMinimum]
) -> OptimalityCertificate:
    """Return the certificate of a point u (p,), given the minima that the local searches ended
    at.
    """
    multipliers = certificate.estimate_multipliers(problem, u)
    optimum = problem.score(problem.design(u)).objective
    reached = [minimum.objective for minimum in minima if problem.is_feasible(minimum.u)]
    return OptimalityCertificate(
        kkt_residual=certificate.check_conditions(problem, u, multipliers).worst,
        active_bounds=certificate.find_active_bounds(problem, multipliers),
        active_constraints=certificate.find_active_constraints(problem, u, multipliers),
        starts=len(minima),
        agreeing_starts=sum(
            value - optimum <= AGREEMENT_TOLERANCE * problem.scale for value in reached
        ),
        spread=max(reached) - min(reached) if reached else 0.0,
    )


@dataclass(frozen=True)
class WiderOptimum(Record):
    """The optimum of one local search within bounds twice as wide about an optimum, where these let
    values keep their sign.

    `bounds` are those of the values that were at a bound, by name, in the units of the file;
    `active_bounds` is how many are active again.
    """

    objective: float
    active_bounds: int
    bounds: dict[str, list[float]]
    design: dict[str, float]


@dataclass(frozen=True)
class OptimiserResult:
    """An optimum: `design` x (p,), its evaluation, certificate and cost.

    `history` has an entry for each method that ran; `seconds` is the duration [s]; `searches` says
    in a sentence what ran, and why. `wider` is the optimum within wider bounds, None if no bound is
    active or none was searched for.
    """

    method: str
    seed: int
    design: Array
    evaluation: ObjectiveEvaluation
    start_objective: float
    evaluations: EvaluationCounts
    seconds: float
    certificate: OptimalityCertificate
    history: dict[str, History]
    searches: str = ""
    wider: WiderOptimum | None = None

    @property
    def objective(self) -> float:
        return self.evaluation.objective


class NoFeasiblePointError(ComputationError):
    """No method ended at a feasible point; `points` (p,) are where they ended."""

    def __init__(self, points: Sequence[Array]) -> None:
        super().__init__("no design was found that satisfies the constraints")
        self.points = points


def build_result(
    problem: Problem, points: Sequence[Array], minima: Sequence[LocalMinimum], **parts: Any
) -> OptimiserResult:
    """Return the best of candidate points u (p,) with its certificate; `minima` are those of the
    local searches, `parts` the other fields of the result.

    Among equal objectives, the point with the smallest residual is selected, and then the point
    nearest to the initial design along insensitive directions. Equations are satisfied to rounding.
    The evaluations of this selection do not count. Raises NoFeasiblePointError if no point is
    feasible.
    """
    judged = problem.anew()
    judged.restart()
    feasible = [judged.onto(u) for u in points if judged.is_feasible(u)]
    if not feasible:
        raise NoFeasiblePointError(points)
    # Once: last digits depend on earlier loop closures.
    objectives = [judged.evaluate(u).objective for u in feasible]
    best = min(objectives)
    ties = [u for u, objective in zip(feasible, objectives, strict=True) if objective == best]
    u = select_nearest_optimum(
        judged, min(ties, key=lambda point: certificate.kkt_residual(judged, point))
    )
    return OptimiserResult(
        design=judged.design(u),
        evaluation=judged.evaluate(u),
        start_objective=problem.reference.objective,
        certificate=certify_candidates(judged, u, minima),
        **parts,
    )
