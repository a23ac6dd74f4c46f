"""Poses with their linkages, for display and interactive change (`planter.report.subject`)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from planter.report.labels import load_names
from planter.report.subject import (
    Control,
    DetailTable,
    Export,
    Reading,
    RequirementCheck,
    Values,
    change_numbers,
    list_controls,
    write_numbers,
)

if TYPE_CHECKING:
    from planter.papers.mapping.file import PoseFile
    from planter.papers.mapping.synthesis import Synthesis
    from planter.report.scene import Scene

REACH_MM, REACH_DEG = 60.0, 40.0
"""How far a pose can be moved and turned to either side."""
EXPORTS = (
    Export(
        "linkages",
        "dyads, linkages and the arm's angle: page, figures, tables",
        ("design", "synthesise"),
    ),
)


class Poses:
    """Poses that linkages are to visit."""

    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, file: PoseFile) -> None:
        self.file, self.name = file, file.name
        self._latest: tuple[dict[str, float], Synthesis] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """The numbers of all poses."""
        numbers = {
            path: value for path, value in self.file.numbers().items() if path.startswith("pose")
        }
        reach = {path: REACH_DEG if path.endswith("_deg") else REACH_MM for path in numbers}
        bounds = {
            path: (value - reach[path], value + reach[path]) for path, value in numbers.items()
        }
        return list_controls(self.file, numbers, {}, bounds, load_names(__package__))

    @cached_property
    def handles(self) -> Sequence[tuple[str, str]]:
        """The tips of all poses."""
        return [(f"pose[{k}].x_mm", f"pose[{k}].y_mm") for k in range(len(self.file.pose))]

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Every linkage on the circuits that meet a pose."""
        from planter.papers.mapping import scene

        synthesis = self._synthesis(values)
        return [
            motion
            for linkage in synthesis.linkages
            for motion in scene.build_linkage_scenes(linkage, synthesis.poses).values()
        ]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return the number of dyads, and the smallest transmission angle of each linkage."""
        result = self._synthesis(values).result
        transmissions = [
            Reading(
                f"transmissions transmission angle of {x.dyads[0]} and {x.dyads[1]}",
                "deg",
                x.transmission_min_deg,
            )
            for x in result.linkages
        ]
        return [Reading("real dyads", "", float(len(result.dyads))), *transmissions]

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return no checks: poses have no margins."""
        return []

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """Return no tables: the report has them."""
        return []

    def text(self, values: Values) -> str:
        """The file with these numbers."""
        return write_numbers(self.file, change_numbers(self.file, values))

    def _synthesis(self, values: Values) -> Synthesis:
        from planter.papers.mapping.synthesis import synthesise

        if self._latest is None or self._latest[0] != dict(values):
            self._latest = dict(values), synthesise(change_numbers(self.file, values))
        return self._latest[1]


def open_view(source: str, changes: Values) -> Poses:
    """Return the poses in a file, or the built-in ones of that name."""
    from planter.papers.mapping.file import load_poses

    return Poses(load_poses(source, changes))
