"""The drawings of planting devices with their symbols: `LABELS`, as `planter.view.sheet` has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from planter.planting.swept import ROOM

if TYPE_CHECKING:
    from planter.view.sheet import Labelled


class Labels:
    """Planting devices."""

    undrawn: Mapping[str, Sequence[str]] = {
        "an angle of forces at a contact, not of the machine's shape": ("alpha_n", "mu1", "mu2"),
        "the cam's own shape: planter cam draws it": (
            "derived: end-face cam", "derived: cam for a roller", "pressure", "reach", "station",
        ),
        "any point of a pitch curve: planter gears draws all of them": (
            "on_curve", "on_radius", "on_turned", "x_inner", "y_inner", "x_outer", "y_outer",
        ),
        "from nozzle to plant over ground: planter simulate draws it beside the path": ("derived: nozzle",),
        "a parameter of a pitch curve before it is deformed; the curve itself is drawn": ("*3_mm", "*6_mm"),
        "of side 2, half a turn behind side 1": ("*_2_deg", "*_2_mm"),
        "what the design is asked for, not a part of it": ("requirements.", "gears."),
        "what is assumed in place of the file's own, when it is lifted": ("derived: assumption lifted",),
    }  # fmt: skip

    def takes(self, source: str) -> bool:
        """A built-in name, or a file with the tables of such a machine."""
        return ROOM.takes(source)

    def draw(self, source: str, changes: Mapping[str, float]) -> Labelled:
        """The machine in a file, or the built-in one of that name, in the design that it has."""
        from planter.planting.file import load
        from planter.planting.model import Device
        from planter.planting.report.sheets import sheets
        from planter.view.sheet import Labelled

        machine = load(source, changes)
        return Labelled(machine.name, machine.numbers(), sheets(Device(machine, "exact")))


LABELS = Labels()
