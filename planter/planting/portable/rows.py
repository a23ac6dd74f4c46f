"""What of a planting device is drawn over a turn, and along its pitch curves, as expressions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca

from planter.files import units
from planter.planting import cycle
from planter.planting.model import Device

SIDE = (
    "phi52_deg", "alpha_deg", "theta1_deg", "tip_x_mm", "tip_machine_x_mm", "tip_y_mm", "x_A1_mm", "y_A1_mm", "x_B1_mm",
    "y_B1_mm", "F_A1x_N", "F_A1y_N", "F_B1x_N", "F_B1y_N", "F_E_N",
)  # fmt: skip
"""Quantities of side 1 that are drawn."""
TOTALS = ("support_N", "M_L_Nm")
TOLD = ("support_N", "M_L_Nm", "F_E_N")
"""What of a turn is told, at the samples of the file."""
AXES = 4
"""x and y of the inner gear of a stage, then those of the outer."""
Known = Mapping[str, ca.SX]


class Rows:
    """Expressions in the carrier angle, the design, the machine's data, and what a prologue finds: `inputs`."""

    def __init__(self, device: Device) -> None:
        self.device, self.inputs = device, device.functions.inputs

    @cached_property
    def drawn(self) -> Known:
        """What is drawn of a turn, in shown units."""
        known, phi = self._quantities, self.inputs[0]
        turned = phi / units.factor("phi_deg")
        return {
            "phi_deg": turned,
            "planet's turn on the carrier": -known["alpha_deg"] - turned,
            "travel": 1e3 * self._datum("forward_speed_m_s") * phi / ca.fabs(self._datum("speed_rpm")),
            **{key: known[key] for key in (*SIDE, *TOTALS)},
        }

    @property
    def told(self) -> Sequence[ca.SX]:
        """What of a turn the readings take, in shown units."""
        return [self._quantities[key] for key in TOLD]

    def outlines(self, stage: int) -> Sequence[ca.SX]:
        """Points of the inner and the outer gear of a stage, 0 or 1 [mm], in their bodies, from their own axes.

        They are those whose polar angle on the inner gear is the first contact's and as much more as the carrier angle.
        """
        start = self._at_start
        t, contact = start[f"t{stage + 1}"] + self.inputs[0], f"T{stage + 1}"
        at, first = self._contact(stage, t), self._contact(stage, start[f"t{stage + 1}"])
        formulas = self.device.formulas
        point = dict(zip(formulas.entries("point"), (t, at["r"], at["turned"]), strict=True))
        known = start | self._mounting | {"phi": ca.SX(0), contact: first["turned"]} | point
        found = formulas.composed(f"pair{stage + 1}", known)
        axes = ((0.0, 0.0), (start["x_A1"], start["y_A1"]), (start["x_B1"], start["y_B1"]))
        (x, y), (u, v) = (
            (found[f"x_{gear}"] - axis[0], found[f"y_{gear}"] - axis[1])
            for gear, axis in zip(("inner", "outer"), axes[stage:], strict=False)
        )
        return [1e3 * value for value in (x, y, *(_turned(u, v, start["alpha"]) if stage else (u, v)))]

    @cached_property
    def _quantities(self) -> Known:
        """Quantities of side 1 and of both in shown units by their keys."""
        vectors = self.device.sidecar["vectors"]
        one, _, totals = self.device.functions.both
        found: dict[str, ca.SX] = {}
        for vector, values in (("side", one), ("totals", totals)):
            keys = cycle.list_keys(vectors[vector])
            found |= {key: v / units.factor(key) for key, v in zip(keys, ca.vertsplit(values), strict=True)}
        return found

    @cached_property
    def _at_start(self) -> dict[str, ca.SX]:
        """Quantities of side 1 where the carrier angle is zero, by their names [SI]."""
        side = self.device.functions.side(ca.SX(0))
        return dict(zip(self.device.formulas.entries("side"), ca.vertsplit(side), strict=True))

    @cached_property
    def _mounting(self) -> dict[str, ca.SX]:
        """How the gears are mounted: the design's first entries, and the centre distances [SI]."""
        _, x, _, h = self.inputs
        own = dict(zip(self.device.formulas.entries("mounting"), ca.vertsplit(x), strict=False))
        return own | {f"a{k}": h[place] for k, place in enumerate(cycle.find_distance_indices(self.device), 1)}

    def _contact(self, stage: int, t: ca.SX) -> dict[str, ca.SX]:
        """Contact of a stage at a polar angle of its inner gear."""
        contact = self.device.stages[stage].contact.function
        parameters, hoisted = self.device.functions.lane_inputs(self.inputs[0])[2 + 2 * stage : 4 + 2 * stage]
        return dict(zip(contact.name_out(), contact.call([t, parameters, hoisted]), strict=True))

    def _datum(self, key: str) -> ca.SX:
        return self.inputs[2][place(self.device, f"operation.{key}")]


def place(device: Device, path: str) -> int:
    """Where a number of the file stands in the machine's data."""
    return [entry["shown"] for entry in device.sidecar["vectors"]["machine"]].index(path)


def _turned(x: ca.SX, y: ca.SX, by: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A point turned by an angle."""
    c, s = ca.cos(by), ca.sin(by)
    return c * x - s * y, s * x + c * y
