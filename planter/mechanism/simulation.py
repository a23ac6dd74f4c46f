"""`planter simulate` of any machine: its cycle, and its results at single angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from planter.engine.machine import Machine
from planter.engine.summary import Summary, summarise
from planter.errors import ComputationError, InputError
from planter.mechanism import tables
from planter.mechanism.model import Model
from planter.mechanism.results import AngleValues, Warned
from planter.mechanism.turn import Turn, turn
from planter.terminal.console import Console

FEWEST_SAMPLES, MOST_SAMPLES = 4, 100_000


def simulate(machine: Machine, samples: int | None = None, at_deg: Sequence[float] = ()) -> Turn:
    """Return the cycle of a machine in `samples` equal steps, the file's own without, and results at angles [deg].

    Raises InputError for a number of samples out of range, or an angle that is not finite; ComputationError as the
    model does.
    """
    check_samples(samples)
    check_angles(at_deg)
    model = Model(machine)
    cycle = turn(model, samples)
    designer, warnings = _summarise(model, cycle)
    at = [
        AngleValues(float(angle), {key: float(values[0]) for key, values in model.results(np.radians([angle])).items()})
        for angle in at_deg
    ]
    warnings = [*cycle.result.warnings, *warnings]
    return replace(cycle, result=replace(cycle.result, at=at or None, designer=designer, warnings=warnings))


def check_samples(samples: int | None) -> None:
    """Raise InputError for a number of samples out of range."""
    if samples is not None and not FEWEST_SAMPLES <= samples <= MOST_SAMPLES:
        allowed = f"it must be between {FEWEST_SAMPLES} and {MOST_SAMPLES}"
        raise InputError(f"--samples = {samples} is not allowed: {allowed}")


def check_angles(at_deg: Sequence[float]) -> None:
    """Raise InputError for an angle that is not finite."""
    if bad := [angle for angle in at_deg if not np.isfinite(angle)]:
        raise InputError(f"--at = {bad[0]} is not allowed: it must be a finite angle in deg")


def _summarise(model: Model, cycle: Turn) -> tuple[Summary | None, list[Warned]]:
    """Return the designer's summary, or a warning where a quantity has a pole between samples."""
    try:
        return summarise(model.machine, cycle.result.not_repeating), []
    except ComputationError as error:
        message = f"there is no summary for the designer: {error.message}"
        return None, [Warned(name="no_summary", angle_deg=0.0, message=message)]


def run_simulate(
    console: Console, machine: Machine, samples: int | None, at_deg: Sequence[float], out: Path | None
) -> None:
    """Simulate, print, and write into a folder if one is named."""
    cycle = simulate(machine, samples, at_deg)
    if out is not None:
        from planter.mechanism.report import results

        results.write_turn(out, cycle, console.progress)
    console.result(cycle.result, lambda: tables.turn(console, cycle.result))
