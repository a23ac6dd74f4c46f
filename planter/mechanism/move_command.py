"""`planter move`: free motion, which no angle drives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.report.console import Console
from planter.report.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    SeedOption,
    SetOption,
    WorkersOption,
    parse_changes,
    refuse_unused,
    writes_files,
)

if TYPE_CHECKING:
    from planter.mechanism.file import MechanismFile

app = typer.Typer()
POINTS, TOLERANCE = 201, 1e-9
"""Output times of a free motion, and relative tolerance of its integrator."""

MechanismArgument = Annotated[
    str,
    typer.Argument(help="a mechanism's file (TOML), or its name: NAME.toml here or in generated/"),
]

InputOption = Annotated[
    Path | None,
    typer.Option(
        "--input",
        metavar="CSV",
        help="of what moves freely: values over time, column t_s and names of values such as F_N",
        show_default=False,
    ),
]
UNTIL = typer.Option(metavar="S", min=1e-9, help="end of a free motion [s]", show_default=False)


def show_motion(
    console: Console,
    file: MechanismFile,
    until: float,
    input_: Path | None,
    out: Path | None,
    points: int = POINTS,
    tolerance: float = TOLERANCE,
    rest: bool = False,
    least_squares: bool = False,
    stiff: bool = False,
) -> None:
    """Integrate a free motion, print it, and write it into a folder if one is named."""
    from planter.mechanism.dynamics import Dynamics
    from planter.mechanism.input_history import read_history
    from planter.mechanism.machines import build_free_machine
    from planter.mechanism.motion import compute_motion
    from planter.mechanism.optimisation import judge_motion
    from planter.mechanism.presentation import present_motion

    history = None if input_ is None else read_history(input_, file)
    dynamics = Dynamics(file, history)
    motion = compute_motion(dynamics, until, points, tolerance, rest, least_squares, stiff)
    if file.measure_limits and history is None:
        motion = judge_motion(motion, build_free_machine(file))
    elif file.measure_limits:
        console.say("limits are not judged: those of the file are on its motion without --input")
    if least_squares and not motion.result.undetermined_actions:
        console.say("--least-squares adds nothing: no reaction is statically indeterminate")
    present_motion(motion, file).show(console, out)


@app.command()
@writes_files("summary.json", "values.csv", "runs.csv", "report.html")
def move(
    mechanism: MechanismArgument,
    until: Annotated[float, UNTIL],
    points: Annotated[
        int, typer.Option(min=2, max=100_000, help="number of output times")
    ] = POINTS,
    tolerance: Annotated[
        float, typer.Option(min=1e-13, max=1e-2, help="relative tolerance of the integrator")
    ] = TOLERANCE,
    rest: Annotated[
        bool,
        typer.Option("--rest", help="also find an equilibrium near the start, and its eigenvalues"),
    ] = False,
    least_squares: Annotated[
        bool,
        typer.Option(
            "--least-squares",
            help="for over-constrained joints, also report minimum-norm reactions",
        ),
    ] = False,
    stiff: Annotated[
        bool,
        typer.Option(
            "--stiff", help="implicit steps (Radau IIA), for stiff springs and strong dampers"
        ),
    ] = False,
    input_: InputOption = None,
    ensemble: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=10_000,
            help="number of runs from random starts, for a chaotic motion",
            show_default=False,
        ),
    ] = None,
    perturbation: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            min=0,
            max=1,
            help="largest change of a start, as a share of each range",
        ),
    ] = 1e-3,
    since: Annotated[
        float, typer.Option(metavar="S", min=0, help="start of the statistics of an ensemble [s]")
    ] = 0.0,
    period: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            min=1e-9,
            help="duration of each statistic, such as a revolution [s] [default: until the end]",
            show_default=False,
        ),
    ] = None,
    seed: SeedOption = 0,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Integrate the free motion of your mechanism.

    No angle drives it; it starts from its initial state. --ensemble integrates it from many random
    starts near that one and reports bands, statistics, and how fast the runs part, with the largest
    Lyapunov exponent.

    Rattling gears: planter move own/gear_rattle.toml --until 1 --points 2001 --ensemble 32 --since
    0.2 --period 0.05236 --out rattle
    """
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism.file import load

        if ensemble is None:
            refuse_unused(
                "without --ensemble",
                "--since",
                "--period",
                "--perturbation",
                "--seed",
                "--workers",
                "--cluster",
            )
        else:
            refuse_unused("with --ensemble", "--rest", "--least-squares", "--input")
        file = load(mechanism, parse_changes(set_))
        if ensemble is not None:
            from planter.mechanism.ensemble import EnsembleSpec, compute_ensemble
            from planter.mechanism.presentation import present_ensemble
            from planter.task import Means

            spec = EnsembleSpec(ensemble, perturbation, since, period, seed)
            means = Means(workers, cluster)
            runs = compute_ensemble(
                file, until, points, spec, tolerance, stiff, means, console.progress
            )
            present_ensemble(runs, file).show(console, out)
            return
        show_motion(
            console, file, until, input_, out, points, tolerance, rest, least_squares, stiff
        )
