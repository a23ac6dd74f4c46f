"""A device's motions and forces over time, as tables of other programs take them."""

from __future__ import annotations

import numpy as np

from planter.errors import InputError
from planter.interchange.tables.motion import Column, Motion
from planter.planting.export import c99
from planter.planting.model import Device
from planter.planting.quantities import quantities
from planter.planting.simulation import checked_samples

MOST_ROWS = 200_000


def over_time(device: Device, turns: int = 1, samples: int | None = None) -> Motion:
    """All quantities over whole turns at the machine's speed, `samples` to a turn, the last turn's end included.

    Raises InputError for numbers of turns or samples out of range.
    """
    count = checked_samples(device.machine.objective.samples if samples is None else samples)
    if not 1 <= turns <= MOST_ROWS // count:
        allowed = f"it must be between 1 and {MOST_ROWS // count} with {count} samples to a turn"
        raise InputError(f"--turns = {turns} is not allowed: {allowed}")
    phi = 2 * np.pi * np.arange(turns * count + 1) / count
    speed = device.machine.si("operation.speed_rpm")
    found = device.cycle(device.prologue(device.design), phi)
    rows = [*found["side1"], *found["side2"], *found["totals"]]
    columns = (
        Column("time", "time_s", "s", "time", "carrier angle over carrier speed", phi / speed),
        Column("phi", "phi_deg", "rad", "angle of the carrier", "given", phi),
        *(
            Column(q.name, q.shown, q.unit, f"{q.meaning}{f', side {q.side}' if q.side else ''}", q.source, row)
            for q, row in zip(quantities(device.sidecar), rows, strict=True)
        ),
    )
    rpm = f"{device.machine.operation.speed_rpm:g} r/min"
    notes = (
        f"{c99.headline(device)}; {turns} {'turn' if turns == 1 else 'turns'} at a constant carrier speed of {rpm}",
        f"Assumes: {'; '.join(device.sidecar['assumptions'])}.",
    )
    return Motion(c99.name(device), notes, columns)
