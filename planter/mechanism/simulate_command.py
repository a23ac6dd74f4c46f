"""`planter simulate`: a cycle, a cycle on a motor, a free motion, or only the check of a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter.errors import InputError
from planter.report.console import Console
from planter.report.folder import check_files
from planter.report.options import (
    ClusterOption,
    JsonOption,
    MachineArgument,
    ModelName,
    ModelOption,
    OutOption,
    SamplesOption,
    SectionedCommand,
    SeedOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    parse_changes,
    refuse_unused,
    text_option,
    writes_files,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from planter.engine.machine import Machine
    from planter.mechanism.ensemble import EnsembleSpec
    from planter.mechanism.file import MechanismFile
    from planter.task import Means

app = typer.Typer()
POINTS, TOLERANCE = 201, 1e-9
"""Output times of a free motion, and relative tolerance of its integrator."""

LIFT, MOTOR = "Assumptions", "On a motor, with --motor"
FREE, ENSEMBLE = "What moves freely", "Many random starts, with --ensemble"
"""Sections of the options in the help."""
CYCLE_OPTIONS = ("--model", "--samples", "--at", "--lift", "--module-mm")
MOTOR_OPTIONS = ("--stall-Nm", "--turns", "--start-rpm")
ENSEMBLE_OPTIONS = ("--since", "--period", "--perturbation", "--seed", "--workers", "--cluster")
SINGLE_OPTIONS = ("--rest", "--least-squares", "--input")
"""Options of one free motion that an ensemble does not take."""
FREE_OPTIONS = (
    "--until",
    "--points",
    "--tolerance",
    "--stiff",
    "--ensemble",
    *SINGLE_OPTIONS,
)

MOTOR_FILES, FREE_FILES = ("turn.csv",), ("values.csv", "runs.csv")
"""Files that a mode writes besides those of all."""


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


HELP = """Compute forces and motion of a machine over a cycle.

For your own mechanism: every quantity, works, and a check of the laws of mechanics. With --motor
the torque of the drive falls with its speed, which then fluctuates; your mechanism needs
`acceleration=` in its statement for that, Mechanism(..., speed=q.omega, acceleration=q.eps).

What no angle drives moves from its initial state --until a time. --ensemble integrates it from many
random starts and reports bands, statistics, and how fast the runs part, with the largest Lyapunov
exponent.

--check computes no more than what shows that a file is sound: values, gears, loops over the whole
cycle and limits; it warns of unusual values.

\b
    planter simulate wang2017 --at 0 --at 100 --out run
    planter simulate my.toml --check
    planter simulate wang2017 --motor --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.4
    planter simulate own/whipple.toml --until 4 --set v_m_s=5.5 --out ride
    planter simulate own/gear_rattle.toml --until 1 --points 2001 --ensemble 32 --since 0.2
"""


@app.command(help=HELP, cls=SectionedCommand)
@writes_files("summary.json", "report.html")
def simulate(
    machine: MachineArgument,
    check: Annotated[
        bool, typer.Option("--check", help="only check the file, and warn of unusual values")
    ] = False,
    model: ModelOption = ModelName.exact,
    samples: SamplesOption = None,
    at: Annotated[
        list[float] | None, text_option("also report at this drive angle (repeatable)", "DEG")
    ] = None,
    lift: Annotated[
        bool,
        typer.Option(
            "--lift",
            help="relax assumptions one by one and report the effect of each (exact model)",
            rich_help_panel=LIFT,
        ),
    ] = False,
    module_mm: Annotated[
        float,
        typer.Option(
            min=0.1, max=20, help="module of the teeth that --lift lets slide", rich_help_panel=LIFT
        ),
    ] = 2.0,
    motor: Annotated[
        bool,
        typer.Option(
            "--motor",
            help="compute how the speed fluctuates on a motor, and the forces",
            rich_help_panel=MOTOR,
        ),
    ] = False,
    stall_nm: Annotated[
        float | None,
        typer.Option(
            "--stall-Nm",
            help="torque of the motor at rest, referred to the drive",
            rich_help_panel=MOTOR,
        ),
    ] = None,
    idle_rpm: Annotated[
        float | None,
        typer.Option(
            help="speed of the drive at which the motor has no torque left", rich_help_panel=MOTOR
        ),
    ] = None,
    flywheel_kgm2: Annotated[
        float | None,
        typer.Option(
            help="inertia of flywheel, rotor and carrier, referred to the drive",
            rich_help_panel=MOTOR,
        ),
    ] = None,
    turns: Annotated[
        int,
        typer.Option(
            min=1, max=1000, help="number of revolutions to report", rich_help_panel=MOTOR
        ),
    ] = 5,
    start_rpm: Annotated[
        float | None,
        typer.Option(
            min=1e-3, help="speed at the start [default: the machine's]", rich_help_panel=MOTOR
        ),
    ] = None,
    until: Annotated[
        float | None,
        typer.Option(metavar="S", min=1e-9, help="end of a free motion [s]", rich_help_panel=FREE),
    ] = None,
    input_: Annotated[
        Path | None,
        typer.Option(
            "--input",
            metavar="CSV",
            help="values over time, column t_s and names of values such as F_N",
            rich_help_panel=FREE,
        ),
    ] = None,
    points: Annotated[
        int, typer.Option(min=2, max=100_000, help="number of output times", rich_help_panel=FREE)
    ] = POINTS,
    tolerance: Annotated[
        float,
        typer.Option(
            min=1e-13, max=1e-2, help="relative tolerance of the integrator", rich_help_panel=FREE
        ),
    ] = TOLERANCE,
    rest: Annotated[
        bool,
        typer.Option(
            "--rest",
            help="also find an equilibrium near the start, and its eigenvalues",
            rich_help_panel=FREE,
        ),
    ] = False,
    least_squares: Annotated[
        bool,
        typer.Option(
            "--least-squares",
            help="for over-constrained joints, also report minimum-norm reactions",
            rich_help_panel=FREE,
        ),
    ] = False,
    stiff: Annotated[
        bool,
        typer.Option(
            "--stiff",
            help="implicit steps (Radau IIA), for stiff springs and strong dampers",
            rich_help_panel=FREE,
        ),
    ] = False,
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=10_000,
            help="number of runs from random starts, for a chaotic motion",
            rich_help_panel=ENSEMBLE,
        ),
    ] = None,
    perturbation: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            min=0,
            max=1,
            help="largest change of a start, as a share of each range",
            rich_help_panel=ENSEMBLE,
        ),
    ] = 1e-3,
    since: Annotated[
        float,
        typer.Option(
            metavar="S",
            min=0,
            help="start of the statistics of an ensemble [s]",
            rich_help_panel=ENSEMBLE,
        ),
    ] = 0.0,
    period: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            min=1e-9,
            help="duration of each statistic, such as a revolution [s] [default: until the end]",
            rich_help_panel=ENSEMBLE,
        ),
    ] = None,
    seed: SeedOption = 0,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Compute a cycle or a free motion, or check a file, as the options say."""
    console = Console(as_json)
    with console.outcome():
        if not lift:
            refuse_unused("without --lift", "--module-mm")
        if not motor:
            refuse_unused("without --motor", *MOTOR_OPTIONS)
        if ensemble is None:
            refuse_unused("without --ensemble", *ENSEMBLE_OPTIONS)
        else:
            refuse_unused("with --ensemble", *SINGLE_OPTIONS)
        if out is not None:
            check_files(out, MOTOR_FILES if motor else FREE_FILES if until is not None else ())
        if check:
            other = ("--motor", *CYCLE_OPTIONS, *FREE_OPTIONS, "--out", "--overwrite")
            refuse_unused("with --check", *other)
            _show_check(console, machine, set_, speed_rpm)
            return
        if motor:
            refuse_unused("with --motor", "--model", "--at", "--lift", *FREE_OPTIONS)
            curve = {
                "--stall-Nm": stall_nm,
                "--idle-rpm": idle_rpm,
                "--flywheel-kgm2": flywheel_kgm2,
            }
            opened = open_machine(machine, set_, speed_rpm)
            _show_drive(console, opened, curve, turns, start_rpm, samples, out)
            return
        from planter.mechanism.machines import find_free_motion

        if (mechanism := find_free_motion(machine, parse_changes(set_))) is not None:
            refuse_unused(f"since {mechanism.name} moves freely", *CYCLE_OPTIONS, "--speed-rpm")
            if until is None:
                raise InputError(f"{mechanism.name} moves freely: --until S says how long")
            run = MotionOptions(until, points, tolerance, stiff)
            if ensemble is None:
                single = {"rest": rest, "minimum_norm": least_squares}
                _show_motion(console, mechanism, run, input_, single, out)
                return
            from planter.mechanism.ensemble import EnsembleSpec
            from planter.task import Means

            spec = EnsembleSpec(ensemble, perturbation, since, period, seed)
            _show_ensemble(console, mechanism, run, spec, Means(workers, cluster), out)
            return
        opened = open_machine(machine, set_, speed_rpm, model)
        refuse_unused("since an angle drives the machine", *FREE_OPTIONS)
        from planter.mechanism.cycle import simulate_machine
        from planter.mechanism.presentation import present_cycle

        cycle = simulate_machine(opened, samples, at or (), module_mm if lift else None)
        present_cycle(cycle).show(console, out)


@dataclass(frozen=True)
class MotionOptions:
    """Options of every integration of a free motion: its end [s], number of output times, relative
    tolerance, and whether steps are implicit.
    """

    until: float
    points: int
    tolerance: float
    stiff: bool


def _show_check(
    console: Console, source: str, set_: Sequence[str] | None, speed_rpm: float | None
) -> None:
    """Print what is wrong or unusual in a machine's file."""
    from planter.mechanism.cycle import validate_machine
    from planter.mechanism.machines import find_free_motion
    from planter.mechanism.motion import validate_free_motion
    from planter.mechanism.presentation import present_validation

    if (mechanism := find_free_motion(source, parse_changes(set_))) is not None:
        presentation = present_validation(validate_free_motion(mechanism), source)
    else:
        opened = open_machine(source, set_, speed_rpm)
        presentation = present_validation(validate_machine(opened), source, opened)
    presentation.show(console)


def _show_drive(
    console: Console,
    machine: Machine,
    curve: Mapping[str, float | None],
    turns: int,
    start_rpm: float | None,
    samples: int | None,
    out: Path | None,
) -> None:
    """Compute a cycle on a motor, print it, and write it into a folder if one is named.

    `curve` holds the motor's options. Raises InputError for the first that is missing.
    """
    from planter.engine.drive import Motor, drive_machine
    from planter.engine.machine import check_samples
    from planter.files import units
    from planter.mechanism.extension import find_extension
    from planter.mechanism.presentation import present_drive

    missing = [option for option, value in curve.items() if value is None]
    if missing:
        raise InputError(f"--motor needs {missing[0]}")
    check_samples(samples)
    rad_s = units.unit_factor("idle_rpm")
    stall_nm, idle_rpm, flywheel_kgm2 = (value for value in curve.values() if value is not None)
    motor = Motor(stall_nm, idle_rpm * rad_s, flywheel_kgm2)
    start = None if start_rpm is None else start_rpm * rad_s
    driven = find_extension(machine).build_driven_machine()
    present_drive(drive_machine(driven, motor, turns, start, samples)).show(console, out)


def _show_motion(
    console: Console,
    file: MechanismFile,
    options: MotionOptions,
    input_: Path | None,
    single: Mapping[str, Any],
    out: Path | None,
) -> None:
    """Integrate a free motion, print it, and write it into a folder if one is named."""
    from planter.mechanism.dynamics import Dynamics
    from planter.mechanism.input_history import read_history
    from planter.mechanism.machines import build_free_machine
    from planter.mechanism.motion import compute_motion
    from planter.mechanism.optimisation import judge_motion
    from planter.mechanism.presentation import present_motion

    history = None if input_ is None else read_history(input_, file)
    motion = compute_motion(
        Dynamics(file, history),
        options.until,
        options.points,
        options.tolerance,
        stiff=options.stiff,
        **single,
    )
    if file.measure_limits and history is None:
        motion = judge_motion(motion, build_free_machine(file))
    elif file.measure_limits:
        console.say("limits are not judged: those of the file are on its motion without --input")
    if single["minimum_norm"] and not motion.result.undetermined_actions:
        console.say("--least-squares adds nothing: no reaction is statically indeterminate")
    present_motion(motion, file).show(console, out)


def _show_ensemble(
    console: Console,
    file: MechanismFile,
    options: MotionOptions,
    spec: EnsembleSpec,
    means: Means,
    out: Path | None,
) -> None:
    """Integrate a free motion from many starts, print it, and write it into a folder if one is
    named.
    """
    from planter.mechanism.ensemble import compute_ensemble
    from planter.mechanism.presentation import present_ensemble

    runs = compute_ensemble(
        file,
        options.until,
        options.points,
        spec,
        options.tolerance,
        options.stiff,
        means,
        console.progress,
    )
    present_ensemble(runs, file).show(console, out)
