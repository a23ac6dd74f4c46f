"""Needle and tray of the seedling pick-up, and the arcs that lock its gears in the dwell.

The frame of a cell has its x axis along the cell's axis, into the cell, and its origin at the tray's surface.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S

from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import ClosedForm, System, let
from ...quantity import Quantity, Vector

ASSUMPTIONS = (
    "the needle is a rectangle in the plane of the tip's path",
    "locking arcs lie about the sun's centre while they act",
)


def _given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: needle")


along = _given("along", "m", "tip along the cell's axis, from the tray's surface")
across = _given("across", "m", "tip beside the cell's axis, to the left")
tilt = _given("tilt", "rad", "angle of the needle from the cell's axis")
length = _given("length", "m", "length of the needle")
width = _given("width", "m", "width of the needle")
CORNERS = ("tip_right", "tip_left", "root_left", "root_right")
PLACES = tuple(
    _given(f"{corner}_{axis}", "m", f"corner of the needle, {corner.replace('_', ', ')}: {axis} the cell's axis")
    for corner in CORNERS
    for axis in ("along", "across")
)
SURFACES = tuple(
    _given(f"{side}_surface", "m", f"where the needle's {side} edge passes the tray's surface, across")
    for side in ("right", "left")
)
CELL = Frame("cell")
NEEDLE = Frame("needle", CELL, Z, tilt)
O = Point("O")  # noqa: E741
TIP = Point("tip", O, Vec(CELL, (along, across, S.Zero)))


def _corner(back: Expr, left: Expr) -> Vec:
    """A point of the needle, so far behind its tip and beside its middle line."""
    return displacement(O, Point("corner", TIP, Vec(NEEDLE, (-back, left, S.Zero))), CELL)


def needle() -> ClosedForm:
    """Corners in the frame of the cell, and where both edges pass the tray's surface."""
    half = width / 2
    corners = [_corner(S.Zero, -half), _corner(S.Zero, half), _corner(length, half), _corner(length, -half)]
    lets = [let(symbol, corners[i // 2][i % 2]) for i, symbol in enumerate(PLACES)]
    back = sp.Dummy("back")
    for side, symbol in zip((-half, half), SURFACES, strict=True):
        edge = _corner(back, side)
        (there,) = sp.solve(edge[0], back)
        lets.append(let(symbol, sp.simplify(edge[1].subs(back, there))))
    inputs = (along, across, tilt, length, width)
    return ClosedForm("needle", inputs, tuple(lets), Vector("corners", (*PLACES, *SURFACES)))


axis = _given("axis", "rad", "direction of the cell's axis in the machine's frame")
x, y = (_given(name, "m", f"place in the machine's frame, {name}") for name in "xy")


def placed() -> ClosedForm:
    """A place of the cell's frame along the axes of the machine's, from the cell's origin."""
    found = Vec(Frame("cell", Frame("machine"), Z, axis), (along, across, S.Zero)).resolved(Frame("machine"))
    return ClosedForm("placed", (along, across, axis), (let(x, found[0]), let(y, found[1])), Vector("at", (x, y)))


distance = _given("a1", "m", "centre distance of the non-circular pair")
radius = _given("radius", "m", "radius of the locking arcs")
addendum = _given("addendum", "m", "height of the intermediate gear's teeth over its pitch curve")
reach = _given("reach", "rad", "angle at the sun's centre to where the arc meets the intermediate gear's tip circle")


def locking() -> ClosedForm:
    """The concave arc on the intermediate gear ends where it leaves that gear's tip circle.

    Of the triangle of both centres and that end; in sines of half the angle, which stay exact where it is small.
    """
    r, h, a = sp.symbols("r h a", positive=True)
    cosine = sp.Dummy("cosine")
    tips = a - r + h
    (found,) = sp.solve(a**2 + r**2 - 2 * a * r * cosine - tips**2, cosine)
    sine = sp.factor((1 - found) / 2).subs({r: radius, h: addendum, a: distance})
    step = let(reach, 2 * sp.asin(sp.sqrt(sine)))
    return ClosedForm("locking", (distance, radius, addendum), (step,), Vector("arc", (reach,)))


def exact() -> System:
    """Needle, tray and locking arcs."""
    return System("pickup_needle", "Needle and locking arcs of the pick-up", "derived (geometry)", ASSUMPTIONS,
                  closed_forms=(needle(), placed(), locking()))  # fmt: skip


SYSTEMS = (exact,)
