"""What an optimisation found, how sure it is and how it got there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise import certificate, flat
from planter.optimise.certificate import ActiveBound, ActiveConstraint
from planter.optimise.descent import Minimum
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Counts, Problem
from planter.optimise.starts import AGREEING

History = list[tuple[int, float]]
"""When each best so far was met: (evaluations, objective)."""


@dataclass(frozen=True)
class Certificate:
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


def certified(problem: Problem, u: Array, minima: Sequence[Minimum]) -> Certificate:
    """The certificate of a point u (p,), beside the minima that the starts ended at."""
    multipliers = certificate.best_multipliers(problem, u)
    least = problem.score(problem.design(u)).objective
    reached = [minimum.objective for minimum in minima if problem.kept(minimum.u)]
    return Certificate(
        kkt_residual=certificate.check(problem, u, multipliers).worst,
        active_bounds=certificate.active_bounds(problem, multipliers),
        active_constraints=certificate.active_constraints(problem, multipliers),
        starts=len(minima),
        agreeing_starts=sum(value - least <= AGREEING * problem.scale for value in reached),
        spread=max(reached) - min(reached) if reached else 0.0,
    )


@dataclass(frozen=True)
class Result:
    """An optimum: `design` x (p,), its evaluation, and how it was found.

    `history` has one entry for each method that ran.
    """

    method: str
    seed: int
    design: Array
    evaluation: Evaluation
    start_objective: float
    evaluations: Counts
    seconds: float
    certificate: Certificate
    history: dict[str, History]

    @property
    def objective(self) -> float:
        return self.evaluation.objective


@dataclass(frozen=True)
class Candidates:
    """What the methods brought home: points u (p,) of the box to choose from, minima of the starts, traces."""

    points: list[Array]
    minima: list[Minimum]
    counts: Counts
    history: dict[str, History]


class NoFeasiblePointError(ComputationError):
    """No method ended at a feasible point; `points` (p,) are where they ended."""

    def __init__(self, points: Sequence[Array]) -> None:
        super().__init__("no design was found that satisfies the constraints")
        self.points = points


def result(problem: Problem, method: str, seed: int, found: Candidates, seconds: float) -> Result:
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
    u = flat.nearest(judged, min(ties, key=lambda point: certificate.kkt_residual(judged, point)))
    return Result(
        method=method, seed=seed, design=judged.design(u), evaluation=judged.evaluate(u),
        start_objective=problem.reference.objective, evaluations=found.counts, seconds=seconds,
        certificate=certified(judged, u, found.minima), history=found.history,
    )  # fmt: skip
