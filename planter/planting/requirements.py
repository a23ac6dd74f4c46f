"""Requirements of a planting device against their limits: the evaluation of a design, and optimisation constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.errors import PlanterError
from planter.kernels import Array
from planter.numerics.arrays import LastCallCache, to_degrees
from planter.optimise.constraints import KEPT, Constraints
from planter.optimise.elastic import Least
from planter.planting.angle_functions import TOOTH, AngleFunction
from planter.planting.model import Device
from planter.planting.requirement_rows import ABSOLUTE, STRICT, RequirementRow, RequirementRows
from planter.planting.requirements_section import BY_NAME, RequirementKind, Requirements
from planter.planting.results import Requirement, Violation

INVERSE = "curvature_radius"
"""The requirement on 1/row: its rows are curvatures [1/m]."""


@dataclass(frozen=True)
class RowBounds:
    """Bounds (k,) on the rows of `RequirementRows` and the size (k,) in which their violations are counted, in SI.

    With margins these are what an optimum has to keep, without them what the file limits.
    """

    lower: Array
    upper: Array
    step: Array

    def excess(self, values: Array) -> Array:
        """By how many steps each row is beyond its bounds, negative inside, (k,)."""
        return np.maximum(self.lower - values, values - self.upper) / self.step


def compute_bounds(measures: RequirementRows, margins: bool = True) -> RowBounds:
    """The bounds of every row."""
    pairs = [_pair(measures.section, row.kind, margins) for row in measures.rows]
    lower, upper = np.array(pairs, dtype=float).T
    return RowBounds(lower, upper, np.array([_step(measures.section, row.kind) for row in measures.rows]))


def to_display_unit(row: RequirementRow, value: float) -> float:
    """A row's value as the requirement's number in the shown unit: a size, or a radius."""
    if row.kind.name == INVERSE:
        value = 1 / value
    return (abs(value) if row.kind.name in ABSOLUTE else value) / row.kind.factor


def display_limits(section: Requirements, kind: RequirementKind) -> tuple[float | None, float | None]:
    """Lower and upper limit as the file has them."""
    return section.limit(kind.name, "min"), section.limit(kind.name, "max")


def compute_margin(section: Requirements, kind: RequirementKind, value: float) -> float:
    """How far a shown value is inside the nearest limit; negative outside."""
    low, high = display_limits(section, kind)
    rooms = [value - low] if low is not None else []
    return min([*rooms, *([high - value] if high is not None else [])])


def suggest_limit(section: Requirements, name: str, value: float) -> tuple[str, float, float]:
    """Key of the limit that a shown value misses, the limit, and the one that it keeps, margin included."""
    kind = BY_NAME[name]
    low, high = display_limits(section, kind)
    margin = section.limit(name, "margin") or 0.0
    rooms = {"min": np.inf if low is None else value - low, "max": np.inf if high is None else high - value}
    side = min(rooms, key=lambda which: rooms[which])
    old = low if side == "min" else high
    assert old is not None
    strict = 2 * STRICT / kind.factor if name == "pitch_curvature" else 0.0
    return kind.key(side), old, value - margin - strict if side == "min" else value + margin


def _pair(section: Requirements, kind: RequirementKind, margins: bool) -> tuple[float, float]:
    margin = (section.limit(kind.name, "margin") or 0.0) if margins else 0.0
    low, high = display_limits(section, kind)
    lower = -np.inf if low is None else (low + margin) * kind.factor
    upper = np.inf if high is None else (high - margin) * kind.factor
    if kind.name in ABSOLUTE:
        return -upper, upper
    if kind.name == INVERSE:
        return -np.inf, 1 / lower
    return (lower + STRICT if kind.name == "pitch_curvature" else lower), upper


def _step(section: Requirements, kind: RequirementKind) -> float:
    step = kind.step * kind.factor
    if kind.name != INVERSE:
        return step
    least = (section.limit(kind.name, "min") or 0.0) * kind.factor
    return step / least / (least + step)


def evaluate_device_requirements(device: Device) -> list[Requirement] | None:
    """The requirements at the machine's own design; None where its file has none."""
    return (
        None if device.machine.requirements is None else evaluate_requirements(RequirementRows(device), device.design)
    )


def evaluate_requirements(measures: RequirementRows, x: Array) -> list[Requirement]:
    """Every requirement of the file at a design (p,): value, limits, margins, verdict, and where it stands.

    `margin` is how far the value is inside the nearest limit, in the requirement's unit; `phi_deg` is the carrier angle
    of side 1 where the value stands, None for what stands nowhere.
    """
    found = measures.at(x)
    excess = compute_bounds(measures).excess(found.values)
    entries = []
    for kind in measures.kinds:
        mine = [k for k, row in enumerate(measures.rows) if row.kind is kind]
        worst = max(mine, key=lambda k: excess[k])
        row = measures.rows[worst]
        entries.append(
            build_entry(measures, kind, row, float(found.values[worst]), find_carrier_angle(measures, x, worst))
        )
    return entries


def build_entry(
    measures: RequirementRows, kind: RequirementKind, row: RequirementRow, value: float, angle: float | None
) -> Requirement:
    """One requirement, as results show it."""
    section, machine = measures.section, measures.device.machine
    number = to_display_unit(row, value)
    lower, upper = display_limits(section, kind)
    margin, wanted = compute_margin(section, kind, number), section.limit(kind.name, "margin") or 0.0
    side = "min" if lower is not None else "max"
    return Requirement(
        name=kind.name,
        value=number,
        unit=kind.unit,
        lower=lower,
        upper=upper,
        margin=margin,
        phi_deg=None if angle is None else to_degrees(angle),
        wanted_margin=wanted,
        verdict=judge_margin(kind, margin, wanted),
        meaning=kind.meaning,
        of=row.of or None,
        origin=machine.origin(f"requirements.{kind.key(side)}"),
    )


BESIDE = 1e-9
"""What rounding may put an angle out of its turn [rad]."""
ROUNDING = 1e-7
"""A margin may be short by this share of the requirement's step and is still kept."""


def judge_margin(kind: RequirementKind, margin: float, wanted: float) -> str:
    """`pass`, `pass without margin` or `fail`; a curvature has to be above its limit."""
    slack = ROUNDING * kind.step
    if margin < -slack or (kind.name == "pitch_curvature" and margin <= 0):
        return "fail"
    return "pass" if margin >= wanted - slack else "pass without margin"


def find_carrier_angle(measures: RequirementRows, x: Array, index: int) -> float | None:
    """Carrier angle of side 1 where a row stands at a design [rad]; None for the spacing, which stands nowhere."""
    row, place = measures.rows[index], float(measures.at(x).places[index])
    if row.kind.name == "spacing":
        return None
    return _meshing(measures, x, row, place) if row.kind.name in TOOTH else place


def _meshing(measures: RequirementRows, x: Array, row: RequirementRow, u: float) -> float:
    """Carrier angle in [0, 2 pi] at which the place u of a segment is in contact [rad]."""
    device = measures.device
    both = device.stages[row.stage].polar(u=[u], parameters=device.of_stage(row.stage, x))
    wanted = float(both["t_second" if row.second else "t_first"][0, 0])
    z = np.concatenate([x, device.constants, device.prologue(x).h])
    contact = AngleFunction(measures.motion.contact_kernels[row.stage], z=z)
    start = contact.value(0.0)
    level = start + (wanted - start) % (2 * np.pi)
    return contact.crossing(level, -BESIDE, 2 * np.pi + BESIDE)


class RequirementConstraints(Constraints):
    """The rows of a device's requirements, margins included; designs x are (p,) in SI."""

    def __init__(self, device: Device) -> None:
        self.measures = RequirementRows(device)
        self.limits = compute_bounds(self.measures)
        self.step = self.limits.step
        self.lower, self.upper = self.limits.lower / self.step, self.limits.upper / self.step
        self.kinds = self.measures.kinds
        names = [kind.name for kind in self.kinds]
        self.owner = np.array([names.index(row.kind.name) for row in self.measures.rows])
        self._slopes = LastCallCache(lambda x: self.measures.slopes(x) / self.step[:, None])

    @classmethod
    def from_device(cls, device: Device) -> RequirementConstraints | None:
        """Those of the machine file; None where it has none."""
        return None if device.machine.requirements is None else cls(device)

    def values(self, x: Array) -> Array:
        """The rows, in steps. Raises ComputationError where a design has none."""
        scaled: Array = self.measures.at(x).values / self.step
        return scaled

    def slopes(self, x: Array) -> Array:
        """Gradients of the rows, (k, p)."""
        return self._slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Weighted sum (p, p) of the rows' Hessians."""
        return self.measures.curvature(x, weights / self.step)

    def record(self, x: Array) -> list[Requirement]:
        """Every requirement at a design (p,), as results show it."""
        return evaluate_requirements(self.measures, x)


class InfeasibleRequirementsError(PlanterError):
    """No design in the box keeps the requirements; `violations` are the least found, at `design` (p,) in SI."""

    name = "Infeasible"

    def __init__(self, violations: list[Violation], partial: dict[str, Any], design: Array, of: str = "") -> None:
        told = "; ".join(map(str, violations))
        plural = "one of them is" if len(violations) == 1 else "these are"
        super().__init__(f"no design{of} within the bounds keeps all requirements, and {plural} nearest to it: {told}")
        self.violations, self.partial, self.design = violations, partial, design


def build_infeasibility_error(
    required: RequirementConstraints, x: Array, least: Least, of: str = ""
) -> InfeasibleRequirementsError:
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
    return InfeasibleRequirementsError(violations, partial, x, of)


def _violation(required: RequirementConstraints, entry: Requirement) -> Violation:
    key, limit, new = suggest_limit(required.measures.section, entry.name, entry.value)
    return Violation(entry.name, abs(new - limit), entry.unit, entry.phi_deg, entry.value, key, limit, new)
