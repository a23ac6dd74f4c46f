"""The command `planter linearise`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from planter.report.completion import complete_machines
from planter.report.console import Console
from planter.report.options import JsonOption, OutOption, SetOption, parse_changes, writes_files

app = typer.Typer()


class OperatingPoint(StrEnum):
    """The state about which a model is linearised."""

    start = "start"
    rest = "rest"


@app.command("linearise")
@writes_files("summary.json", "report.html")
def linearise_mechanism(
    mechanism: Annotated[
        str,
        typer.Argument(
            metavar="MECHANISM",
            help="file (TOML) or name of a mechanism that moves freely",
            autocompletion=complete_machines,
        ),
    ],
    at: Annotated[
        OperatingPoint,
        typer.Option(help="at the start, or at the equilibrium that is nearest to it"),
    ] = OperatingPoint.start,
    input_: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="NAME",
            help="value of the file that is an input, beside those of the statement (repeatable)",
        ),
    ] = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Linearise a mechanism: A, B, C, D, eigenvalues.

    x' = A x + B u and y = C x + D u hold for small changes of coordinates and rates x, inputs u and
    outputs y, in SI units and radians. Constraints that follow from others are left out. The
    minimal form has states that no constraint ties to each other.

    For example: planter linearise cartpole.toml --input F_N --at rest --json
    """
    console = Console(as_json)
    with console.outcome():
        from planter.mechanism.dynamics import Dynamics
        from planter.mechanism.file import load
        from planter.mechanism.state_space.linearisation import linearise_model
        from planter.mechanism.state_space.model import DynamicsModel
        from planter.mechanism.state_space.presentation import present_linear_model

        file = load(mechanism, parse_changes(set_))
        model = DynamicsModel(Dynamics(file), input_ or ())
        result = linearise_model(model, at is OperatingPoint.rest)
        present_linear_model(result, file).show(console, out)
