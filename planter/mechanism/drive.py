"""`planter drive` of any machine that an angle drives."""

from __future__ import annotations

from pathlib import Path

from planter.engine.drive import Motor
from planter.engine.driven import Drive, drive_machine
from planter.engine.machine import Machine
from planter.mechanism import tables
from planter.mechanism.simulation import check_samples
from planter.terminal.console import Console


def drive(
    machine: Machine, motor: Motor, turns: int = 5, start: float | None = None, samples: int | None = None
) -> Drive:
    """Return a machine on a motor, from a speed [rad/s] on, its own without.

    Raises InputError for a statement without acceleration or without a single motor at the drive, ComputationError
    where the motor stalls.
    """
    check_samples(samples)
    return drive_machine(machine, motor, turns, start, samples)


def run_drive(
    console: Console, machine: Machine, motor: Motor, turns: int, start: float | None, samples: int | None,
    out: Path | None,
) -> None:  # fmt: skip
    """Compute, print, and write into a folder if one is named."""
    found = drive(machine, motor, turns, start, samples)
    if out is not None:
        from planter.mechanism.report import drive as report

        report.write_drive(out, found, machine, console.progress)
    console.result(found.result, lambda: tables.show_drive(console, found.result))
