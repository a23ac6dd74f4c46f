"""Pick-ups to be shown and changed by hand: `KIND`, as `planter.view.subject` has it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from planter.files import examples
from planter.view.exports import Export
from planter.view.subject import Check, Control, Reading, Table, Values, controls, singles, written

if TYPE_CHECKING:
    from planter.pickup.command import Outcome
    from planter.pickup.file import Pickup
    from planter.view.scene import Scene

OFFERED = ("bars", "law", "carrier", "noncircular_stage", "tray", "needle")
"""Tables of the file whose numbers a hand is offered."""
EXPORTS = (
    Export("report", "page, figures and tables: gears, path, requirements", ("pickup",)),
    Export("gears", "teeth and locking arcs (DXF, SVG, flanks as CSV), proved to mesh", ("gears",)),
)


class PickUp:
    """A pick-up, by its law or by its path."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, source: str, changes: Values) -> None:
        from planter.pickup.file import load

        self.source, self.changes = source, dict(changes)
        self.machine: Pickup = load(source, changes)
        self.name = self.machine.name
        self._latest: tuple[dict[str, float], Outcome] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Numbers of bars, law, carrier, gears, tray and needle."""
        paths = [path for path in self.machine.numbers() if path.partition(".")[0] in OFFERED]
        return controls(self.machine, paths, {}, {})

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """A turn of the carrier."""
        from planter.pickup.report.scene import scene

        found = self._outcome(values)
        return [scene(found.machine, found.train)]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Single numbers of what `planter pickup` tells."""
        return singles(self._outcome(values).result.table())

    def checks(self, values: Values, model: str) -> Sequence[Check]:
        """What the path must do before the tray."""
        found = self._outcome(values).result.requirements
        return [Check(r.name, r.unit, r.value, r.margin, r.holds) for r in found]

    def details(self, values: Values, model: str) -> Sequence[Table]:
        """None: its report has more."""
        return []

    def text(self, values: Values) -> str:
        """The file with these numbers."""
        return written(self.machine, self._outcome(values).machine)

    def _outcome(self, values: Values) -> Outcome:
        from planter.pickup.command import run

        if self._latest is None or self._latest[0] != dict(values):
            own = self.machine.numbers()
            moved = {path: value for path, value in values.items() if own[path] != value}
            self._latest = dict(values), run(self.source, changes=self.changes | moved)
        return self._latest[1]


class Kind:
    """Pick-ups."""

    def takes(self, source: str) -> bool:
        """A built-in name, or a file with the tables of a pick-up."""
        return examples.belongs(source, "pickup", {"helical_stage", "tray"})

    def open(self, source: str, changes: Values) -> PickUp:
        """The pick-up in a file, or the built-in one of that name."""
        return PickUp(source, changes)


KIND = Kind()
