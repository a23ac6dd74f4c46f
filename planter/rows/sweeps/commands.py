"""Command of sweeps."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError
from planter.report.console import Console
from planter.report.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    WorkersOption,
    refuse_unused,
)
from planter.report.writing import writes_files

app = typer.Typer()

HELP = """Evaluate a machine over ranges of its inputs.

The result has a table of rows, the envelope of every output, and maps.

PLAN is a TOML file:

\b
    machine = "wang2017"            # a file or a built-in name, or a list of them
    scheme = "grid"                 # grid, sobol or latin
    outputs = ["support_range_N", "M_L_max_Nm"]
    [inputs]
    model = ["exact", "printed"]
    speed_rpm = { from = 35, to = 45, steps = 11 }
    "mass.planet_kg" = [1.1, 1.2, 1.3]

The schemes sobol and latin need `points`, and may have a `seed`; their ranges have no steps. `[[map]]` tables with
x, y and output choose the maps that are drawn. --list MACHINE lists all inputs and outputs.

Rows are computed in chunks of 10000. With --out finished chunks are saved: run the same command again to resume.
Results are the same for any number of workers. From 20000 rows on, all cores are used.

\b
    planter sweep docs/examples/sweep_speed.toml --out run
    planter sweep plan.toml --cluster tcp://host:8786
"""


@app.command(help=HELP)
@writes_files("summary.json", "rows.csv", "rows.parquet", "report.html")
def sweep(
    plan: Annotated[
        Path | None, typer.Argument(metavar="PLAN", help="a plan (TOML)", show_default=False)
    ] = None,
    listed: Annotated[
        str | None,
        typer.Option(
            "--list",
            metavar="MACHINE",
            help="list the inputs and outputs of a machine",
            show_default=False,
        ),
    ] = None,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    console = Console(as_json)
    with console.outcome():
        from planter.rows.sweeps import command
        from planter.rows.sweeps.plan import load_plan
        from planter.rows.sweeps.presentation import present_inputs
        from planter.rows.sweeps.sweep import PARQUET_HINT, has_parquet
        from planter.task import Means

        if (plan is None) == (listed is None):
            raise InputError("name either a PLAN or --list MACHINE")
        if listed is not None:
            refuse_unused("with --list", "--workers", "--cluster", "--out")
            present_inputs(command.list_inputs(listed)).show(console)
            return
        assert plan is not None
        presentation = command.compute_sweep(
            load_plan(plan), out, Means(workers, cluster), console.progress
        )
        if out is not None and not has_parquet():
            console.say(PARQUET_HINT)
        presentation.show(console)
