"""Arguments and options that several commands of the planting device share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planter.errors import InputError, Interrupted
from planter.terminal.options import changes

if TYPE_CHECKING:
    from planter.engine.machine import Machine as EngineMachine
    from planter.planting.file import Machine
    from planter.planting.model import Device
    from planter.planting.whole.wanted import Wanted


DeviceArgument = Annotated[
    str, typer.Argument(help="a machine file, or the name of a built-in machine", show_default=False)
]
SamplesOption = Annotated[
    int | None, typer.Option(help="angles of the cycle [default: the machine file's]", show_default=False)
]

WholeTeethOption = Annotated[
    str | None,
    typer.Option("--teeth", metavar="Z1,Z2", help="teeth of the inner gears of stage 1 and of stage 2, with a module "
                 "[default: the best whole numbers near the free optimum]", show_default=False),
]  # fmt: skip


def machine_of(source: str, set_: Sequence[str] | None, speed_rpm: float | None) -> Machine:
    """A machine with the numbers that `--set` and `--speed-rpm` change.

    Raises InputError as its file does, and for the file of a mechanism of one's own.
    """
    from planter.mechanism import machines
    from planter.planting import file

    if machines.takes(source):
        raise InputError(
            f"{source}: this is the file of a mechanism of your own, but it must be that of a planting device, with "
            "two stages of gears, a cam and nozzles"
        )
    return file.load(source, changes(set_, {"operation.speed_rpm": speed_rpm}))


def device_of(source: str, model: str, set_: Sequence[str] | None, speed_rpm: float | None) -> Device:
    from planter.planting.model import Device

    return Device(machine_of(source, set_, speed_rpm), "exact" if model == "exact" else "printed")


def load_other(source: str, set_: Sequence[str] | None, speed_rpm: float | None) -> EngineMachine | None:
    """Return the machine of a source, None if it is a planting device or nothing known."""
    from planter.engine.machine import load_machine

    return load_machine(source, changes(set_), speed_rpm) if is_other(source) else None


def is_other(source: str) -> bool:
    """Return whether a source is a machine that is no planting device."""
    from planter.engine.machine import find_machine_room
    from planter.planting.machines import takes

    return not takes(source) and find_machine_room(source) is not None


def whole_teeth(
    module: float | None, module1: float | None, module2: float | None, teeth: str | None, besides: Mapping[str, bool]
) -> Wanted | None:
    """The whole teeth that are asked for, if any. Raises InputError where options are given that go without them."""
    from planter.planting.whole.asked import wanted

    found = wanted(module, module1, module2, teeth)
    given = [name for name, used in besides.items() if used]
    if found is not None and given:
        raise InputError(f"{given[0]} is not allowed with --module: it is for designs of any teeth")
    return found


@contextmanager
def kept(result: dict[str, Any]) -> Iterator[None]:
    """Within, an interrupt hands over the result that is there already."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(result) from None
