"""The command `planter move`, and what other commands do for every machine that the engine
takes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.report.writing import find_proof, interruptible_result, writes_files
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    SeedOption,
    SetOption,
    WorkersOption,
    parse_changes,
    refuse_unused,
)

if TYPE_CHECKING:
    from planter.engine.drive import Motor
    from planter.engine.machine import Machine
    from planter.engine.search import SearchSpec
    from planter.files.document import Document
    from planter.measured.calibration import Calibrated, ValidationMeasurement
    from planter.measured.reading import Columns
    from planter.mechanism.optimisation import MechanismOptimum
    from planter.optimise.optimiser import Method
    from planter.optimise.range_variance import Sampling
    from planter.parallel.task import Means
    from planter.progress import Listener

app = typer.Typer()

MechanismArgument = Annotated[
    str,
    typer.Argument(help="a mechanism's file (TOML), or its name: NAME.toml here or in generated/"),
]

NO_STAGES = "it has no gear stages"
REFUSED = {
    "--flank": "it has no cam whose flanks a paper leaves open",
    "--target": "no paper reports figures of it; --data takes a measured curve",
    "--lift": "it lifts assumptions of the planting device",
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
            refuse_unused("with --ensemble", "--rest", "--least-squares")
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
        motion = compute_motion(
            Dynamics(file), until, points, tolerance, rest, least_squares, stiff
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


def run_validate(
    console: Console, source: str, values: Mapping[str, float], speed_rpm: float | None
) -> None:
    """Validate the machine of a file or of a built-in name, and print limits and warnings."""
    from planter.engine.machine import load_machine
    from planter.mechanism import cycle, file, machines
    from planter.mechanism.presentation import present_validation

    if machines.takes(source) and not (mechanism := file.load(source, values)).is_driven:
        result = cycle.validate_free_motion(mechanism)
    else:
        result = cycle.validate_machine(load_machine(source, values, speed_rpm))
    present_validation(result, source).show(console)


def run_simulate(
    console: Console,
    machine: Machine,
    samples: int | None,
    at_deg: Sequence[float],
    out: Path | None,
) -> None:
    """Simulate a cycle, print it, and write it into a folder if one is named."""
    from planter.mechanism.cycle import simulate_machine
    from planter.mechanism.presentation import present_cycle

    present_cycle(simulate_machine(machine, samples, at_deg)).show(console, out)


def run_sensitivity(
    console: Console,
    machine: Machine,
    objective: str | None,
    samples: int | None,
    all_values: bool,
    out: Path | None,
) -> None:
    """Compute a sensitivity, print it, and write it into a folder if one is named."""
    from planter.mechanism.optimisation import compute_objective_sensitivity
    from planter.mechanism.presentation import present_sensitivity

    result = compute_objective_sensitivity(machine, objective, samples, all_values)
    present_sensitivity(result, machine).show(console, out)


def run_drive(
    console: Console,
    machine: Machine,
    motor: Motor,
    turns: int,
    start: float | None,
    samples: int | None,
    out: Path | None,
) -> None:
    """Compute a machine on a motor from a speed [rad/s], print it, and write it into a folder if
    one is named.
    """
    from planter.engine.drive import drive_machine
    from planter.engine.machine import check_samples
    from planter.mechanism.presentation import present_drive

    check_samples(samples)
    present_drive(drive_machine(machine, motor, turns, start, samples)).show(console, out)


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


def require_measurable(machine: Machine, quantities: Sequence[str]) -> None:
    """Raise InputError if no quantity or an unknown one is named, ComputationError for one that
    does not repeat.
    """
    from planter.measured.curve import find_measured
    from planter.measured.sensor_view import find_sensor_view
    from planter.mechanism.model import require_repeating

    if not quantities:
        keys = ", ".join(result.key for result in machine.results)
        raise InputError(f"--quantity must name what was measured: it must be one of {keys}")
    names = [find_measured(machine, quantity).name for quantity in quantities]
    view = find_sensor_view(machine)
    if view is not None and view.quantity.name in names:
        names += [find_measured(machine, key).name for key in view.needed]
    require_repeating(machine, dict.fromkeys(names))


def calibrate_machine(
    machine: Machine,
    data: str | Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantity: str | Sequence[str] | None,
    check: ValidationMeasurement | None = None,
    seed: int = 0,
    progress: Listener | None = None,
    means: Means | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> Calibrated:
    """Fit values within `bounds` (display units, by key) to measured curves of one or several
    quantities.

    Without `quantity` it is that of the file's [measurement]. `means` are the processes of the
    searches, on which results do not depend; `priors` are those of
    `planter.measured.calibration.calibrate`. Raises InputError for a file, columns, values or a
    quantity that cannot be used, ComputationError for a quantity that does not repeat after a
    cycle.
    """
    from planter.measured.calibration import calibrate
    from planter.measured.sensor_view import list_measured
    from planter.parallel.task import AUTO

    quantities = list_measured(machine.document, quantity)
    require_measurable(machine, quantities)
    builders = {"derived": partial(machine.build, machine.document)}
    rebuild = machine.document.with_numbers
    return calibrate(
        builders,
        data,
        columns,
        bounds,
        quantities,
        rebuild,
        check,
        seed,
        progress,
        means or AUTO,
        priors,
    )


def run_preview(
    console: Console,
    machine: Machine,
    data: Path,
    columns: Columns,
    quantities: Sequence[str],
    out: Path | None,
) -> None:
    """Print what is understood of a measured file, and write it into a folder if one is named.

    Without a column of values, the columns are listed.
    """
    from planter.measured.calibration import find_units
    from planter.measured.curve import find_measured
    from planter.measured.findings import MeasuredPreview
    from planter.measured.logger_table import read_logger_table
    from planter.measured.presentation import present_preview
    from planter.measured.reading import describe_columns, read_curves

    columns.check_places()
    table = read_logger_table(data)
    measured = None
    if columns.names or columns.has_positions:
        units = find_units(machine, columns, quantities if columns.names else ())
        measured = read_curves(table, columns, float(machine.data[machine.speed]), units)
    result = MeasuredPreview(
        machine=machine.name,
        quantity=[find_measured(machine, quantity).key for quantity in quantities],
        columns=describe_columns(table),
        reading=None if measured is None else measured.reading,
        treatment=[table.describe()] if measured is None else list(measured.treatment),
    )
    present_preview(machine.document, result, measured, machine.meanings).show(console, out)


def run_explain(
    console: Console,
    machine: Machine,
    data: Path,
    columns: Columns,
    bounds: Mapping[str, tuple[float, float]],
    quantities: Sequence[str],
    seed: int,
    priors: Mapping[str, tuple[float, float]],
    out: Path | None,
    model: str = "derived",
    angle: str | None = None,
) -> None:
    """Print what explains the measured curve of a quantity of a machine, and write it into a folder
    if one is named.
    """
    from planter.engine.wording import name_angle
    from planter.measured.explanations import read_and_explain
    from planter.measured.presentation import present_explained

    rebuild = machine.document.with_numbers
    explained = read_and_explain(
        machine, model, data, columns, bounds, quantities, rebuild, seed, console.progress, priors
    )
    present_explained(
        machine.document, explained, machine.meanings, angle or name_angle(machine)
    ).show(console, out)


def run_calibrate(
    console: Console,
    document: Document,
    meanings: Mapping[str, str],
    calibrated: Calibrated,
    out: Path | None,
    angle: str = "angle of the drive",
) -> None:
    """Print the fit of a file, whose values have `meanings` by path, and write it into a folder if
    one is named.
    """
    from planter.measured.presentation import present_fit

    present_fit(document, calibrated, meanings, angle).show(console, out)
