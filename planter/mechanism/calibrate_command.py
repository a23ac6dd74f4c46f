"""`planter calibrate`: inputs of a machine fitted to measured curves, or to a paper's figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError
from planter.mechanism.simulate_command import open_machine
from planter.report.console import Console
from planter.report.options import (
    ClusterOption,
    JsonOption,
    MachineArgument,
    ModelName,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    find_unused,
    interruptible_result,
    read_ranges,
    refuse_unused,
    text_option,
    writes_files,
)

app = typer.Typer()

OF_MEASURED = (
    "--preview",
    "--explain",
    "--column",
    "--angle",
    "--time",
    "--trigger",
    "--interval-s",
    "--unit",
    "--place-unit",
    "--quantity",
    "--fit",
    "--prior",
    "--check",
    "--check-rpm",
    "--seed",
    "--workers",
    "--cluster",
)
"""Options of `planter calibrate` that concern a measured curve."""


@app.command()
@writes_files("summary.json", "report.html")
def calibrate(
    machine: MachineArgument,
    target: Annotated[str, typer.Option(help="what to fit to: table1 (the paper's)")] = "table1",
    model: Annotated[
        ModelName | None,
        typer.Option(
            help="of a machine with two models [default: printed]; with --data both are tried"
        ),
    ] = None,
    data: Annotated[
        Path | None, text_option("fit to a measured curve in this CSV file instead", "CSV")
    ] = None,
    column: Annotated[
        list[str] | None,
        text_option(
            "its column with measured values (repeatable, with --quantity for each)", "NAME"
        ),
    ] = None,
    angle: Annotated[str | None, text_option("its column with the drive angle", "NAME")] = None,
    time: Annotated[
        str | None,
        text_option(
            "its column with the time, at the machine's speed unless --angle or --trigger tells "
            "it; of a free motion from the first row on",
            "NAME",
        ),
    ] = None,
    trigger: Annotated[
        str | None, text_option("its column with a pulse once a revolution", "NAME")
    ] = None,
    interval_s: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            min=1e-9,
            max=1e6,
            help="time from one row to the next, where no column tells it [s]",
        ),
    ] = None,
    unit: Annotated[
        list[str] | None,
        text_option(
            "unit of the values, where the header has none: N, kN, N m, mm, deg (repeatable)",
            "UNIT",
        ),
    ] = None,
    place_unit: Annotated[
        str | None, text_option("unit of angle or time: deg, rad, rev, s, ms, min", "UNIT")
    ] = None,
    quantity: Annotated[
        list[str] | None,
        text_option(
            "what was measured: a key of `simulate` [default: that of the file's measurement, "
            "else support_N of a "
            "planting device]",
            "KEY",
        ),
    ] = None,
    fit: Annotated[
        list[str] | None,
        text_option(
            "fit this input within bounds; also offset_N and phase_deg, or shift_s of a free "
            "motion (repeatable)",
            "PATH=LOW:HIGH",
        ),
    ] = None,
    prior: Annotated[
        list[str] | None,
        text_option("what else is known of an input: a normal prior (repeatable)", "PATH=MEAN:STD"),
    ] = None,
    preview: Annotated[
        bool, typer.Option("--preview", help="only show what is understood of the data")
    ] = False,
    explain: Annotated[
        bool,
        typer.Option(
            "--explain",
            help="compare what can stand between the machine and the sensor: enclosed forces, a "
            "lever, an imbalance, a "
            "swinging speed, an elastic mount, a coupling",
        ),
    ] = False,
    check: Annotated[Path | None, text_option("a second measurement to predict", "CSV")] = None,
    check_rpm: Annotated[float | None, text_option("its speed [r/min]", "RPM")] = None,
    seed: SeedOption = 0,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Estimate unknown inputs from a measured curve.

    Inputs are masses, offsets and others. Without --data they are estimated from the figures that a
    paper reports.

    Separator, decimal marks, encoding, preamble and units of the file are detected; --preview shows
    how it was read. Correlated noise is estimated, and the 95 % intervals allow for it. phase_deg
    shifts the angle: measured(phi) = computed(phi + phase); with bounds of a full period, as
    phase_deg=0:360, any is tried. What moves freely is fitted over the time of the record; shift_s
    is the time of its first row after the start.

    For example: planter calibrate own/slider_crank.toml --data force.csv --column force
    --angle angle --quantity F_Ox_N --fit m_s_kg=1:2

    For example: planter calibrate my.toml --data force.csv --column force --angle angle --fit
    mass.planet_kg=0.8:1.6 --fit offset_N=-20:20 --check faster.csv --check-rpm 50 --out fitted
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.wording import label_place
        from planter.measured.calibration import ValidationMeasurement
        from planter.measured.presentation import present_explained, present_fit
        from planter.measured.reading import Columns
        from planter.mechanism.calibration import (
            MeasuredSource,
            calibrate_to_data,
            explain_data,
            preview_data,
        )
        from planter.mechanism.extension import find_extension
        from planter.task import Means

        opened = open_machine(machine, set_, speed_rpm, model or ModelName.exact, may_move=True)
        if opened.motion is not None:
            of_a_cycle = ("--explain", "--check", "--check-rpm", "--angle", "--trigger", "--model")
            refuse_unused(f"since {opened.name} moves freely", *of_a_cycle)
        means, first = Means(workers, cluster), None if model is None else model.value
        if data is None:
            refuse_unused("without --data, a measured curve", *OF_MEASURED)
            extension = find_extension(opened)
            extension.fit_to_figures(first or "printed", target).show(console, out)
            return
        refuse_unused("with --data", "--target")
        if preview:
            refuse_unused("with --preview", "--explain", "--check", "--check-rpm")
            of_fits = ["--fit", "--prior", "--seed", "--workers", "--cluster", "--model"]
            by_speed = (
                (time is not None or interval_s is not None) and angle is None and trigger is None
            )
            if unused := find_unused(*of_fits, *([] if by_speed else ["--speed-rpm"])):
                console.say(f"no effect with --preview, which fits nothing: {', '.join(unused)}")
        if explain:
            refuse_unused("with --explain", "--check", "--check-rpm", "--workers", "--cluster")
        if not column and not preview:
            raise InputError("--column must name the column of --data with the measured values")
        if (check is None) != (check_rpm is None):
            raise InputError(
                "--check and --check-rpm belong together: a second measurement and its speed"
            )
        if unit and not column:
            raise InputError(
                "--unit is that of the values in --column: add --column, or leave --unit out"
            )
        given_units = unit[0] if unit and len(unit) == 1 else unit
        columns = Columns(column or (), angle, time, given_units, place_unit, trigger, interval_s)
        bounds, priors = read_ranges("--fit", fit or ()), read_ranges("--prior", prior or ())
        source = MeasuredSource(opened, data, columns, quantity, first)
        if preview:
            preview_data(source).show(console, out)
            return
        meanings, label = source.machine.meanings, label_place(source.machine)
        if explain:
            explained = explain_data(source, bounds, seed, console.progress, priors)
            present_explained(opened.document, explained, meanings, label).show(console, out)
            return
        second = (
            None if check is None or check_rpm is None else ValidationMeasurement(check, check_rpm)
        )
        calibrated = calibrate_to_data(
            source, bounds, second, seed, console.progress, means, priors
        )
        with interruptible_result(calibrated.result.table()):
            present_fit(opened.document, calibrated, meanings, label).show(console, out)
