"""What commands for any machine share where it is a mechanism of one's own: its file, and options that it refuses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planter.errors import InputError
from planter.files.units import factor

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.mechanism.file import MechanismFile

RPM = factor("speed_rpm")
NO_STAGES = "it has no gear stages"
REFUSED = {
    "--flank": "it has no cam whose flanks a paper leaves open",
    "--target": "no paper reports figures of it; --data takes a measured curve",
    "--lift": "it lifts assumptions of the planting device",
    "--model": "it has one model, its statement",
    "--front": "the front weighs the range of a support force against its variance",
    "--teeth": NO_STAGES,
    "--module": NO_STAGES,
    "--module1": NO_STAGES,
    "--module2": NO_STAGES,
}
"""Options that do not apply to mechanisms of one's own, with the reason."""


def refuse_options(mechanism: MechanismFile | Machine, options: Mapping[str, bool]) -> None:
    """Raise InputError for the first of some options that is present, which says why it does not apply."""
    for option, is_present in options.items():
        if is_present:
            raise InputError(f"{option} does not apply to {mechanism.name}: {REFUSED[option]}")


def load_mechanism(source: str, changes: Mapping[str, float], speed_rpm: float | None) -> MechanismFile:
    """Return the file of a mechanism, its drive's speed [r/min] set if it is given."""
    from planter.mechanism import file
    from planter.mechanism.machines import build_machine

    mechanism = file.load(source, changes)
    if speed_rpm is None:
        return mechanism
    machine = build_machine(mechanism)
    speed = machine.values[machine.speed]
    return file.load(source, {**changes, speed.path: speed_rpm * RPM / speed.factor})
