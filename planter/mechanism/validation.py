"""`planter validate` of mechanisms: the file can be used, its loops close all over the cycle, its limits are met."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planter.engine.machine import Machine, load_machine
from planter.mechanism import file, machines, tables
from planter.mechanism.course import turns
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model
from planter.mechanism.results import MachineValidation, Warned
from planter.mechanism.turn import turn
from planter.terminal.console import Console


def validate(machine: Machine) -> MachineValidation:
    """Return what a designer should know of a machine whose file has passed every check: limits and warnings.

    Raises ComputationError if its loops do not close at some angle of the cycle.
    """
    cycle = turn(Model(machine)).result
    return MachineValidation(
        machine=machine.name, valid=True, design=list(machine.design_names), holds=cycle.holds, met=cycle.met,
        warnings=[*_warn_of_bounds(machine), *cycle.warnings],
    )  # fmt: skip


def validate_motion(mechanism: MechanismFile) -> MachineValidation:
    """Return what a designer should know of a mechanism that moves by itself, at its start.

    Raises ComputationError if no start near the stated one satisfies its constraints.
    """
    dynamics = Dynamics(mechanism)
    start = dynamics.start()
    names = [dynamics.names[index] for index in dynamics.changed(start)]
    message = "the stated start breaks the constraints: the motion begins at the nearest one that satisfies them"
    return MachineValidation(
        machine=mechanism.name, valid=True, design=[],
        warnings=[Warned(name=name, message=message) for name in names],
    )  # fmt: skip


def _warn_of_bounds(machine: Machine) -> Iterator[Warned]:
    """Yield a warning for each value of the design that lies outside its bounds."""
    for index, lower, upper in zip(machine.moved, machine.lower, machine.upper, strict=True):
        value, number = machine.values[index], machine.data[index]
        if not lower <= number <= upper:
            ends = f"[{lower / value.factor:g}, {upper / value.factor:g}]"
            message = f"{value.path} = {number / value.factor:g} lies outside its bounds {ends}"
            yield Warned(name="design", message=message)


def run_validate(console: Console, source: str, changes: Mapping[str, float], speed_rpm: float | None) -> None:
    """Validate the machine of a file or of a built-in name, and print what was noticed."""
    if machines.takes(source) and not turns(mechanism := file.load(source, changes)):
        found = validate_motion(mechanism)
    else:
        found = validate(load_machine(source, changes, speed_rpm))
    console.result(found, lambda: tables.show_validation(console, source, found))
