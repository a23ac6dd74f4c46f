"""Requirements of a design set against their limits: what `simulate`, `validate` and `optimise` tell of them."""

from __future__ import annotations

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import roots
from planter.numerics.angles import turn_deg
from planter.planting.model import Device
from planter.planting.requirements.limits import limits, reserve, shown, shown_limits
from planter.planting.requirements.measures import Measures, Row
from planter.planting.requirements.pitch import TOOTH
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
        phi_deg=None if angle is None else turn_deg(angle),
        wanted_margin=wanted,
        verdict=verdict(kind, margin, wanted),
        meaning=kind.meaning,
        of=row.of or None,
        origin=machine.origin(f"requirements.{kind.key(side)}"),
    )


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
    return _meshing(measures.device, x, row, place) if row.kind.name in TOOTH else place


def _meshing(device: Device, x: Array, row: Row, u: float) -> float:
    """Carrier angle at which the place u of a segment is in contact."""
    mounting, first = np.split(x[: 4 + len(device.stages[0].names)], [4])
    second = x[4 + len(device.stages[0].names) :]
    stage = row.stage
    m = (first, second)[stage][-1]
    t = 2 * np.pi - u * (2 * m - 1) / m if row.second else u / m
    start = _named(device, mounting, "alpha3")
    if stage == 0:
        return float(t - start)
    h = device.prologue(x).h[: 1 + device.stages[0].terms]
    wanted = np.mod(t - _named(device, mounting, "beta6"), 2 * np.pi)

    def beyond(angle: Array) -> tuple[Array, Array]:
        contact = device.stages[0].contact(t=np.append(angle, 0.0) + start, parameters=first, hoisted=h)
        turned = contact["turned"][0]
        return turned[:-1] - turned[-1] - wanted, contact["ratio"][0, :-1]

    low, high = np.array([-1e-9]), np.array([2 * np.pi + 1e-9])
    return float(roots.newton(beyond, low, high, (beyond(low)[0], beyond(high)[0]))[0])


def _named(device: Device, mounting: Array, name: str) -> float:
    names = [entry["name"] for entry in device.sidecar["vectors"]["mounting"]]
    if name not in names:
        raise ComputationError(f"the model {device.model} has no {name}")
    return float(mounting[names.index(name)])
