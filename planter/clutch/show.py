"""Clutches to be shown and changed by hand: `KIND`, as `planter.view.subject` has it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from planter.files import examples
from planter.view.exports import Export
from planter.view.subject import Check, Control, Reading, Table, Values, changed, controls, singles, written

if TYPE_CHECKING:
    from planter.clutch.file import Clutch
    from planter.clutch.results.shape import Geometry
    from planter.view.scene import Scene

OFFERED = ("sleeve", "shaft", "tooth", "linkage")
"""Tables of the file whose numbers a hand is offered."""
EXPORTS = (
    Export("report", "page, figures and tables of the shape", ("clutch", "geometry")),
    Export("engagement", "page, figures and tables of an engagement", ("clutch", "engage")),
    Export("optimum", "angle, ratio and linkage of the smallest travel time", ("clutch", "optimise")),
)


class ReuleauxClutch:
    """A clutch by its shape."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, clutch: Clutch) -> None:
        self.clutch, self.name = clutch, clutch.name

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Numbers of sleeve, shaft, teeth and linkage."""
        paths = [path for path in self.clutch.numbers() if path.partition(".")[0] in OFFERED]
        return controls(self.clutch, paths, {}, {})

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """The body as it turns in the smallest sleeve that lets it."""
        from planter.clutch.geometry import SIDES, VERTICES
        from planter.clutch.report.scene import scene
        from planter.clutch.rotor import Rotor

        return [scene(Rotor(VERTICES, SIDES, self._geometry(values).R_mm * 1e-3), self.name)]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Single numbers of what `planter clutch geometry` tells."""
        return singles(self._geometry(values).table())

    def checks(self, values: Values, model: str) -> Sequence[Check]:
        """None that have a margin."""
        return []

    def details(self, values: Values, model: str) -> Sequence[Table]:
        """None: its report has more."""
        return []

    def text(self, values: Values) -> str:
        """The file with these numbers."""
        return written(self.clutch, changed(self.clutch, values))

    def _geometry(self, values: Values) -> Geometry:
        from planter.clutch.geometry import geometry

        return geometry(changed(self.clutch, values))


class Kind:
    """Clutches."""

    def takes(self, source: str) -> bool:
        """A built-in name, or a file with the tables of a clutch."""
        return examples.belongs(source, "clutch", {"sleeve", "shaft", "tooth"})

    def open(self, source: str, changes: Values) -> ReuleauxClutch:
        """The clutch in a file, or the built-in one of that name."""
        from planter.clutch.file import load

        return ReuleauxClutch(load(source, changes))


KIND = Kind()
