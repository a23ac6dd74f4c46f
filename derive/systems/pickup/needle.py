"""Needle and tray of the seedling pick-up.

The frame of a cell has its x axis along the cell's axis, into the cell, and its origin at the tray's surface.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S

from ...formulas import Formulas
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import System, let
from ...table import quantities

ASSUMPTIONS = ("the needle is a rectangle in the plane of the tip's path",)
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


def exact() -> System:
    """Needle and tray."""
    title = "Needle of the pick-up"
    f = Formulas("pickup_needle", given=q, title=title, source="derived (geometry)", assumptions=ASSUMPTIONS)
    needle(f)
    placed(f)
    return f.system()


SYSTEMS = (exact,)
