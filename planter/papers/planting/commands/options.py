"""Arguments and options that several commands of the planting device share, and the machines that
they name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from planter.errors import InputError
from planter.report.options import parse_changes

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.papers.planting.file import PlantingMachine
    from planter.papers.planting.model import Device
    from planter.papers.planting.tooth_counts import ToothCountSpec

FIGURES = ("support_force",)
"""Names of a device's figures."""


def load_device_file(
    source: str, set_: Sequence[str] | None, speed_rpm: float | None
) -> PlantingMachine:
    """Return a machine with the numbers that `--set` and `--speed-rpm` change.

    Raises InputError as its file does, and for the file of a user-defined mechanism.
    """
    from planter.mechanism import machines
    from planter.papers.planting import file

    if machines.takes(source):
        raise InputError(
            f"{source}: this is the file of a user-defined mechanism, but it must be that of a "
            f"planting device, with "
            "two stages of gears, a cam and nozzles"
        )
    return file.load(source, parse_changes(set_, {"operation.speed_rpm": speed_rpm}))


def build_device(
    source: str, model: str, set_: Sequence[str] | None, speed_rpm: float | None
) -> Device:
    """Return the device of a file in one of its models, with numbers changed as `load_device_file`
    does.
    """
    from planter.papers.planting.model import Device

    return Device(
        load_device_file(source, set_, speed_rpm), "exact" if model == "exact" else "printed"
    )


def load_other(source: str, set_: Sequence[str] | None, speed_rpm: float | None) -> Machine | None:
    """Return the machine of a source, None if it is a planting device or unknown."""
    from planter.engine.machine import load_machine

    return load_machine(source, parse_changes(set_), speed_rpm) if is_other(source) else None


def states_measures(source: str) -> bool:
    """Return whether the file of a planting device minimises or limits measures of its cycle."""
    from planter.papers.planting import file

    machine = file.load(source)
    return bool(machine.measure_limits or machine.objective_terms)


def is_other(source: str) -> bool:
    """Return whether a source is a machine other than a planting device."""
    from planter.files.examples import belongs_to_package, find_kind
    from planter.papers.planting import KIND, OWN_TABLES

    is_device = belongs_to_package(source, KIND, OWN_TABLES)
    return not is_device and find_kind(source) is not None


def parse_tooth_counts(
    module: float | None,
    module1: float | None,
    module2: float | None,
    teeth: str | None,
    excluded: Mapping[str, bool],
) -> ToothCountSpec | None:
    """Return the integer tooth numbers that the options ask for, None if they ask for none.

    Raises InputError for a present option of `excluded`, which cannot be combined with them.
    """
    from planter.papers.planting.tooth_counts import parse_tooth_count_options

    spec = parse_tooth_count_options(module, module1, module2, teeth)
    present = [name for name, is_present in excluded.items() if is_present]
    if spec is not None and present:
        raise InputError(
            f"{present[0]} cannot be used with --module: it is for designs of any teeth"
        )
    return spec
