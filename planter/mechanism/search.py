"""`planter optimise FILE` for a mechanism of one's own: options, search, result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError
from planter.files.units import factor

if TYPE_CHECKING:
    from planter.engine.search import Sampling
    from planter.mechanism.file import MechanismFile
    from planter.optimise.hybrid import Method
    from planter.terminal.console import Console

LeastOption = Annotated[
    str | None,
    typer.Option(
        metavar="SUM",
        help="for a mechanism of your own, instead of the sum in its file: what to minimise, such as "
        '"range F_Ox + 0.5 rms M_in" (max, min, range, mean, variance, std, rms, work, or NAME at DEG, or NAME where '
        "NAME is least; each also while NAME <= NUMBER)",
        show_default=False,
    ),
]
HoldOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="LIMIT",
        help='for a mechanism of your own, beside the limits in its file: a limit, such as "abs F_Ax <= 300 N" '
        "(repeatable)",
        show_default=False,
    ),
]
RPM = factor("speed_rpm")
NO_STAGES = "it has no gear stages"
REFUSED = {
    "--model": "it has one model, its statement",
    "--front": "the front weighs the range of a support force against its variance",
    "--prove": "the proof bounds range and variance of a support force",
    "--teeth": NO_STAGES,
    "--module": NO_STAGES,
    "--module1": NO_STAGES,
    "--module2": NO_STAGES,
}
"""Options of `planter optimise` that do not apply to mechanisms of one's own, with the reason."""


@dataclass(frozen=True)
class SearchOptions:
    """What a call says of the search; None leaves it to the file or to defaults."""

    method: Method | None = None
    samples: Sampling | None = None
    seed: int = 0
    starts: int | None = None


def load_mechanism(source: str, changes: Mapping[str, float], speed_rpm: float | None) -> MechanismFile:
    """Return the file of a mechanism, its drive's speed [r/min] set if it is given."""
    from planter.mechanism import file
    from planter.mechanism.machines import build_machine

    mechanism = file.load(source, changes)
    if speed_rpm is None:
        return mechanism
    machine = build_machine(mechanism)
    speed = machine.values[machine.speed]
    return file.load(source, {**changes, speed.path: speed_rpm * RPM / speed.factor})


def search(
    console: Console, mechanism: MechanismFile, least: str | None, holds: Sequence[str], options: SearchOptions,
    out: Path | None, besides: Mapping[str, bool],
) -> None:  # fmt: skip
    """Find, print and write the optimum. Raises InputError for options that do not apply to the mechanism."""
    if wrong := [option for option, present in besides.items() if present]:
        raise InputError(f"{wrong[0]} does not apply to {mechanism.name}: {REFUSED[wrong[0]]}")
    from planter.engine.search import SearchSpec
    from planter.mechanism import optimisation, tables
    from planter.optimise.sections import DEFAULT_GENETIC
    from planter.optimise.starts import DEFAULT_STARTS

    objective = mechanism.objective
    spec = SearchSpec(
        sampling=options.samples or (objective.samples if objective else "refined"),
        method=options.method or "ipopt",
        starts=options.starts or DEFAULT_STARTS,
        seed=options.seed,
        genetic=mechanism.genetic_algorithm or DEFAULT_GENETIC,
    )
    found = optimisation.optimise(mechanism, least, holds, spec, console.progress)
    if out is not None:
        from planter.mechanism.report import results

        results.write_optimum(out, found, console.progress)
    console.result(found.result, lambda: tables.optimum(console, found.result))
