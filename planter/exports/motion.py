"""A machine's motions and forces over time, as tables of other programs take them."""

from __future__ import annotations

import numpy as np

from planter.engine.machine import Machine
from planter.engine.response import Response
from planter.errors import InputError
from planter.exports import listings
from planter.exports.c99 import build_cycle
from planter.exports.objective import list_guards
from planter.interchange.tables.motion import Column, Motion
from planter.kernels import Array, Kernel

FEWEST_SAMPLES, MOST_SAMPLES = 8, 100_000
MOST_ROWS = 200_000


def build_motion(machine: Machine, turns: int = 1, samples: int | None = None) -> Motion:
    """Return all quantities, and places of the bodies' points, over whole turns at the machine's speed.

    There are `samples` to a turn, and the last turn's end is included. Raises InputError for numbers of turns or
    samples out of range, or a machine that stands still; ComputationError where loops do not close, or forces are not
    determined.
    """
    count = _check_numbers(machine, turns, samples)
    speed = float(machine.data[machine.speed])
    phi = np.copysign(machine.turn, speed) * np.arange(turns * count + 1) / count
    columns = (
        Column("time", "time_s", "s", "time", "angle of the drive over its speed", phi / speed),
        Column("phi", "phi_deg", "rad", "angle of the drive", "given", phi),
        *_build_columns(machine, phi),
    )
    rpm = f"{speed * 30 / np.pi:g} r/min"
    notes = (
        f"{listings.build_headline(machine)}; {turns} {'turn' if turns == 1 else 'turns'} at a constant speed of {rpm}",
        *([f"Assumes: {'; '.join(machine.assumptions)}."] if machine.assumptions else []),
    )
    return Motion(listings.build_name(machine), notes, columns)


def _check_numbers(machine: Machine, turns: int, samples: int | None) -> int:
    """Return the samples of a turn."""
    count = machine.samples if samples is None else samples
    if samples is not None and not FEWEST_SAMPLES <= samples <= MOST_SAMPLES:
        allowed = f"it must be between {FEWEST_SAMPLES} and {MOST_SAMPLES}"
        raise InputError(f"--samples = {samples} is not allowed: {allowed}")
    if not 1 <= turns <= MOST_ROWS // count:
        allowed = f"it must be between 1 and {MOST_ROWS // count} with {count} samples to a turn"
        raise InputError(f"--turns = {turns} is not allowed: {allowed}")
    if not machine.data[machine.speed]:
        raise InputError(
            f"{machine.source}: {machine.values[machine.speed].path} = 0: at rest there is no time of a turn"
        )
    return count


def _build_columns(machine: Machine, phi: Array) -> list[Column]:
    guards = Response(machine, list_guards(machine))
    d = machine.data
    point = guards.at_data(d)
    q = guards.coordinates(d, phi)
    guards.check(guards.values(point, phi), phi)
    quantities = listings.list_quantities(machine)
    labels = [(one.name, one.key, one.quantity.unit, one.meaning, one.quantity.source) for one in quantities]
    inputs = {"phi": phi, "d": d, "h": point.h, "q": q}
    rows = [row for part in Kernel(build_cycle(machine), lanes=["phi", "q"])(**inputs).values() for row in part]
    if places := machine.stages.get("places"):
        labels += [(one.name, one.key, one.unit, one.meaning, one.source) for one in places.quantities]
        rows += list(Kernel(places.function, lanes=["phi", "q"])(**inputs)["y"])
    return [Column(*label, row) for label, row in zip(labels, rows, strict=True)]
