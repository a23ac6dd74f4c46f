"""Teeth of a rack on pitch curves: where they meet, they do as on the circles that osculate there (ISO 21771).

In terms of curvatures, so that a straight or hollow place is no exception.
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S, pi

from ..mechanics.frames import Frame, Vec, X, Z, unit
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector

ASSUMPTIONS = (
    "rack teeth without profile shift or backlash",
    "at a contact a non-circular gear meshes like the circle that osculates its pitch curve there",
)
TRANSVERSE = Frame("transverse section")


def _given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: teeth")


kappa1 = _given("kappa1", "1/m", "curvature of the one pitch curve, positive where convex")
kappa2 = _given("kappa2", "1/m", "curvature of the other pitch curve, positive where convex")
module = _given("module", "m", "module")
ha1 = _given("ha1", "1", "addendum of the one gear's teeth in modules")
ha2 = _given("ha2", "1", "addendum of the other gear's teeth in modules")
alpha0 = _given("alpha0", "rad", "pressure angle")
TEETH = Vector("teeth", (module, ha1, ha2, alpha0))
square1, square2 = (
    _given(f"square{i}", "1", f"square under the root of the path of action to the tips of the {which} gear")
    for i, which in ((1, "one"), (2, "other"))
)
outside1, outside2 = (
    _given(
        f"outside{i}", "1", f"how far the tips of the {which} gear lie outside their base circle, in radii of curvature"
    )
    for i, which in ((1, "one"), (2, "other"))
)
g1 = _given("g1", "m", "path of action to the tips of the one gear")
g2 = _given("g2", "m", "path of action to the tips of the other gear")
epsilon = _given("epsilon", "1", "contact ratio")
LEAST = sp.Rational(1, 10**12)
"""Square that a path of action goes on from where tips lie inside their base circle, so that its slope is finite."""


def path_of_action(radius: Expr, addendum: Expr, angle: Expr) -> Expr:
    """Length of the line of action from the pitch point to where it leaves the circle through the tips of the teeth."""
    r, h, alpha = _GENERIC
    return _generic_path().subs({r: radius, h: addendum, alpha: angle})


_GENERIC = sp.symbols("r h alpha", positive=True)


@cache
def _generic_path() -> Expr:
    """The path of action of a radius, an addendum and a pressure angle that are plain symbols."""
    s = sp.Symbol("s")
    r, h, alpha = _GENERIC
    centre = Vec(TRANSVERSE, (S.Zero, -r, S.Zero))
    line = unit(Frame("line of action", TRANSVERSE, Z, alpha), X).resolved(TRANSVERSE)
    arm = s * line - centre
    leaves = sp.solve(sp.expand(arm.dot(arm) - (r + h) ** 2), s)
    return next(root for root in leaves if root.subs({r: 1, h: 1, alpha: pi / 6}) > 0)


def base_pitch(pitch: Expr, angle: Expr) -> Expr:
    """A pitch along the tangent, seen along the line of action."""
    line = unit(Frame("line of action", TRANSVERSE, Z, angle), X).resolved(TRANSVERSE)
    return line.dot(Vec(TRANSVERSE, (pitch, S.Zero, S.Zero)))


def outside(kappa: Expr, addendum: Expr, angle: Expr) -> Expr:
    """Tip radius less that of the base circle, which the line of action touches, over the radius of curvature."""
    r = sp.Symbol("r", positive=True)
    line = unit(Frame("line of action", TRANSVERSE, Z, angle), X).resolved(TRANSVERSE)
    base = line.cross(Vec(TRANSVERSE, (S.Zero, r, S.Zero)))[2]
    return sp.expand((r + addendum - base) / r).subs(r, 1 / kappa)


def by_curvature(kappa: Expr, addendum: Expr, angle: Expr, square: Expr | None = None) -> tuple[Expr, Expr]:
    """The square under the path of action's root over that of the radius, and the path, finite without curvature.

    The path is rationalised; ``square`` stands in it for the first.
    """
    known, h, alpha = sp.symbols("known h alpha", positive=True)
    root = sp.expand(path_of_action(1 / known, h, alpha))
    (surd,) = (power for power in root.atoms(sp.Pow) if power.exp == S.Half)
    conjugate = root.subs(surd, -surd)
    top = -sp.expand(known * sp.simplify(root * conjugate))
    under = sp.expand(known**2 * surd**2)
    path = top / (sp.sqrt(under if square is None else square) - sp.expand(known * (conjugate + surd)))
    values = {known: kappa, h: addendum, alpha: angle}
    return under.subs(values), path.subs(values)


def contact_ratio() -> ClosedForm:
    """Both paths of action over the base pitch; how far the tips are outside of their base circles."""
    steps: list[Let] = []
    for square, g, over, kappa, ha in ((square1, g1, outside1, kappa1, ha1), (square2, g2, outside2, kappa2, ha2)):
        under, path = by_curvature(kappa, ha * module, alpha0, sp.Max(square, LEAST))
        steps += [
            Let(square, under, "derived: path of action"),
            Let(g, path, "derived: path of action"),
            Let(over, outside(kappa, ha * module, alpha0), "derived: base circle"),
        ]
    ratio = Let(epsilon, (g1 + g2) / base_pitch(pi * module, alpha0), "derived: contact ratio")
    outputs = Vector("meshing", (epsilon, g1, g2, outside1, outside2))
    return ClosedForm("contact_ratio", (kappa1, kappa2, TEETH), (*steps, ratio), outputs)


def exact() -> System:
    """Teeth on pitch curves."""
    return System("gear_teeth", "Rack teeth on pitch curves", "derived (geometry)", ASSUMPTIONS,
                  closed_forms=(contact_ratio(),))  # fmt: skip


SYSTEMS = (exact,)
