"""`planter validate`: that a machine file can be used, what its design makes of its requirements, what is unusual."""

from __future__ import annotations

from planter.planting import plausible
from planter.planting.model import Device
from planter.planting.requirements import record
from planter.planting.results.simulated import Validation


def validate(device: Device) -> Validation:
    """What is to be told of a machine whose file and gears have passed every check."""
    machine = device.machine
    return Validation(
        machine=machine.name, valid=True, design=list(device.names), requirements=record.of(device),
        warnings=plausible.warnings(machine),
    )  # fmt: skip
