"""`planter simulate`, `sensitivity`, `drive`, `validate` and `calibrate`: analyses of a machine
without a search.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.mechanism.commands import (
    calibrate_machine,
    refuse_options,
    require_measurable,
    run_calibrate,
    run_drive,
    run_explain,
    run_preview,
    run_sensitivity,
    run_simulate,
    run_validate,
)
from planter.planting.commands.options import (
    FIGURES,
    SamplesOption,
    build_device,
    is_other,
    load_other,
    text_option,
)
from planter.report.writing import figure_files, interruptible_result, writes_files
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    JsonOption,
    LeastOption,
    MachineArgument,
    ModelName,
    ModelOption,
    OutOption,
    SeedOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    find_unused,
    parse_changes,
    read_ranges,
    refuse_unused,
)

if TYPE_CHECKING:
    from planter.parallel.task import Means
    from planter.planting.model import Device


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
)
"""Options of `planter calibrate` that concern a measured curve."""


@writes_files("summary.json", "report.html")
def simulate(
    machine: MachineArgument,
    model: ModelOption = ModelName.exact,
    samples: SamplesOption = None,
    at: Annotated[
        list[float] | None,
        typer.Option(metavar="DEG", help="also report at this drive angle", show_default=False),
    ] = None,
    lift: Annotated[
        bool,
        typer.Option(
            "--lift",
            help="relax assumptions one by one and report the effect of each (exact model)",
        ),
    ] = False,
    module_mm: Annotated[
        float, typer.Option(min=0.1, max=20, help="module of the teeth that --lift lets slide")
    ] = 2.0,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute forces and motion of a machine over a cycle.

    For your own mechanism: every quantity, works, and a check of the laws of mechanics.
    """
    console = Console(as_json)
    with console.outcome():
        if not lift:
            refuse_unused("without --lift", "--module-mm")
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not ModelName.exact, "--lift": lift})
            run_simulate(console, other, samples, at or (), out)
            return
        device = build_device(machine, model, set_, speed_rpm)
        if out is not None:
            from planter.measured.sensor_presentation import FIGURE
            from planter.report.folder import check_files

            figures = FIGURES if device.machine.measurement is None else (*FIGURES, FIGURE)
            check_files(out, ["cycle.csv", *figure_files(*figures)])
        from planter.planting import simulation
        from planter.planting.design_presentation import present_simulation

        simulated = simulation.simulate(device, samples, at or (), module_mm if lift else None)
        present_simulation(simulated).show(console, out)


app.command()(simulate)
app.command("turn", help="Another name for `simulate`.")(simulate)


@app.command()
@writes_files("summary.json", "report.html")
def sensitivity(
    machine: MachineArgument,
    model: ModelOption = ModelName.exact,
    samples: SamplesOption = None,
    least: LeastOption = None,
    all_values: Annotated[
        bool,
        typer.Option(
            "--all", help="for all values of the file, not only those of the design or with bounds"
        ),
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find which design parameters the objective depends on.

    The result has its gradient, and combinations of parameters that have no effect.

    For your mechanism the objective is that of its file, or --least; by true extremes unless
    --samples says a number. A value without bounds counts by its size.
    """
    console = Console(as_json)
    with console.outcome():
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not ModelName.exact})
            run_sensitivity(console, other, least, samples, all_values, out)
            return
        from planter.planting import simulation
        from planter.planting.design_presentation import present_sensitivity

        device = build_device(machine, model, set_, speed_rpm)
        result = simulation.sensitivity(device, samples, least, all_values)
        present_sensitivity(result, device).show(console, out)


@app.command()
@writes_files("summary.json", "turn.csv", "report.html")
def drive(
    machine: MachineArgument,
    stall_nm: Annotated[
        float,
        typer.Option(
            "--stall-Nm",
            help="torque of the motor at rest, referred to the drive",
            show_default=False,
        ),
    ],
    idle_rpm: Annotated[
        float,
        typer.Option(
            "--idle-rpm",
            help="speed of the drive at which the motor has no torque left",
            show_default=False,
        ),
    ],
    flywheel_kgm2: Annotated[
        float,
        typer.Option(
            "--flywheel-kgm2",
            help="inertia of flywheel, rotor and carrier, referred to the drive",
            show_default=False,
        ),
    ],
    turns: Annotated[
        int, typer.Option(min=1, max=1000, help="number of revolutions to report")
    ] = 5,
    start_rpm: Annotated[
        float | None,
        typer.Option(
            min=1e-3, help="speed at the start [default: the machine's]", show_default=False
        ),
    ] = None,
    samples: SamplesOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute how a motor's speed fluctuates, and the forces.

    The torque of the motor falls with its speed.

    Your mechanism needs `acceleration=` in its statement, Mechanism(..., speed=q.omega,
    acceleration=q.eps). For example: planter drive wang2017 --stall-Nm 6 --idle-rpm 42
    --flywheel-kgm2 0.4
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.drive import Motor
        from planter.files import units

        rad_s = units.unit_factor("idle_rpm")
        motor = Motor(stall_nm, idle_rpm * rad_s, flywheel_kgm2)
        start = None if start_rpm is None else start_rpm * rad_s
        driven = load_other(machine, set_, speed_rpm)
        if driven is None:
            from planter.planting.motor_drive import build_driven_machine

            driven = build_driven_machine(build_device(machine, "exact", set_, speed_rpm))
        run_drive(console, driven, motor, turns, start, samples, out)


@app.command()
def validate(
    machine: MachineArgument,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Check a machine file, and warn of unusual values.

    Values, gears, loops over the whole cycle and limits are checked.
    """
    console = Console(as_json)
    with console.outcome():
        if is_other(machine):
            run_validate(console, machine, parse_changes(set_), speed_rpm)
            return
        device = build_device(machine, "exact", set_, speed_rpm)
        from planter.planting import simulation
        from planter.planting.design_presentation import present_validation

        present_validation(simulation.validate(device), machine).show(console)


@app.command()
@writes_files("summary.json", "report.html")
def calibrate(
    machine: MachineArgument,
    target: Annotated[str, typer.Option(help="what to fit to: table1 (the paper's)")] = "table1",
    model: Annotated[
        ModelName, typer.Option(help="the model that is reported first; both are tried")
    ] = ModelName.printed,
    flank: Annotated[
        list[str] | None, text_option("try only this law of the cam's flanks (repeatable)", "LAW")
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
            "its column with the time, at the machine's speed unless --angle or --trigger tells it",
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
            show_default=False,
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
            "fit this input within bounds; also offset_N and phase_deg (repeatable)",
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

    Inputs are masses, offsets and others. Without --data they are estimated from the figures that a
    paper reports.

    Separator, decimal marks, encoding, preamble and units of the file are detected; --preview shows
    how it was read. Correlated noise is estimated, and the 95 % intervals allow for it. phase_deg
    shifts the angle: measured(phi) = computed(phi + phase); with bounds of a full period, as
    phase_deg=0:360, any is tried.

    Your own mechanism: planter calibrate own/slider_crank.toml --data force.csv --column force
    --angle angle --quantity F_Ox_N --fit m_s_kg=1:2

    Measured: planter calibrate my.toml --data force.csv --column force --angle angle --fit
    mass.planet_kg=0.8:1.6 --fit offset_N=-20:20 --check faster.csv --check-rpm 50 --out fitted
    """
    console = Console(as_json)
    with console.outcome():
        from planter.parallel.task import Means

        means = Means(workers, cluster)
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--flank": bool(flank), "--target": target != "table1"})
            if data is None:
                raise InputError(
                    f"--data must name a CSV file with a measured curve, to which {other.name} is "
                    f"fitted"
                )
        if data is None:
            refuse_unused("without --data, a measured curve", *OF_MEASURED)
            _fit_to_figures(
                console,
                build_device(machine, model, set_, speed_rpm),
                target,
                flank or (),
                means,
                out,
            )
            return
        refuse_unused("with --data", "--target", "--flank")
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
        from planter.measured.calibration import ValidationMeasurement
        from planter.measured.reading import Columns
        from planter.measured.sensor_view import list_measured

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
        second = (
            None if check is None or check_rpm is None else ValidationMeasurement(check, check_rpm)
        )
        given_units = unit[0] if unit and len(unit) == 1 else unit
        columns = Columns(column or (), angle, time, given_units, place_unit, trigger, interval_s)
        bounds, priors = read_ranges("--fit", fit or ()), read_ranges("--prior", prior or ())
        from planter.planting import calibration
        from planter.report.presentation import ModelAssumptions

        if other is not None:
            quantities = list_measured(other.document, quantity)
            if preview:
                if column:
                    require_measurable(other, quantities)
                run_preview(console, other, data, columns, quantities, out)
                return
            if explain:
                require_measurable(other, quantities)
                run_explain(console, other, data, columns, bounds, quantities, seed, priors, out)
                return
            fitted = calibrate_machine(
                other,
                data,
                columns,
                bounds,
                quantities,
                second,
                seed,
                console.progress,
                means,
                priors,
            )
            with interruptible_result(fitted.result.table()):
                run_calibrate(console, other.document, other.meanings, fitted, out)
            return
        device = build_device(machine, model, set_, speed_rpm)
        quantities = list_measured(device.machine, quantity, (calibration.SUPPORT,))
        if preview:
            run_preview(
                console,
                calibration.build_engine_machine(device.machine, device.model),
                data,
                columns,
                quantities,
                out,
            )
            return
        if explain:
            engine = calibration.build_engine_machine(device.machine, device.model)
            run_explain(
                console,
                engine,
                data,
                columns,
                bounds,
                quantities,
                seed,
                priors,
                out,
                device.model,
                "carrier angle φ",
            )
            return
        fitted = calibration.calibrate_to_data(
            device.machine,
            device.model,
            data,
            columns,
            bounds,
            quantities,
            second,
            seed,
            console.progress,
            means,
            priors,
        )
        with interruptible_result(fitted.result.table()):
            meanings = ModelAssumptions.from_sidecar(device.sidecar).meanings
            run_calibrate(console, device.machine, meanings, fitted, out, "carrier angle φ")


def _fit_to_figures(
    console: Console,
    device: Device,
    target: str,
    laws: Sequence[str],
    means: Means,
    out: Path | None,
) -> None:
    """Fit to the figures that a paper reports."""
    from planter.planting import calibration
    from planter.planting.presentation import present_calibration

    result = calibration.calibrate(
        device.machine, device.model, target, laws, console.progress, means
    )
    with interruptible_result(result.table()):
        present_calibration(result, device).show(console, out)
