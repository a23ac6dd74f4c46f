"""`planter drive`: the device on a motor and a flywheel, and beside it at the constant speed that has the same mean."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from planter.engine.drive import Drive, DriveResult, Motor, drive_machine
from planter.kernels import Array
from planter.planting.cycle import compute_statistics
from planter.planting.drive.machine import build_driven_machine
from planter.planting.model import FORCE, Device
from planter.planting.results import DriveFound

COLUMN = {FORCE: "support_N"}
"""The quantity that is reported, and its column."""


@dataclass(frozen=True)
class DeviceDrive:
    """A device on a motor: the drive of the machine that it is, and the result with its support force."""

    drive: Drive
    result: DriveFound

    def columns(self) -> dict[str, Array]:
        """Return the turn as a table, each column in the unit that its name ends in."""
        return self.drive.columns(COLUMN)


def drive(
    device: Device, motor: Motor, turns: int = 5, start: float | None = None, samples: int | None = None
) -> DeviceDrive:
    """The device at its own design, driven from a speed [rad/s] on, its machine's unless told.

    Raises InputError for the printed model, ComputationError where the motor stalls.
    """
    machine = build_driven_machine(device)
    names = tuple(quantity.name for quantity in machine.results if quantity.unit in ("N", "N m"))
    driven = drive_machine(machine, motor, turns, start, samples, names)
    own, other = (state.values[FORCE][:-1] for state in (driven.driven, driven.constant))
    general = {field.name: getattr(driven.result, field.name) for field in fields(DriveResult)}
    result = DriveFound(
        **general,
        support_force=compute_statistics(own),
        constant_speed=compute_statistics(other),
        change_N=float(np.abs(own - other).max()),
    )
    return DeviceDrive(driven, result)
