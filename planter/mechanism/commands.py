"""Commands for mechanisms of one's own."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, SetOption, changes

app = typer.Typer()


MechanismArgument = Annotated[
    str, typer.Argument(help="a mechanism's file (TOML), or its name: NAME.toml here or in generated/")
]


@app.command()
@writes("summary.json", "values.csv", "report.html")
def move(
    mechanism: MechanismArgument,
    until: Annotated[float, typer.Option(metavar="S", min=1e-9, help="end of the motion [s]")],
    points: Annotated[int, typer.Option(min=2, max=100_000, help="number of output times")] = 201,
    tolerance: Annotated[float, typer.Option(min=1e-13, max=1e-2, help="relative tolerance of the integrator")] = 1e-9,
    rest: Annotated[
        bool, typer.Option("--rest", help="also find an equilibrium near the start, and its eigenvalues")
    ] = False,
    least_squares: Annotated[
        bool,
        typer.Option("--least-squares", help="for over-constrained joints, also report minimum-norm reactions"),
    ] = False,
    stiff: Annotated[
        bool, typer.Option("--stiff", help="implicit steps (Radau IIA), for stiff springs and strong dampers")
    ] = False,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Integrate the free motion of your mechanism.

    No angle drives it; it starts from its initial state.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism import dynamics, file, motion, tables

        machine = file.load(mechanism, changes(set_))
        found = motion.move(dynamics.Dynamics(machine), until, points, tolerance, rest, least_squares, stiff)
        if out is not None:
            from planter.mechanism.report import results

            results.write_motion(out, found, machine, console.progress)
        console.result(found.result, lambda: tables.motion(console, found.result))
