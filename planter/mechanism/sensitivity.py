"""`planter sensitivity FILE` for a mechanism of one's own."""

from __future__ import annotations

from pathlib import Path

from planter.engine.sensitivity import SensitivityFound, compute_sensitivity, move_all
from planter.errors import InputError
from planter.mechanism import tables
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model
from planter.mechanism.optimisation import StatedGoal
from planter.mechanism.periodicity import require_repeating
from planter.mechanism.simulation import check_samples
from planter.terminal.console import Console


def compute(
    file: MechanismFile, least: str | None = None, samples: int | None = None, all_values: bool = False
) -> SensitivityFound:
    """Return the sensitivity of a file's sum, or of `least`, in the values that have bounds, or in all.

    Without `samples` it is that of true extremes, unless the file asks for samples. Raises InputError for a file
    without a sum or bounds; ComputationError for the mean of what does not repeat after a cycle.
    """
    check_samples(samples)
    goal = StatedGoal.read(file, least)
    if not goal.least:
        raise InputError(f"{file.source}: objective.least is missing: give it there, or by --least")
    if not (file.bounds or all_values):
        raise InputError(f"{file.source}: it has no [bounds]; give some there, or ask for all values by --all")
    if averaged := goal.averaged:
        require_repeating(Model(file), averaged, file.turn.samples)
    if samples is None and file.objective is not None and isinstance(file.objective.samples, int):
        samples = file.objective.samples
    machine = move_all(goal.machine) if all_values else goal.machine
    return compute_sensitivity(machine, goal.least, samples)


def run_sensitivity(
    console: Console, file: MechanismFile, least: str | None, samples: int | None, all_values: bool, out: Path | None
) -> None:
    """Compute, print, and write into a folder if one is named."""
    found = compute(file, least, samples, all_values)
    if out is not None:
        from planter.mechanism.report import results

        results.write_sensitivity(out, found, file)
    console.result(found, lambda: tables.show_sensitivity(console, found))
