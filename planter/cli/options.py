"""Options that several commands share, and what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from planter.errors import InputError

JsonOption = Annotated[bool, typer.Option("--json", help="print one JSON object instead of tables")]
OutOption = Annotated[Path | None, typer.Option(help="folder for result files", show_default=False)]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="change a value for this call", show_default=False),
]
SamplesOption = Annotated[
    int | None, typer.Option(help="angles of the cycle [default: the machine file's]", show_default=False)
]
SeedOption = Annotated[int, typer.Option(min=0, help="seed of everything random")]
ClutchArgument = Annotated[
    str, typer.Argument(metavar="CLUTCH", help="a clutch file, or the name of a built-in one", show_default=False)
]
SpeedOption = Annotated[float | None, typer.Option(help="change the carrier speed for this call", show_default=False)]


def overrides(settings: Sequence[str] | None, speed_rpm: float | None = None) -> dict[str, float]:
    """Values to change, from `--set name=value` and `--speed-rpm`."""
    found: dict[str, float] = {}
    for setting in settings or ():
        name, equals, text = setting.partition("=")
        try:
            found[name.strip()] = float(text)
        except ValueError:
            allowed = "it must be NAME=VALUE with a number" if equals else "it must be NAME=VALUE"
            raise InputError(f"--set {setting} is not allowed: {allowed}") from None
    if speed_rpm is not None:
        found["operation.speed_rpm"] = speed_rpm
    return found
