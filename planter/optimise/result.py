"""What an optimisation found, how sure it is and how it got there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from planter import errors
from planter.kernels import Array
from planter.optimise import certificate
from planter.optimise.certificate import ActiveBound, ActiveRequirement
from planter.optimise.descent import Minimum
from planter.optimise.directions import sensitivity
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Counts, Problem, Sampling
from planter.optimise.starts import AGREEING

History = list[tuple[int, float]]
"""When each best so far was met: (turns evaluated, objective)."""


@dataclass(frozen=True)
class Certificate:
    """How sure an optimum is.

    `kkt_residual` is dimensionless, below 1e-6 at a local optimum. Of `starts` descents, `agreeing_starts` ended at the
    optimum's objective to 1e-6 of the objective of the machine's own design; `spread` is the difference between the
    largest and the least objective they ended at. A method without starts has 0, 0 and 0.
    """

    kkt_residual: float
    active_bounds: list[ActiveBound]
    starts: int
    agreeing_starts: int
    spread: float
    active_requirements: list[ActiveRequirement] = field(default_factory=list)


@dataclass(frozen=True)
class Result:
    """An optimum: `design` x (p,) in SI, its evaluation, and how it was found.

    `insensitive` spans the directions that the force does not feel at the optimum, each [{name: weight}, ...] in
    parts of the box width: along these the design is not determined. `history` has one entry for each method that
    ran.
    """

    method: str
    sampling: Sampling
    seed: int
    names: tuple[str, ...]
    design: Array
    evaluation: Evaluation
    start_objective: float
    evaluations: Counts
    seconds: float
    certificate: Certificate
    effective_parameters: int
    insensitive: list[list[dict[str, float]]]
    history: dict[str, History] = field(default_factory=dict)
    requirements: list[dict[str, Any]] = field(default_factory=list)

    @property
    def objective(self) -> float:
        return self.evaluation.objective

    def _certificate(self) -> dict[str, Any]:
        """The certificate, with the requirements that hold the optimum where there are any to keep."""
        found = vars(self.certificate).copy()
        found["active_bounds"] = [vars(bound).copy() for bound in self.certificate.active_bounds]
        active = [vars(one).copy() for one in found.pop("active_requirements")]
        return found | ({"active_requirements": active} if self.requirements else {})

    def table(self, scale: Array) -> dict[str, Any]:
        """The result as the interface gives it, less the scores in both models; `scale` (p,) SI per shown unit."""
        shown = (self.design / scale).tolist()
        return {
            "method": self.method,
            "objective": self.objective,
            "design": dict(zip(self.names, shown, strict=True)),
            "range_N": self.evaluation.range_N,
            "variance_N2": self.evaluation.variance_N2,
            "start_objective": self.start_objective,
            "evaluations": vars(self.evaluations).copy(),
            "seconds": self.seconds,
            "certificate": self._certificate(),
            "effective_parameters": self.effective_parameters,
            "insensitive": self.insensitive,
            **({"requirements": self.requirements} if self.requirements else {}),
        }


class Interrupted(errors.Interrupted):
    """The user stopped an optimisation; `best` is the result so far, None if nothing was evaluated yet."""

    def __init__(self, best: Result | None, scale: Array | None = None) -> None:
        super().__init__(best.table(scale) if best is not None and scale is not None else None)
        self.best = best


@dataclass(frozen=True)
class Found:
    """What the methods brought home: points u (p,) of the box to choose from, minima of the starts, traces."""

    points: list[Array]
    minima: list[Minimum]
    counts: Counts
    history: dict[str, History]


def result(problem: Problem, method: str, seed: int, found: Found, seconds: float) -> Result:
    """The best of the points that were found, with its certificate.

    Of equal objectives the one with the least residual is taken. The evaluations needed here are not counted.
    """
    judged = Problem(problem.response, problem.objective, problem.sampling, problem.constraints)
    points = [u for u in found.points if judged.kept(u)]
    least = min(judged.evaluate(u).objective for u in points)
    ties = [u for u in points if judged.evaluate(u).objective == least]
    u = min(ties, key=lambda point: certificate.kkt_residual(judged, point))
    x = judged.design(u)
    insensitive = sensitivity(problem.response, x, problem.samples)
    return Result(
        method=method, sampling=problem.sampling, seed=seed, names=problem.response.names, design=x,
        evaluation=judged.evaluate(u), start_objective=problem.reference.objective, evaluations=found.counts,
        seconds=seconds, certificate=_certificate(judged, u, least, found.minima),
        effective_parameters=insensitive.effective_parameters, insensitive=insensitive.named, history=found.history,
        requirements=_requirements(problem, x),
    )  # fmt: skip


def _requirements(problem: Problem, x: Array) -> list[dict[str, Any]]:
    from planter.planting.requirements.record import record

    return [] if problem.constraints is None else record(problem.constraints.measures, x)


def _certificate(problem: Problem, u: Array, least: float, minima: list[Minimum]) -> Certificate:
    multipliers = certificate.best_multipliers(problem, u)
    reached = [minimum.evaluation.objective for minimum in minima if problem.kept(minimum.u)]
    return Certificate(
        kkt_residual=certificate.check(problem, u, multipliers).worst,
        active_bounds=certificate.active_bounds(problem, multipliers),
        starts=len(minima),
        agreeing_starts=sum(value - least <= AGREEING * problem.scale for value in reached),
        spread=max(reached) - min(reached) if reached else 0.0,
        active_requirements=certificate.active_requirements(problem, multipliers),
    )
