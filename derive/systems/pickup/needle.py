"""Needle and tray of the seedling pick-up, and the arcs that lock its gears in the dwell.

The frame of a cell has its x axis along the cell's axis, into the cell, and its origin at the tray's surface.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S

from ...formulas import Formulas
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import System, let
from ...table import quantities

ASSUMPTIONS = (
    "the needle is a rectangle in the plane of the tip's path",
    "locking arcs lie about the sun's centre while they act",
)
q = quantities(
    """
    along             | m   | tip along the cell's axis, from the tray's surface
    across            | m   | tip beside the cell's axis, to the left
    tilt              | rad | angle of the needle from the cell's axis
    length            | m   | length of the needle
    width             | m   | width of the needle
    tip_right_along   | m   | corner of the needle, tip, right: along the cell's axis
    tip_right_across  | m   | corner of the needle, tip, right: across the cell's axis
    tip_left_along    | m   | corner of the needle, tip, left: along the cell's axis
    tip_left_across   | m   | corner of the needle, tip, left: across the cell's axis
    root_left_along   | m   | corner of the needle, root, left: along the cell's axis
    root_left_across  | m   | corner of the needle, root, left: across the cell's axis
    root_right_along  | m   | corner of the needle, root, right: along the cell's axis
    root_right_across | m   | corner of the needle, root, right: across the cell's axis
    right_surface     | m   | where the needle's right edge passes the tray's surface, across
    left_surface      | m   | where the needle's left edge passes the tray's surface, across
    axis              | rad | direction of the cell's axis in the machine's frame
    x                 | m   | place in the machine's frame, x
    y                 | m   | place in the machine's frame, y
    a1                | m   | centre distance of the non-circular pair
    radius            | m   | radius of the locking arcs
    addendum          | m   | height of the intermediate gear's teeth over its pitch curve
    reach             | rad | angle at the sun's centre to where the arc meets the intermediate gear's tip circle
    """,
    source="derived: needle",
    section="",
)
CELL = Frame("cell")
NEEDLE = Frame("needle", CELL, Z, q.tilt)
O = Point("O")  # noqa: E741
TIP = Point("tip", O, Vec(CELL, (q.along, q.across, S.Zero)))


def _corner(back: Expr, left: Expr) -> Vec:
    """A point of the needle, so far behind its tip and beside its middle line."""
    return displacement(O, Point("corner", TIP, Vec(NEEDLE, (-back, left, S.Zero))), CELL)


def needle(f: Formulas) -> None:
    """Corners in the frame of the cell, and where both edges pass the tray's surface."""
    right, left, back = -q.width / 2, q.width / 2, sp.Dummy("back")
    corners = {"tip_right": (S.Zero, right), "tip_left": (S.Zero, left),
               "root_left": (q.length, left), "root_right": (q.length, right)}  # fmt: skip
    steps = [
        let(q[f"{corner}_{axis}"], _corner(*place)[i])
        for corner, place in corners.items()
        for i, axis in enumerate(("along", "across"))
    ]
    for side, symbol in ((right, q.right_surface), (left, q.left_surface)):
        edge = _corner(back, side)
        (there,) = sp.solve(edge[0], back)
        steps.append(let(symbol, sp.simplify(edge[1].subs(back, there))))
    f.function("needle", (q.along, q.across, q.tilt, q.length, q.width), *steps, told="corners")


def placed(f: Formulas) -> None:
    """A place of the cell's frame along the axes of the machine's, from the cell's origin."""
    machine = Frame("machine")
    at = Vec(Frame("cell", machine, Z, q.axis), (q.along, q.across, S.Zero)).resolved(machine)
    f.function("placed", (q.along, q.across, q.axis), let(q.x, at[0]), let(q.y, at[1]), told="at")


def locking(f: Formulas) -> None:
    """The concave arc on the intermediate gear ends where it leaves that gear's tip circle.

    Of the triangle of both centres and that end; in sines of half the angle, which stay exact where it is small.
    """
    r, h, a = sp.symbols("r h a", positive=True)
    cosine = sp.Dummy("cosine")
    tips = a - r + h
    (found,) = sp.solve(a**2 + r**2 - 2 * a * r * cosine - tips**2, cosine)
    sine = sp.factor((1 - found) / 2).subs({r: q.radius, h: q.addendum, a: q.a1})
    f.function("locking", (q.a1, q.radius, q.addendum), let(q.reach, 2 * sp.asin(sp.sqrt(sine))), told="arc")


def exact() -> System:
    """Needle, tray and locking arcs."""
    title = "Needle and locking arcs of the pick-up"
    f = Formulas("pickup_needle", given=q, title=title, source="derived (geometry)", assumptions=ASSUMPTIONS)
    needle(f)
    placed(f)
    locking(f)
    return f.system()


SYSTEMS = (exact,)
