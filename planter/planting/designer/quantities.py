"""The functions of the carrier angle that a designer of a planting device looks at, as rows of the engine's summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.summary import Row, build_vector_row
from planter.gear_geometry.stage import Stage
from planter.kernels import formulas
from planter.planting.model import Device

STRENGTH = formulas.load("gear_strength")
CAM = formulas.load("planting_cam")
CONTACTS = ("F_NP", "F_NQ", "F_E")
"""Forces that can only push: normal forces of the teeth at P and Q, of the cam on the roller."""
TORQUES = ("M_L", "M_1")
TURNED = ("phi52", "phi72", "theta1")
"""Angles of bodies; their second derivatives are accelerations, since the carrier's speed is constant."""
CENTRE = ("x_tip", "y_tip")
OF_GEARS = {"module": "module_mm", "b": "face_width_mm", "E": "youngs_modulus_GPa", "nu": "poisson_ratio"}
"""Names of the strength formulas, and where their values stand in [gears]."""
GEARS = (("sun", "gear 5"), ("gear 6", "planet gear"))


class DeviceRows:
    """Rows of a device: signed forces and torques, sizes, accelerations, pressure angles, stress if [gears] has it."""

    def __init__(self, device: Device, machine: Machine) -> None:
        self.device, self.machine = device, machine
        self.phi, self._d, self._h, _ = machine.symbols
        self._constants = {
            value.name: self._d[device.size + i] for i, value in enumerate(machine.values[device.size :])
        }

    def build(self) -> list[Row]:
        """Return all rows."""
        return [*self._forces(), *self._accelerations(), *self._meshing(), self._cam()]

    def _forces(self) -> Iterator[Row]:
        for name in (*TORQUES, *CONTACTS):
            yield Row(self.machine.find_quantity(name), self.machine.graph(name))
        for vector in self.machine.vectors:
            for part in vector.components:
                yield Row(self.machine.find_quantity(part), self.machine.graph(part), has_peaks=False)
            yield build_vector_row(self.machine, vector)

    def _accelerations(self) -> Iterator[Row]:
        for name in (*TURNED, *CENTRE):
            quantity = self.machine.find_quantity(name)
            rate = ca.gradient(ca.gradient(self.machine.graph(name), self.phi), self.phi)
            meaning, unit = f"acceleration of the {quantity.meaning}", f"{quantity.unit}/s2"
            acceleration = Quantity(f"{name}_ddot", unit, meaning, "")
            yield Row(acceleration, rate * self._constants["omega"] ** 2, has_peaks=False)

    def _meshing(self) -> Iterator[Row]:
        for index, (stage, t, force) in enumerate(zip(self.device.stages, ("t1", "t2"), CONTACTS, strict=False)):
            parameters, hoisted = self._of_stage(index)
            polar = self.machine.graph(t)
            contact = dict(zip(stage.contact.function.name_out(),
                               stage.contact.function(polar, parameters, hoisted), strict=True))  # fmt: skip
            known: dict[str, ca.SX] = {"r": contact["r"], "dr": contact["dr"], "alpha0": self._constants["alpha_n"]}
            for name, value in STRENGTH.composed("pressure_angles", known).items():
                yield _row(f"{name}{index + 1}", value, "pressure angle", "rad")
            gears = self.device.machine.gears
            if gears is not None and gears.give_stress:
                bends = _curvatures(stage, polar, parameters, hoisted)
                yield from self._stresses(index, known | {"F": self.machine.graph(force)}, bends)

    def _stresses(self, index: int, known: Mapping[str, ca.SX], bends: tuple[ca.SX, ca.SX]) -> Iterator[Row]:
        own = {**known, **{name: self.device.machine.si(f"gears.{key}") for name, key in OF_GEARS.items()}}
        contact = STRENGTH.composed("contact_stress", own | {"kappa1": bends[0], "kappa2": bends[1]})
        stress = Quantity(f"contact{index + 1}", "N/m2", "contact stress", "")
        yield Row(stress, contact["square"], has_jumps=False, is_square=True)
        for gear, bend in zip(GEARS[index], bends, strict=True):
            bending = STRENGTH.composed("bending_stress", own | {"kappa1": bend})["sigma"]
            yield _row(f"bending, {gear}", bending, "bending stress", "N/m2")

    def _of_stage(self, index: int) -> tuple[ca.SX, ca.SX]:
        """Return parameters and coefficients of a stage, in the machine's symbols."""
        functions = self.device.functions
        inputs = functions.lane_inputs(functions.phi)[2 + 2 * index : 4 + 2 * index]
        design = self._d[: self.device.size]
        parameters, hoisted = ca.substitute(inputs, [functions.x, functions.h], [design, self._h])
        return parameters, hoisted

    def _cam(self) -> Row:
        theta = self.machine.graph("theta1")
        rate = ca.gradient(theta, self.phi) * self._constants["omega"]
        known = {**self._constants, "theta1": theta, "theta1_dot": rate, "Omega": self.machine.graph("Omega")}
        return _row("cam", CAM.composed("cam", known)["pressure"], "pressure angle of the cam", "rad")


def _row(name: str, graph: ca.SX, meaning: str, unit: str) -> Row:
    return Row(Quantity(name, unit, meaning, ""), graph, has_jumps=False)


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
