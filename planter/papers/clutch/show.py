"""Adapter of clutches for the studio (`planter.report.subject`)."""

from __future__ import annotations

import math
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
    list_readings,
    to_sentence_case,
    write_numbers,
)

if TYPE_CHECKING:
    from planter.papers.clutch.file import ClutchFile
    from planter.papers.clutch.results import ClutchGeometry
    from planter.report.scene import Scene

OFFERED = ("sleeve", "shaft", "tooth", "linkage")
"""Tables of the file whose numbers have a control."""
EXPORTS = (
    Export("report", "page, figures and tables of the shape", ("design", "clutch", "geometry")),
    Export(
        "engagement", "page, figures and tables of an engagement", ("design", "clutch", "engage")
    ),
    Export(
        "optimum",
        "angle, ratio and linkage of the smallest travel time",
        ("design", "clutch", "optimise"),
    ),
)


class ReuleauxClutch:
    """A clutch by its shape."""

    handles: Sequence[tuple[str, str]] = ()
    models: Sequence[str] = ("exact",)
    exports: Sequence[Export] = EXPORTS

    def __init__(self, clutch: ClutchFile) -> None:
        self.clutch, self.name = clutch, clutch.name
        self._latest: tuple[float, Scene] | None = None

    @cached_property
    def controls(self) -> Sequence[Control]:
        """Numbers of sleeve, shaft, teeth and linkage."""
        paths = [path for path in self.clutch.numbers() if path.partition(".")[0] in OFFERED]
        return list_controls(self.clutch, paths, {}, {}, load_names(__package__))

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """The body as it turns in the smallest sleeve that lets it, which only its width
        changes.
        """
        from planter.papers.clutch.model import SIDES, VERTICES
        from planter.papers.clutch.rotor import Rotor
        from planter.papers.clutch.scene import build_rotor_scene

        width = self._geometry(values).R_mm
        if self._latest is None or self._latest[0] != width:
            self._latest = width, build_rotor_scene(Rotor(VERTICES, SIDES, width * 1e-3), self.name)
        return [self._latest[1]]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Return the single numbers of the shape, teeth and travel, and the loads of an engagement
        in one mode.
        """
        from planter.papers.clutch.modal_engagement import build_engagement, find_extremes
        from planter.papers.clutch.model import (
            collect_values,
            compute_geometry,
            control_motion,
            least_travel,
        )

        clutch = self._clutch(values)
        numbers, shape, loads = (
            collect_values(clutch),
            compute_geometry(clutch),
            find_extremes(build_engagement(clutch.si)),
        )
        control = control_motion(clutch, numbers) or {}
        angles = {
            key: math.degrees(control[key]) if control else None
            for key in ("rotation", "lift", "alpha_max")
        }
        return [
            *list_readings(shape.table()),
            Reading("least radius of the tips", "mm", shape.tooth.b1_min_mm),
            Reading("least radius of the roots", "mm", shape.tooth.b2_min_mm),
            Reading("angle of the faces at the tips", "deg", shape.tooth.xi_deg),
            Reading(
                "least travel of the sleeve",
                "mm",
                1e3 * least_travel(numbers, clutch.si("sleeve.axial_angle_deg")),
            ),
            Reading(
                "time of the sleeve's travel",
                "s",
                clutch.sleeve.travel_mm / clutch.sleeve.switching_speed_mm_s,
            ),
            Reading("rotation of the crank", "deg", angles["rotation"]),
            Reading("teeth that the crank gear turns through", "", control.get("n")),
            Reading("lift of the link", "deg", angles["lift"]),
            Reading("inclination of the link after the travel", "deg", angles["alpha_max"]),
            Reading("load as the teeth meet, in one mode", "N", loads["N_0"]),
            Reading("largest load of an engagement, in one mode", "N", loads["N_max"]),
            Reading("time of the largest load", "ms", loads["t_max"] * 1e3),
        ]

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """Return the inequalities of a clutch that works."""
        rows = self._geometry(values).conditions
        return [
            RequirementCheck(
                row.condition,
                row.unit.removeprefix("1"),
                None,
                row.margin,
                row.holds,
                label=to_sentence_case(row.condition),
            )
            for row in rows
        ]

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """Return the rotation of the crank at the angles and with the rods of the field test."""
        head = (
            "axial angle / deg",
            "rod / mm",
            "crank rotation / deg",
            "lift of the link / deg",
            "teeth",
        )
        rows = [
            (
                f"{row.axial_angle_deg:g}",
                row.rod_mm,
                row.crank_rotation_deg,
                row.link_lift_deg,
                row.teeth,
            )
            for row in self._geometry(values).linkage
        ]
        return [DetailTable("Linkage, for the printed travel", head, rows)]

    def text(self, values: Values) -> str:
        """The file with these numbers."""
        return write_numbers(self.clutch, self._clutch(values))

    def _clutch(self, values: Values) -> ClutchFile:
        clutch: ClutchFile = change_numbers(self.clutch, values)
        return clutch

    def _geometry(self, values: Values) -> ClutchGeometry:
        from planter.papers.clutch.model import compute_geometry

        return compute_geometry(self._clutch(values))


def open_view(source: str, changes: Values) -> ReuleauxClutch:
    """Return the clutch in a file, or the built-in one of that name."""
    from planter.papers.clutch.file import load_clutch

    return ReuleauxClutch(load_clutch(source, changes))
