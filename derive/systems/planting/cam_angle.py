"""How steep the cam of the planting device is: the pressure angle between its normal and the way of the roller."""

from __future__ import annotations

import sympy as sp

from ...mechanics.frames import Motion, Vec, Y, displacement, unit
from ...model import ClosedForm, Let, System
from ...quantity import Quantity, Vector
from . import quantities as q
from .derivation import B1, CARRIER, PLANET, A, Half

ASSUMPTIONS = ("the cam's normal lies in the plane of the swing, as on a cylindrical roller parallel to the hinge",)
pressure = Quantity(
    "pressure", "rad", "pressure angle of the cam: from the way of the roller in its swing to the cam's normal",
    "derived: cam",
)  # fmt: skip


def pressure_angle() -> ClosedForm:
    """Between the roller's way as the planet sees it and the normal of its way as the carrier sees it."""
    motion = Motion({q.phi: q.omega, q.alpha: -q.Omega, q.theta1: q.theta1_dot})
    arm = displacement(B1, Half.of("inner half", A, 1, Y).E, PLANET)
    across = unit(PLANET, Y)
    seen = motion.relative_derivative(arm, CARRIER)
    normal = (seen - seen.dot(across) * across).cross(across)
    way = Vec(PLANET, tuple(c.diff(q.theta1) for c in arm.components))
    steep = sp.atan2(normal.cross(way).dot(across), sp.Abs(normal.dot(way)))
    inputs = (q.theta1, q.theta1_dot, q.Omega, q.MACHINE)
    return ClosedForm("cam", inputs, (Let(pressure, steep, "derived: cam"),), Vector("steepness", (pressure,)))


def exact() -> System:
    """The cam's pressure angle."""
    return System("planting_cam", "Pressure angle of the cam of the planting device", "derived (geometry)",
                  ASSUMPTIONS, closed_forms=(pressure_angle(),))  # fmt: skip


SYSTEMS = (exact,)
