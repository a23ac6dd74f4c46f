"""Is there a design that keeps all requirements? If not: which one cannot be kept, at which angle, by how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.errors import PlanterError
from planter.kernels import Array
from planter.optimise.constraints import KEPT, Constraints
from planter.optimise.elastic import Least, least_violation
from planter.optimise.problem import Problem
from planter.planting import cycle
from planter.planting.requirements.limits import relaxed
from planter.planting.requirements.record import record

MOST_TRIED = 2
"""How many points the least violation is looked for from."""


@dataclass(frozen=True)
class Violation:
    """A requirement that has to give way: by `amount` in its unit its limit must be relaxed, to `relaxed`."""

    name: str
    amount: float
    unit: str
    phi_deg: float | None
    value: float
    key: str
    limit: float
    relaxed: float

    def __str__(self) -> str:
        place = f" at phi = {self.phi_deg:.6g} deg" if self.phi_deg is not None else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (
            f"{self.name} = {self.value:.6g}{unit}{place} misses {self.key} with its margin by {self.amount:.6g}{unit}"
        )


class Infeasible(PlanterError):
    """No design in the box keeps the requirements; `violations` are the least found, at `design` (p,) in SI."""

    def __init__(self, violations: list[Violation], partial: dict[str, Any], design: Array) -> None:
        told = "; ".join(map(str, violations))
        plural = "one of them is" if len(violations) == 1 else "these are"
        super().__init__(f"no design within the bounds keeps all requirements, and {plural} nearest to it: {told}")
        self.violations, self.partial, self.design = violations, partial, design


def point(problem: Problem, constraints: Constraints, starts: Sequence[Array]) -> Array:
    """A point u (p,) that keeps all constraints, looked for from those of `starts` with the least violation.

    Raises Infeasible, with the least violation found, where there is none.
    """
    nearest = sorted(starts, key=problem.violation)[:MOST_TRIED]
    found: list[Least] = []
    for start in nearest:
        found.append(least_violation(problem, constraints, start))
        if found[-1].kept:
            return found[-1].u
    raise verdict(problem, constraints, found)


def verdict(problem: Problem, constraints: Constraints, found: Sequence[Least]) -> Infeasible:
    """The least of the violations that were found, fewest requirements first."""
    best = min(found, key=lambda least: (int((least.excess > KEPT).sum()), least.total))
    x = problem.design(best.u)
    entries = record(constraints.measures, x)
    device = constraints.measures.device
    broken = [entries[k] for k in np.flatnonzero(best.excess > KEPT)]
    violations = [_violation(constraints, entry) for entry in broken]
    partial = {
        "violations": [vars(one).copy() for one in violations],
        "design": cycle.shown_design(device, x),
        "requirements": entries,
    }
    return Infeasible(violations, partial, x)


def _violation(constraints: Constraints, entry: dict[str, Any]) -> Violation:
    key, limit, new = relaxed(constraints.measures.section, entry["name"], entry["value"])
    return Violation(entry["name"], abs(new - limit), entry["unit"], entry["phi_deg"], entry["value"], key, limit, new)
