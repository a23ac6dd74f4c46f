"""`planter simulate`, `sensitivity`, `drive`, `validate` and `cam`: analyses of a machine without a
search.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.mechanism.move_command import UNTIL, InputOption, show_motion
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    LeastOption,
    MachineArgument,
    ModelName,
    ModelOption,
    OutOption,
    SamplesOption,
    SetOption,
    SpeedOption,
    parse_changes,
    refuse_unused,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from planter.engine.machine import Machine

app = typer.Typer()


def open_machine(
    source: str,
    set_: Sequence[str] | None,
    speed_rpm: float | None,
    model: ModelName = ModelName.exact,
    may_move: bool = False,
) -> Machine:
    """Return the machine of a file or of a built-in name, in one of its models, with the numbers
    that `--set` and `--speed-rpm` change; one that moves freely if it `may_move`.

    Raises InputError as `planter.engine.machine.load_machine`.
    """
    from planter.engine.machine import load_driven_machine, load_machine

    choices = {} if model is ModelName.exact else {"model": model.value}
    load = load_machine if may_move else load_driven_machine
    return load(source, parse_changes(set_), speed_rpm, **choices)


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
    until: Annotated[float | None, UNTIL] = None,
    input_: InputOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute forces and motion of a machine over a cycle.

    For your own mechanism: every quantity, works, and a check of the laws of mechanics. What no
    angle drives moves from its start --until a time, as `planter move` has it with more options.
    """
    console = Console(as_json)
    with console.outcome():
        if not lift:
            refuse_unused("without --lift", "--module-mm")
        from planter.mechanism.machines import find_free_motion

        if (mechanism := find_free_motion(machine, parse_changes(set_))) is not None:
            cycle_options = ("--model", "--samples", "--at", "--lift", "--speed-rpm")
            refuse_unused(f"since {mechanism.name} moves freely", *cycle_options)
            if until is None:
                raise InputError(f"{mechanism.name} moves freely: --until S says how long")
            show_motion(console, mechanism, until, input_, out)
            return
        refuse_unused("since an angle drives the machine", "--until", "--input")
        from planter.mechanism.cycle import simulate_machine
        from planter.mechanism.presentation import present_cycle

        opened = open_machine(machine, set_, speed_rpm, model)
        cycle = simulate_machine(opened, samples, at or (), module_mm if lift else None)
        present_cycle(cycle).show(console, out)


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
        from planter.mechanism.optimisation import compute_objective_sensitivity
        from planter.mechanism.presentation import present_sensitivity

        opened = open_machine(machine, set_, speed_rpm, model, may_move=True)
        result = compute_objective_sensitivity(opened, samples, least, all_values)
        present_sensitivity(result, opened).show(console, out)


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
        from planter.engine.drive import Motor, drive_machine
        from planter.engine.machine import check_samples
        from planter.files import units
        from planter.mechanism.extension import find_extension
        from planter.mechanism.presentation import present_drive

        check_samples(samples)
        rad_s = units.unit_factor("idle_rpm")
        motor = Motor(stall_nm, idle_rpm * rad_s, flywheel_kgm2)
        start = None if start_rpm is None else start_rpm * rad_s
        driven = find_extension(open_machine(machine, set_, speed_rpm)).build_driven_machine()
        present_drive(drive_machine(driven, motor, turns, start, samples)).show(console, out)


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
        from planter.mechanism import file, machines
        from planter.mechanism.cycle import validate_machine
        from planter.mechanism.motion import validate_free_motion
        from planter.mechanism.presentation import present_validation

        changes = parse_changes(set_)
        if machines.takes(machine) and not (free := file.load(machine, changes)).is_driven:
            presentation = present_validation(validate_free_motion(free), machine)
        else:
            opened = open_machine(machine, set_, speed_rpm)
            presentation = present_validation(validate_machine(opened), machine, opened)
        presentation.show(console)


CAM_EPILOG = (
    "For example: planter cam wang2017 --roller-mm 6 --step --out cam; "
    "planter cam cam_follower --roller-mm 8 --bore-mm 12 --out cam"
)


@app.command(epilog=CAM_EPILOG)
@writes_files("summary.json", "report.html", "contour.dxf", "contour.svg", "contour.csv")
def cam(
    machine: Annotated[
        str,
        typer.Argument(
            help="a machine file, a built-in machine, or your mechanism", show_default=False
        ),
    ],
    roller_mm: Annotated[
        float, typer.Option(metavar="R", help="radius of the roller", show_default=False)
    ],
    y: Annotated[
        str | None,
        text_option(
            "for a mechanism whose statement has no follower: where the roller's centre is from "
            "the cam's axis, "
            "along y: a sum of quantities of `planter simulate`, values of the file, and numbers "
            "in mm, such as y_0+s",
            "SUM",
        ),
    ] = None,
    x: Annotated[str | None, text_option("with --y: the same along x [default: 0]", "SUM")] = None,
    force: Annotated[
        str | None,
        text_option("for a mechanism: the follower's force, which lift-off ends", "NAME"),
    ] = None,
    bore_mm: Annotated[
        float | None,
        typer.Option(min=0.1, help="for a mechanism: bore of the disc", show_default=False),
    ] = None,
    width_mm: Annotated[
        float,
        typer.Option(
            min=0.1, max=1000, help="width of the rim or disc, and minimum height of a rim"
        ),
    ] = 10.0,
    tolerance_um: Annotated[
        float,
        typer.Option(min=0.01, max=100, help="maximum deviation of the arcs from the contour"),
    ] = 1.0,
    step: Annotated[
        bool, typer.Option("--step", help="with --out: also the solid (needs planter[step])")
    ] = False,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Design the cam as a part, for a roller.

    The result has contour, pressure angle, undercut margin and speed of lift-off; --out writes DXF,
    CSV and STEP.

    Of a planting device it is the end-face cam, unrolled and in space; of your mechanism the disc
    that turns with its angle.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.gears.workshop.cam_report import present_cam
        from planter.mechanism.extension import CamRequest, find_extension

        if x is not None and y is None:
            raise InputError("--x needs --y")
        if step and out is None:
            raise InputError("--step needs --out DIR to write the solid to")
        request = CamRequest(
            roller_mm * 1e-3,
            tolerance_um * 1e-6,
            width_mm * 1e-3,
            None if bore_mm is None else bore_mm * 1e-3,
            None if y is None else (x or "0", y),
            force,
        )
        opened = open_machine(machine, set_, speed_rpm)
        design = find_extension(opened).build_cam(request)
        present_cam(design, step, out is not None).show(console, out)
