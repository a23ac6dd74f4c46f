"""Arguments and options that several commands of the planting device share."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter.errors import Interrupted
from planter.terminal.options import changes

if TYPE_CHECKING:
    from planter.planting.file import Machine
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


def machine_of(source: str, set_: Sequence[str] | None, speed_rpm: float | None) -> Machine:
    """A machine with the numbers that `--set` and `--speed-rpm` change."""
    from planter.planting import file

    return file.load(source, changes(set_, {"operation.speed_rpm": speed_rpm}))


def device_of(source: str, model: str, set_: Sequence[str] | None, speed_rpm: float | None) -> Device:
    from planter.planting.model import Device

    return Device(machine_of(source, set_, speed_rpm), "exact" if model == "exact" else "printed")


@contextmanager
def kept(result: dict[str, Any]) -> Iterator[None]:
    """Within, an interrupt hands over the result that is there already."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(result) from None
