"""Requirements of a design set against their limits: what `simulate`, `validate` and `optimise` tell of them."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import to_degrees
from planter.planting.model import Device
from planter.planting.requirements.limits import limits, reserve, shown, shown_limits
from planter.planting.requirements.measures import Measures, Row
from planter.planting.requirements.pitch import TOOTH
from planter.planting.requirements.places import Course
from planter.planting.requirements.section import Kind
from planter.planting.results import Requirement


def of(device: Device) -> list[Requirement] | None:
    """The requirements at the machine's own design; None where its file has none."""
    return None if device.machine.requirements is None else record(Measures(device), device.design)


def record(measures: Measures, x: Array) -> list[Requirement]:
    """Every requirement of the file at a design (p,): value, limits, margins, verdict, and where it stands.

    `margin` is how far the value is inside the nearest limit, in the requirement's unit; `phi_deg` is the carrier angle
    of side 1 where the value stands, None for what stands nowhere.
    """
    found = measures.at(x)
    excess = limits(measures).excess(found.values)
    entries = []
    for kind in measures.kinds:
        mine = [k for k, row in enumerate(measures.rows) if row.kind is kind]
        worst = max(mine, key=lambda k: excess[k])
        row = measures.rows[worst]
        entries.append(entry(measures, kind, row, float(found.values[worst]), phi(measures, x, worst)))
    return entries


def entry(measures: Measures, kind: Kind, row: Row, value: float, angle: float | None) -> Requirement:
    """One requirement, as results show it."""
    section, machine = measures.section, measures.device.machine
    number = shown(row, value)
    lower, upper = shown_limits(section, kind)
    margin, wanted = reserve(section, kind, number), section.limit(kind.name, "margin") or 0.0
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
        verdict=verdict(kind, margin, wanted),
        meaning=kind.meaning,
        of=row.of or None,
        origin=machine.origin(f"requirements.{kind.key(side)}"),
    )


BESIDE = 1e-9
"""What rounding may put an angle out of its turn [rad]."""
ROUNDING = 1e-7
"""A margin may be short by this share of the requirement's step and is still kept."""


def verdict(kind: Kind, margin: float, wanted: float) -> str:
    """`pass`, `pass without margin` or `fail`; a curvature has to be above its limit."""
    slack = ROUNDING * kind.step
    if margin < -slack or (kind.name == "pitch_curvature" and margin <= 0):
        return "fail"
    return "pass" if margin >= wanted - slack else "pass without margin"


def phi(measures: Measures, x: Array, index: int) -> float | None:
    """Carrier angle of side 1 where a row stands at a design [rad]; None for the spacing, which stands nowhere."""
    row, place = measures.rows[index], float(measures.at(x).places[index])
    if row.kind.name == "spacing":
        return None
    return _meshing(measures, x, row, place) if row.kind.name in TOOTH else place


def _meshing(measures: Measures, x: Array, row: Row, u: float) -> float:
    """Carrier angle in [0, 2 pi] at which the place u of a segment is in contact [rad]."""
    device = measures.device
    both = device.stages[row.stage].polar(u=[u], parameters=device.of_stage(row.stage, x))
    wanted = float(both["t_second" if row.second else "t_first"][0, 0])
    z = np.concatenate([x, device.constants, device.prologue(x).h])
    contact = Course(measures.motion.contact_kernels[row.stage], z=z)
    start = contact.value(0.0)
    level = start + (wanted - start) % (2 * np.pi)
    return contact.crossing(level, -BESIDE, 2 * np.pi + BESIDE)
