"""Requirements of a planting device against their limits: the evaluation of a design, and
optimisation constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from planter.engine.infeasibility import explain_infeasibility
from planter.engine.problem import DesignProblem
from planter.engine.solvers.constraints import (
    FEASIBILITY_TOLERANCE,
    ConstraintReading,
    Constraints,
)
from planter.engine.solvers.feasibility import ViolationMinimum
from planter.errors import PlanterError
from planter.kernels import Array
from planter.numerics.arrays import LastCallCache, to_degrees
from planter.papers.planting.angle_functions import TOOTH, AngleFunction
from planter.papers.planting.model import Device
from planter.papers.planting.requirement_rows import (
    ABSOLUTE,
    STRICT_MARGIN,
    RequirementRow,
    RequirementRows,
)
from planter.papers.planting.requirements_section import BY_NAME, RequirementKind, Requirements
from planter.papers.planting.results import RequirementResult, Violation

INVERSE = "curvature_radius"
"""The requirement on 1/row: its rows are curvatures [1/m]."""


def compute_bounds(measures: RequirementRows) -> tuple[Array, Array, Array]:
    """Return lower and upper bounds of every row, margins included, in steps, and the steps in
    which violations are counted in SI, (k,) each.
    """
    kinds = [row.kind for row in measures.rows]
    step = np.array([_step(measures.section, kind) for kind in kinds])
    lower, upper = np.array([_pair(measures.section, kind) for kind in kinds], dtype=float).T
    return lower / step, upper / step, step


def measure_excess(measures: RequirementRows, x: Array) -> Array:
    """Return by how many steps each row exceeds its bounds at a design (p,), negative inside."""
    lower, upper, step = compute_bounds(measures)
    values = measures.at(x).values / step
    return np.maximum(lower - values, values - upper)


def to_display_unit(row: RequirementRow, value: float) -> float:
    """Return a row's value as the requirement's number in the display unit: an absolute value, or a
    radius.
    """
    if row.kind.name == INVERSE:
        value = 1 / value
    return (abs(value) if row.kind.name in ABSOLUTE else value) / row.kind.factor


def display_limits(
    section: Requirements, kind: RequirementKind
) -> tuple[float | None, float | None]:
    """Return lower and upper limit in the units of the file."""
    return section.limit(kind.name, "min"), section.limit(kind.name, "max")


def _compute_margins(low: float | None, high: float | None, value: float) -> dict[str, float]:
    """Return how far a value is inside the limit of each side; infinite without one."""
    return {
        "min": np.inf if low is None else value - low,
        "max": np.inf if high is None else high - value,
    }


def compute_margin(section: Requirements, kind: RequirementKind, value: float) -> float:
    """Return how far a value in the display unit is inside the nearest limit; negative outside."""
    low, high = display_limits(section, kind)
    return min(margin for margin in _compute_margins(low, high, value).values() if margin < np.inf)


def suggest_limit(section: Requirements, name: str, value: float) -> tuple[str, float, float]:
    """Return the key of the limit that a value violates, the limit, and one that it satisfies with
    margin.
    """
    kind = BY_NAME[name]
    low, high = display_limits(section, kind)
    margin = section.limit(name, "margin") or 0.0
    margins = _compute_margins(low, high, value)
    side = min(margins, key=margins.__getitem__)
    limit = low if side == "min" else high
    assert limit is not None
    strict = 2 * STRICT_MARGIN / kind.factor if name == "pitch_curvature" else 0.0
    return kind.key(side), limit, value - margin - strict if side == "min" else value + margin


def _pair(section: Requirements, kind: RequirementKind) -> tuple[float, float]:
    margin = section.limit(kind.name, "margin") or 0.0
    low, high = display_limits(section, kind)
    lower = -np.inf if low is None else (low + margin) * kind.factor
    upper = np.inf if high is None else (high - margin) * kind.factor
    if kind.name in ABSOLUTE:
        return -upper, upper
    if kind.name == INVERSE:
        return -np.inf, 1 / lower
    return (lower + STRICT_MARGIN if kind.name == "pitch_curvature" else lower), upper


def _step(section: Requirements, kind: RequirementKind) -> float:
    step = kind.step * kind.factor
    if kind.name != INVERSE:
        return step
    # A step of the radius from the limit, as a difference of curvatures
    radius = (section.limit(kind.name, "min") or 0.0) * kind.factor
    return step / radius / (radius + step)


def evaluate_device_requirements(device: Device) -> list[RequirementResult] | None:
    """Return the requirements at the design of the machine file, None if it has no
    [requirements].
    """
    return (
        evaluate_requirements(RequirementRows(device), device.design)
        if device.machine.limits_motion
        else None
    )


def evaluate_requirements(measures: RequirementRows, x: Array) -> list[RequirementResult]:
    """Return every requirement of the file at a design (p,): value, limits, margins, verdict and
    angle.

    `margin` is how far the value is inside the nearest limit, in the requirement's unit; `phi_deg`
    is the carrier angle of side 1 at which the value occurs, None if it belongs to no angle.
    """
    excess = measure_excess(measures, x)
    of_kinds = (
        [k for k, row in enumerate(measures.rows) if row.kind is kind] for kind in measures.kinds
    )
    return [_evaluate_row(measures, x, max(rows, key=lambda k: excess[k])) for rows in of_kinds]


def _evaluate_row(measures: RequirementRows, x: Array, index: int) -> RequirementResult:
    """Return the result of the requirement of a row, which is its worst."""
    section, machine, row = measures.section, measures.device.machine, measures.rows[index]
    kind, angle = row.kind, find_carrier_angle(measures, x, index)
    number = to_display_unit(row, float(measures.at(x).values[index]))
    lower, upper = display_limits(section, kind)
    margin, required_margin = (
        compute_margin(section, kind, number),
        section.limit(kind.name, "margin") or 0.0,
    )
    side = "min" if lower is not None else "max"
    return RequirementResult(
        name=kind.name,
        value=number,
        unit=kind.unit,
        lower=lower,
        upper=upper,
        margin=margin,
        phi_deg=None if angle is None else to_degrees(angle),
        wanted_margin=required_margin,
        verdict=judge_margin(kind, margin, required_margin),
        meaning=kind.meaning,
        of=row.subject or None,
        origin=machine.origin(f"requirements.{kind.key(side)}"),
    )


ANGLE_TOLERANCE = 1e-9
"""By how much rounding may put an angle outside its cycle [rad]."""
MARGIN_TOLERANCE = 1e-7
"""Share of the requirement's step by which a satisfied margin may fall short."""


def judge_margin(kind: RequirementKind, margin: float, required_margin: float) -> str:
    """Return `pass`, `pass without margin` or `fail`; a curvature must exceed its limit."""
    slack = MARGIN_TOLERANCE * kind.step
    if margin < -slack or (kind.name == "pitch_curvature" and margin <= 0):
        return "fail"
    return "pass" if margin >= required_margin - slack else "pass without margin"


def find_carrier_angle(measures: RequirementRows, x: Array, index: int) -> float | None:
    """Return the carrier angle of side 1 of a row at a design [rad], None for the spacing, which
    has no angle.
    """
    row, angle = measures.rows[index], float(measures.at(x).angles[index])
    if row.kind.name == "spacing":
        return None
    return _find_contact_angle(measures, x, row, angle) if row.kind.name in TOOTH else angle


def _find_contact_angle(
    measures: RequirementRows, x: Array, row: RequirementRow, u: float
) -> float:
    """Return the carrier angle in [0, 2 pi] at which the position u of a segment is in contact
    [rad].
    """
    device = measures.device
    polar = device.stages[row.stage].polar(u=[u], parameters=device.of_stage(row.stage, x))
    target = float(polar["t_second" if row.second else "t_first"][0, 0])
    z = np.concatenate([x, device.constants, device.prologue(x).h])
    contact = AngleFunction(measures.motion.kernel(f"contact{row.stage + 1}"), z=z)
    start = contact.value(0.0)
    level = start + (target - start) % (2 * np.pi)
    return contact.find_crossing(level, -ANGLE_TOLERANCE, 2 * np.pi + ANGLE_TOLERANCE)


class RequirementConstraints(Constraints):
    """The rows of a device's requirements, margins included; designs x are (p,) in SI."""

    def __init__(self, device: Device) -> None:
        self.measures = RequirementRows(device)
        self.lower, self.upper, self.step = compute_bounds(self.measures)
        self.kinds = self.measures.kinds
        names = [kind.name for kind in self.kinds]
        self.owner = np.array([names.index(row.kind.name) for row in self.measures.rows])
        self._slopes = LastCallCache(lambda x: self.measures.slopes(x) / self.step[:, None])

    @classmethod
    def from_device(cls, device: Device) -> RequirementConstraints | None:
        """Return the constraints of the machine file, or None if it has no [requirements]."""
        return cls(device) if device.machine.limits_motion else None

    def values(self, x: Array) -> Array:
        """Return the rows in steps. Raises ComputationError if a design has no values."""
        scaled: Array = self.measures.at(x).values / self.step
        return scaled

    def slopes(self, x: Array) -> Array:
        """Return the gradients of the rows, (k, p)."""
        return self._slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the weighted sum (p, p) of the rows' Hessians."""
        return self.measures.curvature(x, weights / self.step)

    def read(self, x: Array) -> Sequence[ConstraintReading | None]:
        """Return the requirements at a design x (p,), each with its limit in the file."""
        section, readings = self.measures.section, []
        for entry in self.record(x):
            key, limit, _ = suggest_limit(section, entry.name, entry.value)
            sign = 1 if key == BY_NAME[entry.name].key("max") else -1
            readings.append(ConstraintReading(entry.value, limit, f"{key} =", sign))
        return readings

    def record(self, x: Array) -> list[RequirementResult]:
        """Return every requirement at a design (p,), as results give it."""
        return evaluate_requirements(self.measures, x)


class InfeasibleRequirementsError(PlanterError):
    """No design was found that satisfies the requirements; `violations` are the smallest, at
    `design` (p,) in SI.
    """

    name = "Infeasible"
    partial: dict[str, Any]

    def __init__(
        self,
        message: str,
        violations: list[Violation],
        partial: dict[str, Any],
        design: Array,
    ) -> None:
        super().__init__(message)
        self.violations, self.partial, self.design = violations, partial, design


def build_infeasibility_error(
    required: RequirementConstraints,
    problem: DesignProblem,
    violation: ViolationMinimum,
    starts: int,
    suffix: str = "",
) -> InfeasibleRequirementsError:
    """Return the error for the smallest violation, which searches of a problem from some `starts`
    ended with.

    `suffix` says which designs were considered, if not all within the bounds.
    """
    x = problem.design(violation.u)
    infeasibility = explain_infeasibility(problem, violation, starts, suffix)
    entries = required.record(x)
    broken = np.flatnonzero(violation.excess[: len(entries)] > FEASIBILITY_TOLERANCE)
    violations = [_violation(required, entries[k]) for k in broken]
    partial = {
        **infeasibility.table(),
        "violations": [violated.table() for violated in violations],
        "design": required.measures.device.named(x),
        "requirements": [entry.table() for entry in entries],
    }
    return InfeasibleRequirementsError(str(infeasibility), violations, partial, x)


def _violation(required: RequirementConstraints, entry: RequirementResult) -> Violation:
    key, limit, new = suggest_limit(required.measures.section, entry.name, entry.value)
    return Violation(
        entry.name, abs(new - limit), entry.unit, entry.phi_deg, entry.value, key, limit, new
    )
