"""Contours of cams for rollers: beside the curve that the roller's centre runs along on the cam, a radius away.

Whatever the follower is, the contact is on the normal of that pitch curve. Where the curve's centre of curvature is
nearer than the roller's radius, the roller cuts off what it has touched before (Norton, Cam Design and Manufacturing
Handbook, 2009, chapter 7).
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S

from ..model import Let
from ..quantity import Quantity
from .frames import Frame, Motion, Vec

PLANE = Frame("plane of the cam")
Plane = tuple[Expr, Expr]


def _found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: cam for a roller")


reach = _found("reach", "m", "radius of the roller, negative where the cam lies to the right of the pitch curve")
contact_x, contact_y = (_found(f"contact_{a}", "m", f"place of the contact in the plane of the cam, {a}") for a in "xy")
heading = _found("heading", "rad", "direction of the pitch curve in the plane of the cam, with the angle")
kappa = _found("kappa", "1/m", "curvature of the pitch curve, positive where it turns to the left")
room = _found("room", "1", "1 - radius of the roller / radius of curvature of the pitch curve towards the cam")
pressure = _found("pressure", "rad", "pressure angle: between the contact's normal and the motion of the centre")
CONTOUR = (contact_x, contact_y, heading, kappa, room, pressure)


def contour(place: Plane, velocity: Plane, acceleration: Plane, moves: Plane) -> tuple[Let, ...]:
    """Steps to a contour from the place of the roller's centre and how it moves as the cam sees it, by the angle.

    ``moves`` is along the motion of the centre that the follower leaves it.
    """
    x, y, dx, dy, ddx, ddy = (sp.Symbol(name, real=True) for name in ("x", "y", "dx", "dy", "ddx", "ddy"))
    motion = Motion({x: dx, y: dy, dx: ddx, dy: ddy})
    along = Vec(PLANE, (dx, dy, S.Zero))
    square = along.dot(along)
    beside = Vec(PLANE, (x - reach * dy / sp.sqrt(square), y + reach * dx / sp.sqrt(square), S.Zero))
    turning = sp.simplify(motion.rate(sp.atan2(dy, dx)) / sp.sqrt(square))
    share = sp.simplify(motion.derivative(beside).dot(along) / square)
    if sp.simplify(share - (1 - reach * turning)) != 0:
        raise ValueError("a parallel curve is not as long as its distance and the curvature say")
    values = dict(zip((x, y, dx, dy, ddx, ddy), (*place, *velocity, *acceleration), strict=True))
    follower = Vec(PLANE, (*moves, S.Zero))
    across, with_ = along.cross(follower)[2], along.dot(follower)
    found = {
        contact_x: beside[0], contact_y: beside[1], heading: sp.atan2(dy, dx), kappa: turning,
        room: 1 - reach * kappa, pressure: sp.atan2(sp.Abs(with_), sp.Abs(across)),
    }  # fmt: skip
    return tuple(Let(symbol, expr.xreplace(values), f"derived: {symbol.meaning}") for symbol, expr in found.items())
