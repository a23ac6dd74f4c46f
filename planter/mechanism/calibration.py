"""Measured data beside a machine: what is understood of a file, a fit, and what explains a curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from planter.engine.machine import HasMachine, Machine, to_machine
from planter.errors import InputError
from planter.measured import calibration
from planter.measured.calibration import (
    Calibrated,
    ValidationMeasurement,
    find_speed,
    find_units,
)
from planter.measured.curve import find_measured
from planter.measured.explanations import ExplanationFits, read_and_explain
from planter.measured.findings import MeasuredPreview
from planter.measured.logger_table import read_logger_table
from planter.measured.path_comparison import PathComparison, compare_path
from planter.measured.presentation import present_preview
from planter.measured.reading import (
    PATH_UNIT,
    Columns,
    describe_columns,
    read_curves,
    read_path,
)
from planter.measured.sensor_view import find_sensor_view, list_measured
from planter.mechanism.extension import find_extension
from planter.mechanism.model import require_repeating
from planter.progress import Listener
from planter.task import AUTO, Means

if TYPE_CHECKING:
    from planter.report.presentation import ResultPresentation

Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class MeasuredSource:
    """Measured curves in a file, and the machine that they are of.

    `quantity` names what was measured; None is that of the file's [measurement], or of the kind of
    machine. `model` is the one of the machine's models that is reported first.
    """

    stated: Machine | HasMachine
    data: str | Path
    columns: Columns
    quantity: str | Sequence[str] | None = None
    model: str | None = None

    @cached_property
    def builders(self) -> Mapping[str, calibration.MachineBuilder]:
        """Builders of the machine in its models by name, the reported one first."""
        return find_extension(to_machine(self.stated)).list_builders(self.model)

    @cached_property
    def machine(self) -> Machine:
        """The machine in the model that is reported first."""
        return next(iter(self.builders.values()))()

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """The names of what was measured."""
        default = find_extension(self.machine).measured
        return list_measured(self.machine.document, self.quantity, default)

    @property
    def is_path(self) -> bool:
        """Whether the columns are coordinates of a point, to which no angle and no time belongs."""
        machine, columns = self.machine, self.columns
        if machine.motion is not None or columns.has_positions or len(columns.names) != 2:
            return False
        return find_units(machine, columns, self.quantities) == [PATH_UNIT, PATH_UNIT]

    def require_measurable(self) -> None:
        """Raise InputError if no quantity or an unknown one is named, ComputationError for one that
        does not repeat after a cycle.
        """
        machine = self.machine
        if not self.quantities:
            keys = ", ".join(result.key for result in machine.results)
            raise InputError(f"--quantity must name what was measured: it must be one of {keys}")
        names = [find_measured(machine, quantity).name for quantity in self.quantities]
        if machine.motion is not None:
            return
        view = find_sensor_view(machine)
        if view is not None and view.quantity.name in names:
            names += [find_measured(machine, key).name for key in view.needed]
        require_repeating(machine, dict.fromkeys(names))


def calibrate_to_data(
    source: MeasuredSource,
    bounds: Bounds,
    check: ValidationMeasurement | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
    priors: Bounds | None = None,
) -> Calibrated:
    """Fit values within `bounds` (display units, by path) to measured curves, in all models.

    `means` are the processes of the searches, on which results do not depend; `priors` are those of
    `planter.measured.calibration.calibrate`. Raises InputError for a file, columns, values or a
    quantity that cannot be used, ComputationError for a quantity that does not repeat after a
    cycle.
    """
    source.require_measurable()
    return calibration.calibrate(
        source.builders,
        source.data,
        source.columns,
        bounds,
        source.quantities,
        source.machine.document.with_numbers,
        check,
        seed,
        progress,
        means,
        priors,
    )


def compare_path_to_data(
    source: MeasuredSource,
    bounds: Bounds,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means = AUTO,
    priors: Bounds | None = None,
) -> PathComparison:
    """Return the distances of measured points from the path of a point of the machine, in the model
    that is reported first, after a fit of values within `bounds`, if there are any.

    Raises as `calibrate_to_data`.
    """
    source.require_measurable()
    model, build = next(iter(source.builders.items()))
    return compare_path(
        build,
        model,
        read_path(read_logger_table(source.data), source.columns),
        bounds,
        [find_measured(source.machine, quantity).key for quantity in source.quantities],
        source.machine.document.with_numbers,
        seed,
        progress,
        means,
        priors,
    )


def explain_data(
    source: MeasuredSource,
    bounds: Bounds,
    seed: int = 0,
    progress: Listener | None = None,
    priors: Bounds | None = None,
) -> ExplanationFits:
    """Return what explains the measured curve of one quantity.

    Raises as `calibrate_to_data`, and InputError for several quantities.
    """
    source.require_measurable()
    return read_and_explain(
        source.machine,
        next(iter(source.builders)),
        source.data,
        source.columns,
        bounds,
        source.quantities,
        source.machine.document.with_numbers,
        seed,
        progress,
        priors,
    )


def preview_data(source: MeasuredSource) -> ResultPresentation:
    """Return the presentation of what is understood of a file; without a column of values, its
    columns are listed.
    """
    machine, columns = source.machine, source.columns
    if columns.names:
        source.require_measurable()
    columns.check_places()
    table, measured = read_logger_table(source.data), None
    if source.is_path:
        measured = read_path(table, columns)
    elif columns.names or columns.has_positions:
        units = find_units(machine, columns, source.quantities if columns.names else ())
        measured = read_curves(table, columns, find_speed(machine), units)
    result = MeasuredPreview(
        machine=machine.name,
        quantity=[find_measured(machine, quantity).key for quantity in source.quantities],
        columns=describe_columns(table),
        reading=None if measured is None else measured.reading,
        treatment=[table.describe()] if measured is None else list(measured.treatment),
    )
    return present_preview(machine.document, result, measured, machine.meanings)
