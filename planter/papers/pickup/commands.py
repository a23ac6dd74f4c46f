"""The command of the seedling pick-up."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.report.completion import complete_sources
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    OutOption,
    SetOption,
    parse_changes,
    text_option,
    writes_files,
)

app = typer.Typer()


@app.command(name="pickup")
@writes_files("summary.json", "cycle.csv", "pitch.csv", "path.csv", "report.html")
def analyse_pickup(
    config: Annotated[
        str,
        typer.Argument(
            metavar="PICKUP",
            help="a pick-up's file (TOML), a CSV of points of its path (x_mm,y_mm), or the name "
            "of a built-in one",
            autocompletion=complete_sources("pickup"),
        ),
    ],
    at: Annotated[
        list[float] | None,
        text_option(
            "also report at this carrier angle, counted from the farthest tip (repeatable)", "DEG"
        ),
    ] = None,
    optimise: Annotated[
        bool, typer.Option("--optimise", help="move the value points until the requirements hold")
    ] = False,
    set_: SetOption = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Find the gears of a seedling pick-up from its needle path.

    A law of motion may be given instead of a path. A path is closed, in mm from the sun's centre,
    which it leaves outside, in the order of a carrier that turns counter-clockwise; given alone it
    takes all else from yu2023. What cannot be gears is refused with the carrier angle and the place
    on the path. `ends = "smooth"` in [law] prevents jumps of the tip's velocity at the dwell.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.papers.pickup import analysis
        from planter.papers.pickup.presentation import present_pickup

        outcome = analysis.analyse_pickup(
            config, at or (), optimise, parse_changes(set_), console.progress
        )
        present_pickup(outcome).show(console, out)
