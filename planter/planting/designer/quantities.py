"""The functions of the carrier angle that a designer looks at, with exact derivatives, as one kernel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from planter.gearing.stage import Stage
from planter.kernels import Array, Kernel, formulas
from planter.planting.functions import Prologue
from planter.planting.model import Device

STRENGTH = formulas.load("gear_strength")
CAM = formulas.load("planting_cam")
CONTACTS = ("F_NP", "F_NQ", "F_E")
"""Forces that can only push: normal forces of the teeth at P and Q, of the cam on the roller."""
VECTORS = {
    "tooth_P": ("F_Px", "F_Py"),
    "tooth_Q": ("F_Qx", "F_Qy"),
    "bearing_A1": ("F_A1x", "F_A1y"),
    "bearing_B1": ("F_B1x", "F_B1y"),
    "hinge_inner": ("F_Ax", "F_Ay", "F_Az"),
    "hinge_outer": ("F_Aox", "F_Aoy", "F_Aoz"),
    "bearing_O1": ("F_O1x", "F_O1y"),
    "mount_O": ("F_Ox", "F_Oy"),
    "frame": ("F_support_x", "F_support"),
}
"""Forces by their components; those that a model does not report are left out."""
TORQUES = ("M_L", "M_1")
TURNED = ("phi52", "phi72", "theta1")
"""Angles of bodies; their second derivatives are accelerations, since the carrier's speed is constant."""
CENTRE = ("x_tip", "y_tip")
OF_GEARS = {"module": "module_mm", "b": "face_width_mm", "E": "youngs_modulus_GPa", "nu": "poisson_ratio"}
"""Names of the strength formulas, and where their values stand in [gears]."""
GEARS = (("sun", "gear 5"), ("gear 6", "planet gear"))


@dataclass(frozen=True)
class Row:
    """A function of the carrier angle: what it is, its SI unit, and whether its extremes or its jumps count."""

    expression: ca.SX
    meaning: str
    unit: str
    peaks: bool = True
    jumps: bool = False


class Quantities:
    """Rows of a device by name: signed forces and torques, squares of sizes, angles, stress where [gears] give it."""

    def __init__(self, device: Device) -> None:
        self.device, self.functions = device, device.functions
        one, _, totals = self.functions.both
        vectors = device.sidecar["vectors"]
        self._entries = {e["name"]: e for name in ("side", "totals") for e in vectors[name]}
        self._values = dict(zip((e["name"] for e in vectors["side"]), ca.vertsplit(one), strict=True))
        self._values |= dict(zip((e["name"] for e in vectors["totals"]), ca.vertsplit(totals), strict=True))
        self._c = dict(zip((e["name"] for e in vectors["machine"]), ca.vertsplit(self.functions.c), strict=True))
        self.rows = {**self._forces(), **self._accelerations(), **self._meshing(), "cam": self._cam()}
        self.names = tuple(self.rows)
        self.peaks = tuple(name for name, row in self.rows.items() if row.peaks)

    def values(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """Rows (k, n) with their first derivatives in phi at carrier angles (n,) [SI]."""
        found = self._values_kernel(**self._inputs(at, phi))
        return found["f"], found["df"]

    def rates(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """First and second derivatives in phi of the rows `peaks` at carrier angles (n,) [SI]."""
        found = self._rates_kernel(**self._inputs(at, phi))
        return found["df"], found["ddf"]

    def _inputs(self, at: Prologue, phi: Array) -> dict[str, Array]:
        return {"phi": np.asarray(phi), "x": at.x, "c": self.device.constants, "h": at.h}

    @cached_property
    def _values_kernel(self) -> Kernel:
        rows = ca.vertcat(*(row.expression for row in self.rows.values()))
        return self._kernel("designer", {"f": rows, "df": ca.jacobian(rows, self.functions.phi)})

    @cached_property
    def _rates_kernel(self) -> Kernel:
        first = ca.jacobian(ca.vertcat(*(self.rows[name].expression for name in self.peaks)), self.functions.phi)
        return self._kernel("designer_rates", {"df": first, "ddf": ca.jacobian(first, self.functions.phi)})

    def _kernel(self, name: str, outputs: Mapping[str, ca.SX]) -> Kernel:
        values = [ca.densify(value) for value in outputs.values()]
        f = ca.Function(name, self.functions.inputs, values, ["phi", "x", "c", "h"], list(outputs))
        return Kernel(f, lanes=["phi"])

    def _row(self, name: str) -> Row:
        entry = self._entries[name]
        return Row(self._values[name], entry["meaning"], entry["unit"], name in (*TORQUES, *CONTACTS), jumps=True)

    def _forces(self) -> dict[str, Row]:
        found = {name: self._row(name) for name in (*TORQUES, *CONTACTS)}
        for name, parts in VECTORS.items():
            if all(part in self._values for part in parts):
                own = {part: self._row(part) for part in parts}
                square = ca.sumsqr(ca.vertcat(*(row.expression for row in own.values())))
                first = own[parts[0]].meaning
                meaning = first.rpartition(", ")[0] or first.partition(" ")[2]
                found |= own | {name: Row(square, meaning, "N2")}
        return found

    def _accelerations(self) -> dict[str, Row]:
        phi, omega = self.functions.phi, self._c["omega"]
        found = {}
        for name in (*TURNED, *CENTRE):
            own = self._row(name)
            rate = ca.gradient(ca.gradient(own.expression, phi), phi) * omega**2
            found[f"{name}_ddot"] = replace(
                own, expression=rate, meaning=f"acceleration of the {own.meaning}", unit=f"{own.unit}/s2"
            )
        return found

    def _meshing(self) -> dict[str, Row]:
        found: dict[str, Row] = {}
        for index, (stage, t, force) in enumerate(zip(self.device.stages, ("t1", "t2"), CONTACTS, strict=False)):
            parameters, hoisted = self._of_stage(index)
            contact = dict(zip(stage.contact.function.name_out(),
                               stage.contact.function(self._values[t], parameters, hoisted), strict=True))  # fmt: skip
            known: dict[str, ca.SX] = {"r": contact["r"], "dr": contact["dr"], "alpha0": self._c["alpha_n"]}
            for name, value in STRENGTH.composed("pressure_angles", known).items():
                found[f"{name}{index + 1}"] = Row(value, "pressure angle", "rad")
            gears = self.device.machine.gears
            if gears is not None and gears.give_stress:
                bends = _curvatures(stage, self._values[t], parameters, hoisted)
                found |= self._stresses(index, known | {"F": self._values[force]}, bends)
        return found

    def _stresses(self, index: int, known: Mapping[str, ca.SX], bends: tuple[ca.SX, ca.SX]) -> dict[str, Row]:
        own = {**known, **{name: self.device.machine.si(f"gears.{key}") for name, key in OF_GEARS.items()}}
        contact = STRENGTH.composed("contact_stress", own | {"kappa1": bends[0], "kappa2": bends[1]})
        found = {f"contact{index + 1}": Row(contact["square"], "square of the contact stress", "N2/m4")}
        for gear, bend in zip(GEARS[index], bends, strict=True):
            stress = STRENGTH.composed("bending_stress", own | {"kappa1": bend})["sigma"]
            found[f"bending, {gear}"] = Row(stress, "bending stress", "N/m2")
        return found

    def _of_stage(self, index: int) -> tuple[ca.SX, ca.SX]:
        inputs = self.functions.lane_inputs(self.functions.phi)
        return inputs[2 + 2 * index], inputs[3 + 2 * index]

    def _cam(self) -> Row:
        rate = ca.gradient(self._values["theta1"], self.functions.phi) * self._c["omega"]
        known = {**self._c, "theta1": self._values["theta1"], "theta1_dot": rate, "Omega": self._values["Omega"]}
        return Row(CAM.composed("cam", known)["pressure"], "pressure angle of the cam", "rad")


def _curvatures(stage: Stage, t: ca.SX, parameters: ca.SX, hoisted: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Curvatures [1/m] of both pitch curves at a polar angle of the inner gear, on whichever segment it is.

    Polar angles are linear in the place u on a segment, so that two of them tell the place.
    """
    polar, bends = stage.polar.function, stage.curvature.function
    within = t - 2 * np.pi * ca.floor(t / (2 * np.pi))
    ends = zip(polar(0.0, parameters), polar(1.0, parameters), strict=True)
    first, second = ((within - start) / (unit - start) for start, unit in ends)
    one, two = bends(first, parameters, hoisted)[:2], bends(second, parameters, hoisted)[2:]
    inner, outer = (ca.if_else(first <= np.pi, a, b) for a, b in zip(one, two, strict=True))
    return inner, outer
