"""`planter sensitivity` of any machine: of the sum in its file, or of another."""

from __future__ import annotations

from pathlib import Path

from planter.engine.machine import Machine
from planter.engine.sensitivity import SensitivityFound, compute_sensitivity, move_all
from planter.errors import InputError
from planter.mechanism import tables
from planter.mechanism.optimisation import StatedGoal
from planter.mechanism.simulation import check_samples
from planter.terminal.console import Console


def compute(
    machine: Machine, least: str | None = None, samples: int | None = None, all_values: bool = False
) -> SensitivityFound:
    """Return the sensitivity of a file's sum, or of `least`, in the values that have bounds, or in all.

    Without `samples` it is that of true extremes, unless the file asks for samples. Raises InputError for a file
    without a sum or bounds; ComputationError for the mean of what does not repeat after a cycle.
    """
    check_samples(samples)
    goal = StatedGoal.read(machine, least)
    goal.require_least()
    if not (machine.moved or all_values):
        raise InputError(f"{machine.source}: none of its values has bounds: ask for all values by --all")
    if samples is None and machine.sampling != "refined":
        samples = machine.sampling
    return compute_sensitivity(move_all(machine) if all_values else machine, goal.least, samples)


def run_sensitivity(
    console: Console, machine: Machine, least: str | None, samples: int | None, all_values: bool, out: Path | None
) -> None:
    """Compute, print, and write into a folder if one is named."""
    found = compute(machine, least, samples, all_values)
    if out is not None:
        from planter.mechanism.report import results

        results.write_sensitivity(out, found, machine)
    console.result(found, lambda: tables.show_sensitivity(console, found))
