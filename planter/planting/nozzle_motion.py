"""Where tip, nozzle and funnel are: the motion of one side as functions of the carrier angle, for CasADi's graphs.

Over ground the tip's x holds the machine's travel; in the machine's frame it does not. Angles in rad, lengths in m.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from planter.kernels import Kernel, formulas
from planter.planting.model import Device

MOVING = ("x_tip", "x_tip_machine", "y_tip", "alpha", "theta1", "x_B1", "y_B1", "t1", "t2")
NOZZLE = formulas.load("planting_nozzle")
COURSES = ("height", "tilt", "cut", "clearance", "between", "apart")
HAIR = 1e-9
"""Keeps the slope of the distance from the plant finite where there is none [m]."""
HALF = float(np.pi)
"""Side 2 follows half a turn later [rad]."""


class NozzleMotion:
    """Functions of (phi, z), z = (x, c, h) stacked: tip, tilt and the distances that requirements speak of."""

    def __init__(self, device: Device) -> None:
        functions = device.functions
        self.phi, x, c, h = functions.inputs
        self.z = ca.vertcat(x, c, h)
        names = [entry["name"] for entry in device.sidecar["vectors"]["side"]]
        constants = [entry["name"] for entry in device.sidecar["vectors"]["machine"]]
        self.c = dict(zip(constants, ca.vertsplit(c), strict=True))
        side = functions.side(self.phi)
        one = ca.Function("one", [self.phi, self.z], [ca.vertcat(*(side[names.index(name)] for name in MOVING))])
        self._one = one

    def at(self, phi: ca.SX) -> dict[str, ca.SX]:
        """What `MOVING` lists, and `tilt`, from the vertical, at a carrier angle."""
        found = dict(zip(MOVING, ca.vertsplit(self._one(phi, self.z)), strict=True))
        return found | {"tilt": NOZZLE.composed("axis", found | {"soil": ca.SX(0)})["tilt"]}

    def _course(self, name: str, value: ca.SX, *more: ca.SX) -> ca.Function:
        """(phi, z, ...) -> value, its first and its second derivative in phi."""
        first = ca.gradient(value, self.phi)
        return ca.Function(name, [self.phi, self.z, *more], [value, first, ca.gradient(first, self.phi)])

    @cached_property
    def height(self) -> ca.Function:
        """Of the tip [m]."""
        return self._course("height", self.at(self.phi)["y_tip"])

    @cached_property
    def place(self) -> ca.Function:
        """Of the tip over ground, horizontal [m]."""
        return self._course("place", self.at(self.phi)["x_tip"])

    @cached_property
    def tilt(self) -> ca.Function:
        """Of the nozzle from the vertical [rad]."""
        return self._course("tilt", self.at(self.phi)["tilt"])

    @cached_property
    def cut(self) -> ca.Function:
        """(phi, z, soil) -> where over ground the nozzle's axis passes the level of the soil [m], with derivatives."""
        soil, at = ca.SX.sym("soil"), self.at(self.phi)
        return self._course("cut", NOZZLE.composed("axis", at | {"soil": soil})["cut"], soil)

    @cached_property
    def funnel_speed(self) -> ca.Function:
        """(phi, z) -> speed of B1 relative to the machine [m/s]."""
        at = self.at(self.phi)
        rates = (ca.gradient(at[name], self.phi) for name in ("x_B1", "y_B1"))
        return ca.Function("funnel", [self.phi, self.z], [ca.norm_2(ca.vertcat(*rates)) * self.c["omega"]])

    @cached_property
    def clearance(self) -> ca.Function:
        """(phi, z, plant, top) -> least horizontal distance of a nozzle half from the plant's axis [m].

        Of the half counts what is lower than the seedling's `top`; `plant` is where over ground the seedling stands.
        """
        plant, top = ca.SX.sym("plant"), ca.SX.sym("top")
        known = self.c | self.at(self.phi) | {"plant": plant, "top": top, "hair": HAIR}
        return self._course("clearance", NOZZLE.composed("half", known)["clearance"], plant, top)

    @cached_property
    def apart(self) -> ca.Function:
        """(phi, z, x, y) -> squared distance of the tip from a point in the machine's frame [m2], with derivatives."""
        x, y, at = ca.SX.sym("x"), ca.SX.sym("y"), self.at(self.phi)
        return self._course("apart", (at["x_tip_machine"] - x) ** 2 + (at["y_tip"] - y) ** 2, x, y)

    @cached_property
    def between(self) -> ca.Function:
        """(phi, z) -> distance of the two nozzles' axes, funnel to tip, in their plane [m]; negative where they cross.

        Then it is the least way out, with the sign reversed.
        """
        one, two = (self._segment(self.phi - lag) for lag in (0.0, HALF))
        ends = [_to_segment(p, *other) for mine, other in ((one, two), (two, one)) for p in mine]
        least = ca.fmin(ca.fmin(ends[0], ends[1]), ca.fmin(ends[2], ends[3]))
        apart = [_turn(*a, p) * _turn(*a, q) for a, (p, q) in ((one, two), (two, one))]
        crossing = ca.logic_and(apart[0] < 0, apart[1] < 0)
        return self._course("between", ca.if_else(crossing, -least, least))

    def _segment(self, phi: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Funnel and tip in the machine's frame."""
        at = self.at(phi)
        return ca.vertcat(at["x_B1"], at["y_B1"]), ca.vertcat(at["x_tip_machine"], at["y_tip"])

    @cached_property
    def course_kernels(self) -> dict[str, Kernel]:
        """The courses over many angles: each value with its first two derivatives in phi."""
        return {name: _lanes(getattr(self, name)) for name in COURSES}

    @cached_property
    def contact_kernels(self) -> tuple[Kernel, Kernel]:
        """Of both stages: the inner gear's polar angle at the contact [rad]."""
        at = self.at(self.phi)
        return _lanes(self._course("contact1", at["t1"])), _lanes(self._course("contact2", at["t2"]))

    @cached_property
    def place_kernel(self) -> Kernel:
        """Of `place`."""
        return _lanes(self.place)


def _lanes(f: ca.Function) -> Kernel:
    inputs = f.sx_in()
    names = ["phi", "z", "first", "second"][: len(inputs)]
    return Kernel(ca.Function(f.name(), inputs, f.call(inputs), names, ["f", "df", "ddf"]), lanes=["phi"])


def _to_segment(p: ca.SX, a: ca.SX, b: ca.SX) -> ca.SX:
    """Distance of a point from the line from a to b."""
    along = ca.dot(p - a, b - a) / ca.sumsqr(b - a)
    return ca.sqrt(ca.sumsqr(p - a - ca.fmin(ca.fmax(along, 0), 1) * (b - a)) + 1e-18)


def _turn(a: ca.SX, b: ca.SX, p: ca.SX) -> ca.SX:
    """Twice the signed area of the triangle: on which side of a line a point lies."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
