"""`planter optimise NAME --least ... --hold ...`: what that command does for a mechanism of one's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from planter.errors import InputError

if TYPE_CHECKING:
    from planter.terminal.console import Console

LeastOption = Annotated[
    str | None,
    typer.Option(
        metavar="SUM",
        help='for a mechanism of your own: what to make least, such as "range F_Ox + 0.5 rms M_in" (max, min, range, '
        "mean, rms, variance, or NAME at DEG)",
        show_default=False,
    ),
]
HoldOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="LIMIT", help='with --least: a limit, such as "abs F_Ax <= 300" (repeatable)', show_default=False
    ),
]


def search(
    console: Console, source: str, least: str, holds: Sequence[str], starts: int | None, seed: int,
    changed: Mapping[str, float], out: Path | None, besides: Mapping[str, bool],
) -> None:  # fmt: skip
    """Find, print and write the optimum. Raises InputError for options that do not go together."""
    if wrong := [option for option, given in besides.items() if given]:
        raise InputError(f"{', '.join(wrong)} does not go with --least, which is for mechanisms of one's own")
    from planter.mechanism import file, optimisation, tables

    machine = file.load(source, changed)
    found = optimisation.optimise(machine, least, holds, starts or optimisation.STARTS, seed, console.progress)
    if out is not None:
        from planter.mechanism.report import results

        results.write_optimum(out, found, console.progress)
    console.result(found.result, lambda: tables.optimum(console, found.result))
