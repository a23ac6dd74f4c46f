"""A disc cam for a roller, from the path of the roller's centre over the angle of the cam."""

from __future__ import annotations

from functools import partial

from sympy import S

from ..mechanics import contacts as cams
from ..mechanics.frames import Frame, Motion, Vec, Z
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector

ASSUMPTIONS = (
    "the cam turns anticlockwise about the origin by the angle of its mechanism, in the plane of "
    "the roller's centre",
    "the pressure angle at rest is its limit where the motion before the rest ends",
)


_cam = partial(Quantity, source="derived: disc cam")


phi = _cam("phi", "rad", "angle of the cam")
x, y = (_cam(a, "m", f"centre of the roller from the cam's axis, {a}") for a in "xy")
dx, dy = (_cam(f"d{a}", "m", f"slope of the centre of the roller, {a}, by the angle") for a in "xy")
ddx, ddy = (
    _cam(f"dd{a}", "m", f"second derivative of the centre of the roller, {a}, by the angle")
    for a in "xy"
)
CENTRE = Vector("centre", (x, y, dx, dy, ddx, ddy))
WAY = Vector(
    "way",
    tuple(
        _cam(f"way_{a}", "m", f"motion of the centre that its guide leaves it, of any size, {a}")
        for a in "xy"
    ),
)
pitch_x, pitch_y = (_cam(f"pitch_{a}", "m", f"centre of the roller on the cam, {a}") for a in "xy")

WORLD = Frame("frame")
CAM = Frame("cam", WORLD, Z, phi)


def disc_contour() -> ClosedForm:
    """Return the contour of the cam in the cam's frame."""
    motion = Motion({phi: S.One, x: dx, y: dy, dx: ddx, dy: ddy})
    position = Vec(WORLD, (x, y, S.Zero)).resolved(CAM)
    velocity = Vec(CAM, tuple(motion.rate(c) for c in position.components))
    acceleration = Vec(CAM, tuple(motion.rate(c) for c in velocity.components))
    moves = Vec(WORLD, (*WAY, S.Zero)).resolved(CAM)
    plane = ((v[0], v[1]) for v in (position, velocity, acceleration, moves))
    source = "derived: in the cam's frame"
    steps = (
        Let(pitch_x, position[0], source),
        Let(pitch_y, position[1], source),
        *cams.contour_steps(*plane),
    )
    return ClosedForm(
        "disc",
        (phi, CENTRE, WAY, cams.reach),
        steps,
        Vector("contour", (pitch_x, pitch_y, *cams.CONTOUR)),
    )


def build_cam_system() -> System:
    """Build the model of a disc cam."""
    return System(
        "disc_cam",
        "Disc cam for a roller",
        "derived (geometry)",
        ASSUMPTIONS,
        closed_forms=(disc_contour(),),
    )


SYSTEMS = (build_cam_system,)
