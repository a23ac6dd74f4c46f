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
QUANTITIES = ("height", "tilt", "ground_intersection", "clearance", "nozzle_distance", "squared_distance")
DISTANCE_EPS = 1e-9
"""Regularises a distance d at zero: sqrt(d^2 + eps^2) [m]."""
SIDE_OFFSET = float(np.pi)
"""Side 2 follows half a revolution later [rad]."""


class NozzleMotion:
    """Functions of (phi, z), z = (x, c, h) stacked: tip, tilt and the distances in the requirements."""

    def __init__(self, device: Device) -> None:
        functions = device.functions
        self.phi, x, c, h = functions.inputs
        self.z = ca.vertcat(x, c, h)
        names = [entry["name"] for entry in device.sidecar["vectors"]["side"]]
        constants = [entry["name"] for entry in device.sidecar["vectors"]["machine"]]
        self.c = dict(zip(constants, ca.vertsplit(c), strict=True))
        side = functions.side(self.phi)
        moving = ca.vertcat(*(side[names.index(name)] for name in MOVING))
        self._side = ca.Function("one", [self.phi, self.z], [moving])

    def at(self, phi: ca.SX) -> dict[str, ca.SX]:
        """Return the quantities of `MOVING`, and `tilt` from the vertical, at a carrier angle."""
        quantities = dict(zip(MOVING, ca.vertsplit(self._side(phi, self.z)), strict=True))
        return quantities | {"tilt": NOZZLE.composed("axis", quantities | {"soil": ca.SX(0)})["tilt"]}

    def _function(self, name: str, value: ca.SX, *more: ca.SX) -> ca.Function:
        """Return (phi, z, ...) -> value, with first and second derivative in phi."""
        first = ca.gradient(value, self.phi)
        return ca.Function(name, [self.phi, self.z, *more], [value, first, ca.gradient(first, self.phi)])

    @cached_property
    def height(self) -> ca.Function:
        """(phi, z) -> height of the tip [m], with derivatives."""
        return self._function("height", self.at(self.phi)["y_tip"])

    @cached_property
    def position(self) -> ca.Function:
        """(phi, z) -> horizontal position of the tip over ground [m], with derivatives."""
        return self._function("position", self.at(self.phi)["x_tip"])

    @cached_property
    def tilt(self) -> ca.Function:
        """(phi, z) -> tilt of the nozzle from the vertical [rad], with derivatives."""
        return self._function("tilt", self.at(self.phi)["tilt"])

    @cached_property
    def ground_intersection(self) -> ca.Function:
        """(phi, z, soil) -> position over ground where the nozzle's axis meets the soil level [m], with derivatives."""
        soil, at = ca.SX.sym("soil"), self.at(self.phi)
        return self._function("cut", NOZZLE.composed("axis", at | {"soil": soil})["cut"], soil)

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
        inputs = self.c | self.at(self.phi) | {"plant": plant, "top": top, "hair": DISTANCE_EPS}
        return self._function("clearance", NOZZLE.composed("half", inputs)["clearance"], plant, top)

    @cached_property
    def squared_distance(self) -> ca.Function:
        """(phi, z, x, y) -> squared distance of the tip from a point in the machine's frame [m2], with derivatives."""
        x, y, at = ca.SX.sym("x"), ca.SX.sym("y"), self.at(self.phi)
        return self._function("apart", (at["x_tip_machine"] - x) ** 2 + (at["y_tip"] - y) ** 2, x, y)

    @cached_property
    def nozzle_distance(self) -> ca.Function:
        """(phi, z) -> distance of the two nozzles' axes, funnel to tip, in their plane [m], with derivatives.

        If the axes cross, it is the negative of the shortest displacement that separates them.
        """
        first, second = (self._segment(self.phi - lag) for lag in (0.0, SIDE_OFFSET))
        pairs = ((first, second), (second, first))
        ends = [_distance_to_segment(p, *target) for points, target in pairs for p in points]
        distance = ca.fmin(ca.fmin(ends[0], ends[1]), ca.fmin(ends[2], ends[3]))
        sides = [_signed_area(*line, p) * _signed_area(*line, q) for line, (p, q) in pairs]
        crossing = ca.logic_and(sides[0] < 0, sides[1] < 0)
        return self._function("between", ca.if_else(crossing, -distance, distance))

    def _segment(self, phi: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return funnel and tip in the machine's frame."""
        at = self.at(phi)
        return ca.vertcat(at["x_B1"], at["y_B1"]), ca.vertcat(at["x_tip_machine"], at["y_tip"])

    @cached_property
    def kernels(self) -> dict[str, Kernel]:
        """Kernels over many angles, each a value with its first two derivatives in phi, by `QUANTITIES`."""
        return {name: _build_kernel(getattr(self, name)) for name in QUANTITIES}

    @cached_property
    def contact_kernels(self) -> tuple[Kernel, Kernel]:
        """Kernels of both stages: the inner gear's polar angle at the contact [rad]."""
        at = self.at(self.phi)
        return _build_kernel(self._function("contact1", at["t1"])), _build_kernel(self._function("contact2", at["t2"]))

    @cached_property
    def position_kernel(self) -> Kernel:
        """Kernel of `position`."""
        return _build_kernel(self.position)


def _build_kernel(f: ca.Function) -> Kernel:
    inputs = f.sx_in()
    names = ["phi", "z", "first", "second"][: len(inputs)]
    return Kernel(ca.Function(f.name(), inputs, f.call(inputs), names, ["f", "df", "ddf"]), lanes=["phi"])


def _distance_to_segment(p: ca.SX, a: ca.SX, b: ca.SX) -> ca.SX:
    """Return the distance of a point from the segment from a to b."""
    share = ca.dot(p - a, b - a) / ca.sumsqr(b - a)
    return ca.sqrt(ca.sumsqr(p - a - ca.fmin(ca.fmax(share, 0), 1) * (b - a)) + 1e-18)


def _signed_area(a: ca.SX, b: ca.SX, p: ca.SX) -> ca.SX:
    """Return twice the signed area of a triangle, whose sign says on which side of a line a point lies."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
