"""`planter animate`: the motion of a machine as an animated GIF or as a video."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    MachineArgument,
    SetOption,
    parse_changes,
    writes_files,
)

app = typer.Typer()


@app.command()
@writes_files()
def animate(
    machine: MachineArgument,
    out: Annotated[
        Path,
        typer.Option(
            help="file to write: .gif, or .mp4 and .webm if ffmpeg is installed [default: "
            "NAME.gif here]",
            show_default=False,
        ),
    ] = Path(),
    model: Annotated[str | None, typer.Option(help="model, where a machine has several")] = None,
    seconds: Annotated[
        float | None, typer.Option(min=0.1, max=60, help="length of a cycle [default: its own]")
    ] = None,
    width: Annotated[
        int | None, typer.Option(min=100, max=3840, help="width [pixel] [default: 432]")
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(min=1, max=100, help="frames per second [default: 20, fewer for a long GIF]"),
    ] = None,
    set_: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a machine's motion as an animated GIF or a video.

    For example: planter animate wang2017 --seconds 3
    """
    console = Console(as_json)
    with console.outcome():
        from planter.report import animation

        options = animation.AnimationOptions(seconds, width or animation.WIDTH_PX, rate)
        result = animation.animate(machine, parse_changes(set_), out, model, options)
        console.result(result, lambda: print(result.describe()))
