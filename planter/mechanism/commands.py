"""The commands of all machines that the engine takes: analyses, `planter calibrate`, `planter move`,
and the search of `planter optimise`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.mechanism import analysis_commands, calibrate_command
from planter.report.writing import find_proof, interruptible_result, writes_files
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    SeedOption,
    SetOption,
    WorkersOption,
    join_applications,
    parse_changes,
    refuse_unused,
)

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.engine.search import SearchSpec
    from planter.mechanism.optimisation import MechanismOptimum
    from planter.optimise.optimiser import Method
    from planter.optimise.range_variance import Sampling
    from planter.parallel.task import Means

app = join_applications(analysis_commands.app, calibrate_command.app)

MechanismArgument = Annotated[
    str,
    typer.Argument(help="a mechanism's file (TOML), or its name: NAME.toml here or in generated/"),
]

NO_STAGES = "it has no gear stages"
REFUSED = {
    "--model": "it has one model, its statement",
    "--teeth": NO_STAGES,
    "--module": NO_STAGES,
    "--module1": NO_STAGES,
    "--module2": NO_STAGES,
}
"""Options that do not apply to machines of one model, with the reason."""


@app.command()
@writes_files("summary.json", "values.csv", "runs.csv", "report.html")
def move(
    mechanism: MechanismArgument,
    until: Annotated[float, typer.Option(metavar="S", min=1e-9, help="end of the motion [s]")],
    points: Annotated[int, typer.Option(min=2, max=100_000, help="number of output times")] = 201,
    tolerance: Annotated[
        float, typer.Option(min=1e-13, max=1e-2, help="relative tolerance of the integrator")
    ] = 1e-9,
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
    input_: Annotated[
        Path | None,
        typer.Option(
            "--input",
            metavar="CSV",
            help="values over time: column t_s, and names of values such as F_N",
            show_default=False,
        ),
    ] = None,
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
        from planter.mechanism.dynamics import Dynamics
        from planter.mechanism.file import load
        from planter.mechanism.input_history import read_history
        from planter.mechanism.motion import compute_motion
        from planter.mechanism.presentation import present_motion

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
            from planter.parallel.task import Means

            spec = EnsembleSpec(ensemble, perturbation, since, period, seed)
            means = Means(workers, cluster)
            runs = compute_ensemble(
                file, until, points, spec, tolerance, stiff, means, console.progress
            )
            present_ensemble(runs, file).show(console, out)
            return
        history = None if input_ is None else read_history(input_, file)
        motion = compute_motion(
            Dynamics(file, history), until, points, tolerance, rest, least_squares, stiff
        )
        if least_squares and not motion.result.undetermined_actions:
            console.say("--least-squares adds nothing: no reaction is statically indeterminate")
        present_motion(motion, file).show(console, out)


def refuse_options(machine: Machine, options: Mapping[str, bool]) -> None:
    """Raise InputError for the first option that is present, with the reason why it does not apply
    to the machine.
    """
    for option, is_present in options.items():
        if is_present:
            raise InputError(f"{option} does not apply to {machine.name}: {REFUSED[option]}")


@dataclass(frozen=True)
class SearchOptions:
    """Options of a search; None leaves a value to the file or to defaults, and no `prove_seconds`
    means no proof.
    """

    method: Method | None
    front: bool
    samples: Sampling | None
    seed: int
    starts: int | None
    prove_seconds: float | None
    means: Means
    vary: Mapping[str, tuple[float, float]]


def run_optimise(
    console: Console,
    machine: Machine,
    objective: str | None,
    holds: Sequence[str],
    options: SearchOptions,
    out: Path | None,
) -> None:
    """Find an optimum, with its front and its proof if the options ask for them, print and write
    it.
    """
    from planter.engine.front import require_front
    from planter.engine.search import SearchSpec
    from planter.mechanism import optimisation, proof
    from planter.mechanism.file import MechanismFile
    from planter.mechanism.presentation import present_optimum
    from planter.optimise.local_search import DEFAULT_STARTS
    from planter.optimise.sections import DEFAULT_GENETIC

    spec = SearchSpec(
        sampling=options.samples or machine.sampling,
        method=options.method or "auto",
        starts=options.starts or DEFAULT_STARTS,
        seed=options.seed,
        genetic=machine.genetic or DEFAULT_GENETIC,
    )
    machine = machine.with_ranges(options.vary)
    file = machine.document
    if options.prove_seconds is not None and not isinstance(file, MechanismFile):
        reason = "there are no bounds of its quantities"
        raise InputError(f"--prove does not apply to {machine.name} with --least: {reason}")
    goal = optimisation.StatedGoal.read(machine, objective, holds)
    if options.front:
        goal.require_objective()
        require_front(goal.build_problem(spec.sampling))
    if options.prove_seconds is not None:
        proof.require_provable(goal, objective)
    optimum = _search_optimum(console, machine, objective, holds, spec, options.means, out)
    with interruptible_result(optimum.result.table()):
        if out is not None:
            present_optimum(optimum).write_data(out)  # before what takes long
        if options.prove_seconds is not None and isinstance(file, MechanismFile):
            earlier, keep = find_proof(out)
            optimum = proof.with_proof(
                file,
                optimum,
                goal,
                spec,
                options.prove_seconds,
                console.progress,
                options.means,
                earlier,
                keep,
            )
        if options.front:
            optimum = optimisation.with_front(optimum, console.progress)
        present_optimum(optimum).show(console, out)


def _search_optimum(
    console: Console,
    machine: Machine,
    objective: str | None,
    holds: Sequence[str],
    spec: SearchSpec,
    means: Means,
    out: Path | None,
) -> MechanismOptimum:
    """Return the optimum; what is there before it, or without it, is written into the folder if one
    is named.

    Raises FailedSearchError, which names the file of the closest design, if there is none.
    """
    from planter.engine.search import FailedSearchError
    from planter.mechanism import optimisation
    from planter.mechanism.presentation import CLOSEST_FILE, write_unfinished
    from planter.report.folder import drop_file

    keep = None if out is None else partial(write_unfinished, out)
    try:
        optimum = optimisation.optimise_machine(
            machine, objective, holds, spec, console.progress, means, keep
        )
    except FailedSearchError as error:
        if error.candidate is None or error.candidate.is_feasible:
            raise
        hint = f"--out DIR writes {CLOSEST_FILE}" if out is None else f"{out / CLOSEST_FILE} has it"
        failure = FailedSearchError(f"{error.message}; {hint}", error.candidate)
        failure.partial = error.partial
        raise failure from None
    if out is not None:
        drop_file(out / CLOSEST_FILE)
    return optimum
