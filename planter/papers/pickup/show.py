"""Pick-ups to be shown and changed by hand (`planter.report.subject`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from planter.report.labels import load_names
from planter.report.subject import (
    Control,
    DetailTable,
    Export,
    Reading,
    RequirementCheck,
    Sought,
    Values,
    list_controls,
    list_readings,
    to_sentence_case,
    write_numbers,
)

if TYPE_CHECKING:
    from planter.papers.pickup.file import Pickup
    from planter.papers.pickup.model import PickupTrain
    from planter.report.scene import Scene

OFFERED = ("bars", "law", "carrier", "noncircular_stage", "tray", "needle")
"""Tables of the file whose numbers a hand is offered."""
TEETH_ALONE = ("noncircular_stage.ha1", "noncircular_stage.alpha0_deg")
"""Numbers that only the exported gears depend on: nothing that is shown follows them."""
POINTS = "path.points_mm"
REACH_MM = 40.0
"""How far a point of the path can be drawn to either side."""
EXPORTS = (
    Export("report", "page, figures and tables: gears, path, requirements", ("design", "pickup")),
    Export(
        "gears",
        "teeth and locking arcs (DXF, SVG, flanks as CSV), their mesh solved and checked",
        ("gears",),
    ),
)


class PickUp:
    """A pick-up, by its law or by its path: its gears follow a dragged path at once."""

    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, source: str, changes: Values) -> None:
        from planter.papers.pickup.file import load_pickup

        self.source, self.changes = source, dict(changes)
        self.machine: Pickup = load_pickup(source, changes)
        self.name = self.machine.name
        self._latest: tuple[dict[str, float], Pickup, PickupTrain] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Numbers of bars, law, carrier, gears, tray and needle, then the points of its path."""
        numbers = self.machine.numbers()
        points = {
            path: (numbers[path] - REACH_MM, numbers[path] + REACH_MM)
            for path in numbers
            if path.startswith(POINTS)
        }
        paths = [
            path
            for path in numbers
            if path.partition(".")[0] in OFFERED and path not in TEETH_ALONE
        ]
        return list_controls(self.machine, [*paths, *points], {}, points, load_names(__package__))

    @cached_property
    def handles(self) -> Sequence[tuple[str, str]]:
        """The points of the path in its file."""
        count = 0 if self.machine.path is None else len(self.machine.path.points_mm or ())
        return [(f"{POINTS}[{k}][0]", f"{POINTS}[{k}][1]") for k in range(count)]

    @property
    def search(self) -> Sequence[str]:
        """Moves the points of the path until the requirements hold; they are as many as the search
        has.
        """
        return (
            ("design", "pickup", "--optimise")
            if len(self.handles) == self.machine.spline.value_points
            else ()
        )

    starts = 1

    def describe_goal(self) -> str:
        """Return what the search minimises."""
        return (
            "mean square of the tip's displacement, in units of 30 mm, and of the change of the "
            "gear ratio's second derivative, while the requirements hold"
        )

    @property
    def words(self) -> Mapping[str, str]:
        """No keys: messages have the names of the page."""
        return {}

    def sought(self, answer: Mapping[str, Any]) -> Sought:
        """The points that were found."""
        optimised = answer["optimised"]
        values = {
            path: value
            for pair, point in zip(self.handles, optimised["value_points_mm"], strict=True)
            for path, value in zip(pair, point, strict=True)
        }
        outcome = "All requirements hold" if optimised["holds"] else "Not all requirements can hold"
        return Sought(
            values, f"{outcome}, with points moved by at most {optimised['moved_mm']:.4g} mm."
        )

    @property
    def wishes(self) -> bool:
        """Whether its path stands not in its file in as many points as the search has."""
        return not self.search

    def wished(self, values: Values) -> str:
        """Its file with a path instead of a law: as many points of its path as the search has."""
        import numpy as np

        from planter.numerics.arrays import TURN

        machine, train = self._train(values)
        count = machine.spline.value_points
        return write_numbers(
            self.machine, machine.on_path(train.tip(np.arange(count) * TURN / count))
        )

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """A turn of the carrier."""
        from planter.papers.pickup.scene import build_pickup_scene

        return [build_pickup_scene(*self._train(values))]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Bars and distances, which a path gives."""
        at = self._train(values)[1].geometry
        lengths = {
            "sun's centre to planet's axis": at.L1,
            "planet's axis to tip": at.L2,
            "centre distance of the non-circular pair": at.a1,
        }
        return [Reading(name, "mm", 1e3 * value) for name, value in lengths.items()]

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return the requirements of the path at the tray."""
        from planter.papers.pickup.requirements import list_requirements

        return [
            RequirementCheck(
                r.name,
                r.unit,
                r.value,
                r.margin,
                r.holds,
                r.lower,
                r.upper,
                to_sentence_case(r.name),
            )
            for r in list_requirements(*self._train(values))
        ]

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """Single numbers of what `planter design pickup` tells."""
        from planter.papers.pickup.analysis import build_result

        rows = [
            (row.name, row.value, row.unit)
            for row in list_readings(build_result(*self._train(values), ()).table())
        ]
        return [DetailTable("Gears and motion", ("quantity", "value", "unit"), rows)]

    def text(self, values: Values) -> str:
        """The file with these numbers."""
        return write_numbers(self.machine, self._train(values)[0])

    def _train(self, values: Values) -> tuple[Pickup, PickupTrain]:
        from planter.papers.pickup.file import load_pickup
        from planter.papers.pickup.model import build_train

        if self._latest is None or self._latest[0] != dict(values):
            numbers = self.machine.numbers()
            moved = {path: value for path, value in values.items() if numbers[path] != value}
            machine = load_pickup(self.source, self.changes | moved)
            self._latest = dict(values), machine, build_train(machine)
        return self._latest[1:]


def open_view(source: str, changes: Values) -> PickUp:
    """Return the pick-up in a file, or the built-in one of that name."""
    return PickUp(source, changes)
