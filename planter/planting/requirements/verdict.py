"""Requirements that no design keeps: which one has to give way, at which angle, by how much."""

from __future__ import annotations

from typing import Any

import numpy as np

from planter.errors import PlanterError
from planter.kernels import Array
from planter.optimise.constraints import KEPT
from planter.optimise.elastic import Least
from planter.planting.requirements.constraints import Required
from planter.planting.requirements.limits import relaxed
from planter.planting.results import Requirement, Violation


class Infeasible(PlanterError):
    """No design in the box keeps the requirements; `violations` are the least found, at `design` (p,) in SI."""

    def __init__(self, violations: list[Violation], partial: dict[str, Any], design: Array, of: str = "") -> None:
        told = "; ".join(map(str, violations))
        plural = "one of them is" if len(violations) == 1 else "these are"
        super().__init__(f"no design{of} within the bounds keeps all requirements, and {plural} nearest to it: {told}")
        self.violations, self.partial, self.design = violations, partial, design


def infeasible(required: Required, x: Array, least: Least, of: str = "") -> Infeasible:
    """What the least violation that was found, at a design x (p,), says of the requirements.

    `of` says which designs were looked at, where not all within the bounds.
    """
    entries = required.record(x)
    broken = np.flatnonzero(least.excess[: len(entries)] > KEPT)
    violations = [_violation(required, entries[k]) for k in broken]
    partial = {
        "violations": [one.table() for one in violations],
        "design": required.measures.device.named(x),
        "requirements": [entry.table() for entry in entries],
    }
    return Infeasible(violations, partial, x, of)


def _violation(required: Required, entry: Requirement) -> Violation:
    key, limit, new = relaxed(required.measures.section, entry.name, entry.value)
    return Violation(entry.name, abs(new - limit), entry.unit, entry.phi_deg, entry.value, key, limit, new)
