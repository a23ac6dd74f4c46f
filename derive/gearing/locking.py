"""Arcs that hold a driven gear while its driving gear turns on: a convex one, and a concave one cut into its teeth.

Both lie about the driving gear's axis. What is left of the driven gear's teeth on both sides of the line of centres are
horns; each keeps the gear from turning one way.
"""

from __future__ import annotations

import sympy as sp
from sympy import S

from ..formulas import Formulas
from ..mechanics.frames import Frame, Vec
from ..model import System, let
from ..table import quantities

ASSUMPTIONS = (
    "locking arcs lie about the driving gear's axis while they act",
    "the tips of the driven gear beside the line of centres lie on a circle about its axis",
)
q = quantities(
    """
    distance | m   | distance of the gears' axes
    tips     | m   | radius of the driven gear's tip circle beside the line of centres
    friction | 1   | coefficient of friction between the arcs
    radius   | m   | radius of the locking arcs
    reach    | rad | angle at the driving gear's axis to where the arc leaves the driven gear's tip circle
    """,
    source="derived: locking arcs",
    section="",
)
HORN = Frame("horn's edge")
"""Its origin is the driving gear's axis, its x axis goes through the edge of a horn, where the arc meets the tips."""


def least(f: Formulas) -> None:
    """The radius with which a horn can just not hold: what acts on its edge goes through the driven gear's axis.

    That is the arc's normal force, outwards, and as much friction as there can be. With a larger radius the force turns
    the gear back however it rubs.
    """
    r, tips, a = sp.symbols("r tips a", positive=True)
    force = Vec(HORN, (S.One, q.friction, S.Zero))
    to_axis = tuple(tips * c / sp.sqrt(force.dot(force)) for c in force.components)
    axis = Vec(HORN, (r + to_axis[0], *to_axis[1:]))
    found = max(sp.solve(axis.dot(axis) - a**2, r), key=lambda root: float(root.subs({a: 3, tips: 2, q.friction: 0})))
    f.function("least", (q.distance, q.tips, q.friction),
               let(q.radius, found.subs({a: q.distance, tips: q.tips})), told="held")  # fmt: skip


def horn(f: Formulas) -> None:
    """Where the arc leaves the driven gear's tip circle: of the triangle of both axes and that place.

    In sines of half the angle, which stay exact where it is small.
    """
    cosine, tips = sp.Dummy("cosine"), sp.Symbol("tips", positive=True)
    (found,) = sp.solve(q.distance**2 + q.radius**2 - 2 * q.distance * q.radius * cosine - tips**2, cosine)
    sine = sp.factor((1 - found) / 2).subs(tips, q.tips)
    f.function("horn", (q.distance, q.radius, q.tips), let(q.reach, 2 * sp.asin(sp.sqrt(sine))), told="arc")


def exact() -> System:
    """Locking arcs."""
    title = "Locking arcs of gears that dwell"
    f = Formulas("locking_arcs", given=q, title=title, source="derived (geometry)", assumptions=ASSUMPTIONS)
    least(f)
    horn(f)
    return f.system()


SYSTEMS = (exact,)
