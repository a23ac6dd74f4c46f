"""The commands of all machines that the engine takes: `planter simulate`, analyses, `planter
calibrate`, and the search of `planter optimise`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from planter.errors import InputError
from planter.mechanism import analysis_commands, calibrate_command, simulate_command
from planter.report.console import Console
from planter.report.options import (
    find_proof,
    interruptible_result,
    join_applications,
)

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.engine.search import SearchSpec
    from planter.engine.solvers.curve_sum import Sampling
    from planter.engine.solvers.optimiser import Method
    from planter.mechanism.optimisation import MechanismOptimum
    from planter.task import Means

app = join_applications(simulate_command.app, analysis_commands.app, calibrate_command.app)

NO_STAGES = "it has no gear stages"
REFUSED = {
    "--model": "it has one model, its statement",
    "--teeth": NO_STAGES,
    "--module": NO_STAGES,
    "--module1": NO_STAGES,
    "--module2": NO_STAGES,
}
"""Options that do not apply to machines of one model, with the reason."""


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
    from planter.engine.sections import DEFAULT_GENETIC
    from planter.engine.solvers.local_search import DEFAULT_STARTS
    from planter.mechanism import optimisation, proof
    from planter.mechanism.file import MechanismFile
    from planter.mechanism.presentation import present_optimum

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
    from planter.mechanism.presentation import write_unfinished
    from planter.report.folder import CLOSEST_FILE, drop_file

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
