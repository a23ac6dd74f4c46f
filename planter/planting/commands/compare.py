"""`planter compare`: all pairs of gear families under the same requirements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer

from planter.planting.commands.options import DeviceArgument, kept, machine_of
from planter.report.writing import writes
from planter.terminal.console import Console
from planter.terminal.options import (
    ClusterOption,
    JsonOption,
    OutOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    listing,
)

app = typer.Typer()


def _families() -> Iterable[str]:
    from planter.gear_geometry import families

    return families.list_families()


@app.command(cls=listing(pair=_families))
@writes("summary.json", "devices.csv", "report.html", figures=("comparison",))
def compare(
    machine: DeviceArgument,
    starts: Annotated[int, typer.Option(min=1, help="local searches for each pair")] = 3,
    seed: Annotated[int, typer.Option(min=0, help="random seed")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="continue with the results in the folder of --out")] = False,
    pair: Annotated[
        list[str] | None,
        typer.Option(metavar="FAMILY+FAMILY", help="only this pair (repeatable), of families", show_default=False),
    ] = None,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    set_: SetOption = None,
    speed_rpm: SpeedOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Optimise every pair of gear families and rank them.

    All have the same wide bounds and the machine's requirements.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.planting.compare import run, tables
        from planter.planting.compare.box import chosen
        from planter.report.folder import renewing

        own = machine_of(machine, set_, speed_rpm)
        with renewing(out):
            result = run.compare(own, starts, seed, out, resume, chosen(pair), console.progress, workers, cluster)
            if out is not None:
                from planter.planting.report import compare as report

                with kept(result.table()):
                    report.write(out, own, result)
        console.result(result, lambda: tables.comparison(console, result))
