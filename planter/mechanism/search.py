"""`planter optimise` of any machine for a sum of measures: options, search, result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planter.errors import InputError

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.optimise.hybrid import Method
    from planter.optimise.range_and_spread import Sampling
    from planter.parallel.task import Means
    from planter.terminal.console import Console


@dataclass(frozen=True)
class SearchOptions:
    """What a call says of the search; None leaves it to the file or to defaults, and makes no proof."""

    method: Method | None
    front: bool
    samples: Sampling | None
    seed: int
    starts: int | None
    prove_seconds: float | None
    means: Means
    vary: Mapping[str, tuple[float, float]]


def search(
    console: Console, machine: Machine, least: str | None, holds: Sequence[str], options: SearchOptions,
    out: Path | None,
) -> None:  # fmt: skip
    """Find, print and write the optimum, with its proof if one is asked for."""
    from planter.engine.search import SearchSpec
    from planter.mechanism import optimisation, proof, tables
    from planter.mechanism.file import MechanismFile
    from planter.optimise.sections import DEFAULT_GENETIC
    from planter.optimise.starts import DEFAULT_STARTS

    spec = SearchSpec(
        sampling=options.samples or machine.sampling,
        method=options.method or "ipopt",
        starts=options.starts or DEFAULT_STARTS,
        seed=options.seed,
        genetic=machine.genetic or DEFAULT_GENETIC,
    )
    machine = machine.with_ranges(options.vary)
    file = machine.document
    if options.prove_seconds is not None and not isinstance(file, MechanismFile):
        raise InputError(
            f"--prove does not apply to {machine.name} with --least: there are no bounds of its quantities"
        )
    goal = optimisation.StatedGoal.read(machine, least, holds)
    if options.front:
        goal.require_least()
        optimisation.require_front(goal.build_problem(spec.sampling))
    if options.prove_seconds is not None:
        proof.require_provable(goal, least)
    optimum = optimisation.optimise(machine, least, holds, spec, console.progress, options.means)
    if options.prove_seconds is not None and isinstance(file, MechanismFile):
        optimum = proof.with_proof(file, optimum, goal, spec, options.prove_seconds, console.progress, options.means)
    if options.front:
        optimum = optimisation.with_front(optimum, console.progress)
    if out is not None:
        from planter.mechanism.report import results

        results.write_optimum(out, optimum, console.progress)
    console.result(optimum.result, lambda: tables.optimum(console, optimum.result))
