"""`planter simulate`, `sensitivity`, `drive` and `validate`: what a machine does as its file describes it."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.mechanism.commands import refuse_options, run_drive, run_sensitivity, run_simulate, run_validate
from planter.planting.commands.options import FIGURES, SamplesOption, build_device, is_other, load_other
from planter.report.writing import figure_files, writes
from planter.terminal.console import Console
from planter.terminal.options import (
    JsonOption,
    LeastOption,
    MachineArgument,
    Model,
    ModelOption,
    OutOption,
    SetOption,
    SpeedOption,
    changes,
)

app = typer.Typer()


@writes("summary.json", "report.html")
def simulate(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: SamplesOption = None,
    at: Annotated[
        list[float] | None, typer.Option(metavar="DEG", help="also report at this drive angle", show_default=False)
    ] = None,
    lift: Annotated[
        bool, typer.Option("--lift", help="relax assumptions one by one and report the effect of each (exact model)")
    ] = False,
    module_mm: Annotated[float, typer.Option(min=0.1, max=20, help="module of the teeth that --lift lets slide")] = 2.0,
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
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not Model.exact, "--lift": lift})
            run_simulate(console, other, samples, at or (), out)
            return
        if out is not None:
            from planter.report.folder import check

            check(out, ["cycle.csv", *figure_files(*FIGURES)])
        from planter.planting import simulation
        from planter.planting.design_presentation import present_simulation

        device = build_device(machine, model, set_, speed_rpm)
        simulated = simulation.simulate(device, samples, at or (), module_mm if lift else None)
        present_simulation(simulated).show(console, out)


app.command()(simulate)
app.command("turn", help="Another name for `simulate`.")(simulate)


@app.command()
@writes("summary.json", "report.html")
def sensitivity(
    machine: MachineArgument,
    model: ModelOption = Model.exact,
    samples: SamplesOption = None,
    least: LeastOption = None,
    all_values: Annotated[
        bool, typer.Option("--all", help="for all values of the file, not only those of the design or with bounds")
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find which design parameters the objective depends on.

    The result has its gradient, and combinations of parameters that have no effect.

    For a mechanism of your own the objective is that of its file, or --least; by true extremes unless --samples says
    a number. A value without bounds counts by its size.
    """
    console = Console(as_json)
    with console.outcome():
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            refuse_options(other, {"--model": model is not Model.exact})
            run_sensitivity(console, other, least, samples, all_values, out)
            return
        from planter.planting import simulation
        from planter.planting.design_presentation import present_sensitivity

        device = build_device(machine, model, set_, speed_rpm)
        result = simulation.sensitivity(device, samples, least, all_values)
        present_sensitivity(result, device).show(console, out)


@app.command()
@writes("summary.json", "turn.csv", "report.html")
def drive(
    machine: MachineArgument,
    stall_nm: Annotated[
        float,
        typer.Option("--stall-Nm", help="torque of the motor at rest, referred to the drive", show_default=False),
    ],
    idle_rpm: Annotated[
        float,
        typer.Option("--idle-rpm", help="speed of the drive at which the motor has no torque left", show_default=False),
    ],
    flywheel_kgm2: Annotated[
        float,
        typer.Option(
            "--flywheel-kgm2", help="inertia of flywheel, rotor and carrier, referred to the drive", show_default=False
        ),
    ],
    turns: Annotated[int, typer.Option(min=1, max=1000, help="number of revolutions to report")] = 5,
    start_rpm: Annotated[
        float | None, typer.Option(min=1e-3, help="speed at the start [default: the machine's]", show_default=False)
    ] = None,
    samples: SamplesOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute how a motor's speed fluctuates, and the forces.

    The torque of the motor falls with its speed.

    A mechanism of your own needs `acceleration=` in its statement, Mechanism(..., speed=q.omega, acceleration=q.eps).
    For example: planter drive wang2017 --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.4
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.drive import Motor
        from planter.files import units

        rad_s = units.factor("idle_rpm")
        motor = Motor(stall_nm, idle_rpm * rad_s, flywheel_kgm2)
        start = None if start_rpm is None else start_rpm * rad_s
        if (other := load_other(machine, set_, speed_rpm)) is not None:
            run_drive(console, other, motor, turns, start, samples, out)
            return
        from planter.planting.motor_drive import drive_device
        from planter.planting.presentation import present_drive
        from planter.planting.simulation import check_samples

        device = build_device(machine, "exact", set_, speed_rpm)
        driven = drive_device(device, motor, turns, start, None if samples is None else check_samples(samples))
        present_drive(driven, device).show(console, out)


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
            run_validate(console, machine, changes(set_), speed_rpm)
            return
        device = build_device(machine, "exact", set_, speed_rpm)
        from planter.planting import simulation
        from planter.planting.design_presentation import present_validation

        present_validation(simulation.validate(device), machine).show(console)
