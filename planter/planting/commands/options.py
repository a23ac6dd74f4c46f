"""Arguments and options that several commands of the planting device share."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter.errors import Interrupted
from planter.terminal.options import overrides

if TYPE_CHECKING:
    from planter.planting.model import Device


class Model(enum.StrEnum):
    exact = "exact"
    printed = "printed"


MachineArgument = Annotated[
    str, typer.Argument(help="a machine file, or the name of a built-in machine", show_default=False)
]
ModelOption = Annotated[Model, typer.Option(help="first principles, or the paper's equations as printed")]
SamplesOption = Annotated[
    int | None, typer.Option(help="angles of the cycle [default: the machine file's]", show_default=False)
]
SpeedOption = Annotated[float | None, typer.Option(help="change the carrier speed for this call", show_default=False)]


def changes(settings: Sequence[str] | None, speed_rpm: float | None) -> Mapping[str, float]:
    """Values to change, from `--set name=value` and `--speed-rpm`."""
    speed = {} if speed_rpm is None else {"operation.speed_rpm": speed_rpm}
    return overrides(settings) | speed


def device_of(source: str, model: str, settings: Sequence[str] | None, speed_rpm: float | None) -> Device:
    from planter.planting import file
    from planter.planting.model import Device

    return Device(file.load(source, changes(settings, speed_rpm)), "exact" if model == "exact" else "printed")


@contextmanager
def kept(result: dict[str, Any]) -> Iterator[None]:
    """Within, an interrupt hands over the result that is there already."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(result) from None
