"""What a machine's room brings so that its gears can be cut: a module `toothed` with the functions of `Room`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, cast

from planter import rooms
from planter.errors import InputError
from planter.files import examples, text
from planter.gears.asked import Teeth
from planter.gears.options import Keep
from planter.gears.parts import Parts
from planter.gears.results import GearsFound
from planter.progress import Listener


@dataclass(frozen=True)
class Wanted:
    """What is wanted of a machine's gears, as the options of the command say it, in their units.

    `given` are the parts of `teeth` that are not as usual but as told: a machine's file may say what the others are.
    `modules_mm` are those of stages 1 and 2, `counts` the numbers of teeth, `changes` those of the machine's file by
    name. What a machine has no use for its room refuses.
    """

    teeth: Teeth
    made: Parts
    given: frozenset[str] = frozenset()
    modules_mm: tuple[float | None, float | None] = (None, None)
    counts: tuple[int, ...] = ()
    keep: Keep | None = None
    changes: Mapping[str, float] = field(default_factory=dict)
    speed_rpm: float | None = None


class Room(Protocol):
    """Machines of a kind."""

    def takes(self, source: str) -> bool:
        """Whether a file, or a built-in name, is a machine of this kind, as far as its tables tell."""

    def make(
        self, source: str, wanted: Wanted, out: Path | None = None, progress: Listener | None = None
    ) -> GearsFound:
        """The gears of the machine in it; files where a folder is given.

        Raises InputError for a bad file, or for what cannot be wanted of it; GeometryError for gears that cannot be.
        """


def room_of(source: str) -> Room:
    """The room of the machine in a file or of a built-in name. Raises InputError where no room takes it."""
    found = [cast(Room, module) for module in rooms.brought("toothed")]
    for room in found:
        if room.takes(source):
            return room
    text.parse_toml(examples.text(source), source)
    known = [name for name in examples.names(suffix=".toml") if any(room.takes(name) for room in found)]
    raise InputError(f"{source}: no gears are cut of such a machine: it must be one like {', '.join(known)}")
