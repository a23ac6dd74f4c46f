"""A disc cam for a roller, from the way of the roller's centre over the angle of the cam."""

from __future__ import annotations

from sympy import S

from ..mechanics import contacts as cams
from ..mechanics.frames import Frame, Motion, Vec, Z
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector

ASSUMPTIONS = (
    "the cam turns anticlockwise about the origin by the angle of its mechanism, in the plane of the roller's centre",
    "the pressure angle is told where the roller's centre moves; where it rests, it is zero",
)


def _given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: disc cam")


phi = _given("phi", "rad", "angle of the cam")
x, y = (_given(a, "m", f"centre of the roller from the cam's axis, {a}") for a in "xy")
dx, dy = (_given(f"d{a}", "m", f"slope of the centre of the roller, {a}, by the angle") for a in "xy")
ddx, ddy = (_given(f"dd{a}", "m", f"second derivative of the centre of the roller, {a}, by the angle") for a in "xy")
CENTRE = Vector("centre", (x, y, dx, dy, ddx, ddy))
pitch_x, pitch_y = (_given(f"pitch_{a}", "m", f"centre of the roller on the cam, {a}") for a in "xy")

WORLD = Frame("frame")
CAM = Frame("cam", WORLD, Z, phi)


def disc() -> ClosedForm:
    """The contour as the cam has it, in axes of its own."""
    motion = Motion({phi: S.One, x: dx, y: dy, dx: ddx, dy: ddy})
    place = Vec(WORLD, (x, y, S.Zero)).resolved(CAM)
    velocity = Vec(CAM, tuple(motion.rate(c) for c in place.components))
    acceleration = Vec(CAM, tuple(motion.rate(c) for c in velocity.components))
    moves = Vec(WORLD, (dx, dy, S.Zero)).resolved(CAM)
    plane = ((v[0], v[1]) for v in (place, velocity, acceleration, moves))
    source = "derived: as the cam sees it"
    steps = (Let(pitch_x, place[0], source), Let(pitch_y, place[1], source), *cams.contour(*plane))
    return ClosedForm("disc", (phi, CENTRE, cams.reach), steps, Vector("contour", (pitch_x, pitch_y, *cams.CONTOUR)))


def build_cam_system() -> System:
    """A disc cam."""
    return System("disc_cam", "Disc cam for a roller", "derived (geometry)", ASSUMPTIONS, closed_forms=(disc(),))


SYSTEMS = (build_cam_system,)
