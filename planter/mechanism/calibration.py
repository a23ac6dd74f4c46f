"""`planter calibrate --data CSV` of any machine."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from planter.engine.machine import Machine
from planter.errors import InputError
from planter.files.document import Document
from planter.measured import calibration, page, tables
from planter.measured.calibration import Calibrated, Check
from planter.measured.curve import find_measured
from planter.measured.reading import Columns
from planter.mechanism.periodicity import require_repeating
from planter.parallel.task import HERE, Means
from planter.progress import Listener
from planter.terminal.console import Console

MODEL = "derived"
"""Name of the model of a machine that has one."""


def calibrate(
    machine: Machine,
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str | None,
    check: Check | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = HERE,
) -> Calibrated:
    """Fit values within `bounds` (display units, by key) to a measured curve of a quantity.

    `means` says what runs the searches, whose results do not depend on it.
    Raises InputError for a file, columns, values or a quantity that cannot be used, ComputationError for a quantity
    that does not repeat after a cycle.
    """
    if quantity is None:
        known = ", ".join(one.key for one in machine.results)
        raise InputError(f"--quantity must name what was measured: it must be one of {known}")
    require_repeating(machine, [find_measured(machine, quantity).name])
    rebuild, builders = machine.document.with_numbers, {MODEL: partial(machine.build, machine.document)}
    return calibration.calibrate(builders, data, columns, bounds, quantity, rebuild, check, seed, progress, means)


def run_calibrate(
    console: Console, document: Document, meanings: Mapping[str, str], found: Calibrated, out: Path | None,
    angle: str = "angle of the drive",
) -> None:  # fmt: skip
    """Print the fit of a file, whose values have meanings by path, and write it into a folder if one is named."""
    if out is not None:
        page.write(out, document, found, meanings, angle)
    for warning in found.result.warnings:
        console.say(f"planter: warning: {warning}")
    console.result(found.result, lambda: tables.measured(console, found.result))
