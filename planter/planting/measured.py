"""`planter calibrate --data` for a planting device: both of its models fitted to a measured total."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from planter.engine.machine import Machine as EngineMachine
from planter.measured import calibration
from planter.measured.calibration import Calibrated, Check
from planter.measured.reading import Columns
from planter.parallel.task import AUTO, Means
from planter.planting.file import Machine
from planter.planting.functions import MODELS, Model
from planter.planting.machines import build_machine
from planter.planting.model import Device
from planter.progress import Listener

SUPPORT = "support_N"


def calibrate(
    machine: Machine,
    model: Model,
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str = SUPPORT,
    check: Check | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
) -> Calibrated:
    """Fit chosen inputs within `bounds` (shown units, by path) to a curve in a CSV file, in both models.

    `model` is reported first, `means` says what runs the searches. Raises InputError for a file, columns or
    inputs that cannot be used.
    """
    ordered = (model, *(other for other in MODELS if other != model))
    builders: dict[str, Callable[[], EngineMachine]] = {one: partial(_build, machine, one) for one in ordered}
    return calibration.calibrate(
        builders, data, columns, bounds, quantity, machine.with_numbers, check, seed, progress, means
    )


def _build(machine: Machine, model: Model) -> EngineMachine:
    return build_machine(Device(machine, model))
