"""`planter calibrate FILE --data CSV` for a mechanism of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from planter.errors import InputError
from planter.measured import calibration, page, tables
from planter.measured.calibration import Calibrated, Check
from planter.measured.curve import find_measured
from planter.measured.reading import Columns
from planter.mechanism.file import MechanismFile, made
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.periodicity import require_repeating
from planter.parallel.task import HERE, Means
from planter.progress import Listener
from planter.terminal.console import Console

MODEL = "derived"
"""Name of the one model that a mechanism has."""


def calibrate(
    file: MechanismFile,
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
    machine = build_machine(file)
    if quantity is None:
        known = ", ".join(one.key for one in machine.results)
        raise InputError(f"--quantity must name what was measured: it must be one of {known}")
    require_repeating(Model(file), [find_measured(machine, quantity).name], file.turn.samples)

    def rebuild(inputs: Mapping[str, float]) -> MechanismFile:
        moved = file.moved_to({path.rpartition(".")[2]: value for path, value in inputs.items()})
        return made({**moved.table(), "folder": str(file.place)}, file.source, file.place)

    builders = {MODEL: partial(build_machine, file)}
    return calibration.calibrate(builders, data, columns, bounds, quantity, rebuild, check, seed, progress, means)


def run_calibrate(console: Console, file: MechanismFile, found: Calibrated, out: Path | None) -> None:
    """Print the fit, and write it into a folder if one is named."""
    if out is not None:
        meanings = {entry["shown"]: entry["meaning"] for entry in file.entries}
        page.write(out, file, found, meanings, "angle of the drive")
    for warning in found.result.warnings:
        console.say(f"planter: warning: {warning}")
    console.result(found.result, lambda: tables.measured(console, found.result))
