"""Calibration: what a paper does not disclose fitted to its figures, or inputs fitted to measured data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.mechanism.commands import calibrate_machine, refuse_options, run_calibrate
from planter.planting.commands.options import build_device, interruptible_result, load_other, text_option
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    JsonOption,
    MachineArgument,
    Model,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    read_ranges,
)

if TYPE_CHECKING:
    from planter.parallel.task import Means
    from planter.planting.model import Device

app = typer.Typer()


@app.command()
@writes("summary.json", "report.html")
def calibrate(
    machine: MachineArgument,
    target: Annotated[str, typer.Option(help="what to fit to: table1 (the paper's)")] = "table1",
    model: Annotated[Model, typer.Option(help="the model that is reported first; both are tried")] = Model.printed,
    flank: Annotated[list[str] | None, text_option("try only this law of the cam's flanks (repeatable)", "LAW")] = None,
    data: Annotated[Path | None, text_option("fit to a measured curve in this CSV file instead", "CSV")] = None,
    column: Annotated[str | None, text_option("its column with the measured values", "NAME")] = None,
    angle: Annotated[str | None, text_option("its column with the drive angle", "NAME")] = None,
    time: Annotated[str | None, text_option("its column with the time; the speed is the machine's", "NAME")] = None,
    unit: Annotated[
        str | None, text_option("unit of the values, where the header has none: N, kN, N m, mm, deg", "UNIT")
    ] = None,
    place_unit: Annotated[str | None, text_option("unit of angle or time: deg, rad, rev, s, ms, min", "UNIT")] = None,
    quantity: Annotated[
        str | None,
        text_option("what was measured: a key of `simulate` [default: support_N of a planting device]", "KEY"),
    ] = None,
    fit: Annotated[
        list[str] | None,
        text_option("fit this input within bounds; also offset_N and phase_deg (repeatable)", "PATH=LOW:HIGH"),
    ] = None,
    check: Annotated[Path | None, text_option("a second measurement to predict", "CSV")] = None,
    check_rpm: Annotated[float | None, text_option("its speed", "RPM")] = None,
    seed: SeedOption = 0,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Estimate unknown inputs from a measured curve.

    Inputs are masses, offsets and others. Without --data they are estimated from the figures that a paper reports.

    The 95 % intervals assume white noise; a warning says where neighbouring residuals are correlated. phase_deg shifts
    the angle: measured(phi) = computed(phi + phase); with bounds of a full period, as phase_deg=0:360, any is tried.

    Your own mechanism: planter calibrate own/slider_crank.toml --data force.csv --column force --angle angle
    --quantity F_Ox_N --fit m_s_kg=1:2

    Measured: planter calibrate my.toml --data force.csv --column force --angle angle --fit mass.planet_kg=0.8:1.6
    --fit offset_N=-20:20 --check faster.csv --check-rpm 50 --out fitted
    """
    console = Console(as_json)
    with console.outcome():
        from planter.parallel.task import Means

        means = Means(workers, cluster)
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--flank": bool(flank), "--target": target != "table1"})
            if data is None:
                raise InputError(f"--data must name a CSV file with a measured curve, to which {other.name} is fitted")
        if data is None:
            _fit_to_figures(console, build_device(machine, model, set_, speed_rpm), target, flank or (), means, out)
            return
        from planter.measured.calibration import Check
        from planter.measured.reading import Columns

        if column is None:
            raise InputError("--column must name the column of --data with the measured values")
        if (check is None) != (check_rpm is None):
            raise InputError("--check and --check-rpm belong together: a second measurement and its speed")
        second = None if check is None or check_rpm is None else Check(check, check_rpm)
        columns = Columns(column, angle, time, unit, place_unit)
        bounds = read_ranges("--fit", fit or ())
        from planter.planting import calibration
        from planter.report.presentation import ModelAssumptions

        if other is not None:
            fitted = calibrate_machine(other, data, columns, bounds, quantity, second, seed, console.progress, means)
            with interruptible_result(fitted.result.table()):
                run_calibrate(console, other.document, other.meanings, fitted, out)
            return
        device = build_device(machine, model, set_, speed_rpm)
        quantity = quantity or calibration.SUPPORT
        fitted = calibration.calibrate_to_data(
            device.machine, device.model, data, columns, bounds, quantity, second, seed, console.progress, means
        )
        with interruptible_result(fitted.result.table()):
            meanings = ModelAssumptions.from_sidecar(device.sidecar).meanings
            run_calibrate(console, device.machine, meanings, fitted, out, "carrier angle φ")


def _fit_to_figures(
    console: Console, device: Device, target: str, laws: Sequence[str], means: Means, out: Path | None
) -> None:
    """Fit to the figures that a paper reports."""
    from planter.planting import calibration
    from planter.planting.presentation import present_calibration

    result = calibration.calibrate(device.machine, device.model, target, laws, console.progress, means)
    with interruptible_result(result.table()):
        present_calibration(result, device).show(console, out)
