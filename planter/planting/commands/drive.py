"""`planter drive`: a machine on a motor and a flywheel."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.mechanism.commands import run_drive
from planter.planting.commands.options import SamplesOption, device_of, load_other
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, MachineArgument, OutOption, SetOption, SpeedOption

app = typer.Typer()


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
        from planter.planting.drive import drive as drives
        from planter.planting.drive import tables
        from planter.planting.simulation import check_samples

        device = device_of(machine, "exact", set_, speed_rpm)
        found = drives.drive(device, motor, turns, start, None if samples is None else check_samples(samples))
        if out is not None:
            from planter.planting.report import drive as report

            report.write(out, device, found, console.progress)
        console.result(found.result, lambda: tables.show(console, found.result))
