"""Mechanisms of one's own to be shown and changed by hand: `KIND`, as `planter.view.subject` has it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from planter.mechanism.swept import ROOM
from planter.view.subject import Check, Control, Export, Reading, Table, Values, controls, written

if TYPE_CHECKING:
    from planter.mechanism.cycle import Turn
    from planter.mechanism.file import MechanismFile
    from planter.view.scene import Scene
    from planter.view.subject import Portable

MOST = 12
"""Results of which largest and least values are told."""
EXPORTS = (Export("report", "page, figures and table of a turn", ("turn",)),)


class Mechanism:
    """A mechanism that an angle drives."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, file: MechanismFile) -> None:
        self.file, self.name = file, file.name
        self._latest: tuple[dict[str, float], Turn] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Its values, within their bounds where the file has any."""
        meanings = {entry["shown"]: entry["meaning"] for entry in self.file.entries}
        bounds = {f"values.{key}": pair for key, pair in self.file.bounds.items()}
        return controls(self.file, meanings, meanings, bounds)

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Its bodies over a turn."""
        from planter.mechanism.drawing import Course, scene

        found = self._turn(values)
        return [scene(self.name, Course.from_cycle(found), found.seconds, found.columns, found.places)]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Largest and least values of the first results that change over the turn."""
        found = self._turn(values).result.quantities.items()
        moving = [(key, one) for key, one in found if one.max > one.min][:MOST]
        return [Reading(f"{kind} {key}", one.unit, value) for key, one in moving
                for kind, value in (("largest", one.max), ("least", one.min))]  # fmt: skip

    def checks(self, values: Values, model: str) -> Sequence[Check]:
        """None: limits are told to `planter optimise`."""
        return []

    def details(self, values: Values, model: str) -> Sequence[Table]:
        """None: its report has more."""
        return []

    def text(self, values: Values) -> str:
        """The mechanism's file with these values, which knows where its functions are."""
        moved = self._moved(values)
        return written(self.file, moved.model_copy(update={"folder": str(self.file.place)}))

    def portable(self, model: str) -> Portable:
        """What a page needs to compute the mechanism by itself."""
        from planter.mechanism.drawing import Turning

        return Turning(self.file).portable()

    def handed(self, values: Values) -> str:
        """The file without the place of its functions."""
        return written(self.file, self._moved(values))

    def _moved(self, values: Values) -> MechanismFile:
        return self.file.moved_to({path.removeprefix("values."): value for path, value in values.items()})

    def _turn(self, values: Values) -> Turn:
        from planter.mechanism.cycle import turn
        from planter.mechanism.machines import build_machine
        from planter.mechanism.model import Model

        if self._latest is None or self._latest[0] != dict(values):
            self._latest = dict(values), turn(Model(build_machine(self._moved(values))))
        return self._latest[1]


class Kind:
    """Mechanisms of one's own."""

    def takes(self, source: str) -> bool:
        """A mechanism's file, or its name as `planter turn` takes it."""
        return ROOM.takes(source)

    def open(self, source: str, changes: Values) -> Mechanism:
        """The mechanism in a file."""
        from planter.mechanism.file import load

        return Mechanism(load(source, changes))


KIND = Kind()
