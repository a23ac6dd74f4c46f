"""Teeth on pitch curves: contact ratio (ISO 21771), stresses by Hertz and Lewis, and the locking
arcs of a dwell.

Where teeth meet they mesh as on the circles that osculate the pitch curves there. Everything is in
terms of curvatures, so that straight and concave pitch curves need no special case.
"""

from __future__ import annotations

from functools import cache, partial

import sympy as sp
from sympy import Expr, Rational, S, pi

from ...formulas import Formulas
from ...model import ClosedForm, Let, System, let
from ...quantity import Quantity, Vector, quantities, read_quantities
from ..frames import Frame, Vec, X, Z, unit

TEETH_ASSUMPTIONS = (
    "rack teeth without profile shift or backlash",
    "at a contact a non-circular gear meshes like the circle that osculates its pitch curve there",
)
TRANSVERSE = Frame("transverse section")


_teeth = partial(Quantity, source="derived: teeth")


t = read_quantities(
    """
derived: teeth
kappa1 | 1/m | curvature of the first pitch curve, positive where convex
kappa2 | 1/m | curvature of the second pitch curve, positive where convex
module | m | module
ha1 | 1 | addendum of the first gear's teeth in modules
ha2 | 1 | addendum of the second gear's teeth in modules
alpha0 | rad | pressure angle
square1 | 1 | square under the root of the path of action to the tips of the first gear
square2 | 1 | square under the root of the path of action to the tips of the second gear
outside1 | 1 | height of the first gear's tips over their base circle, in radii of curvature
outside2 | 1 | height of the second gear's tips over their base circle, in radii of curvature
g1 | m | path of action to the tips of the first gear
g2 | m | path of action to the tips of the second gear
epsilon | 1 | contact ratio

derived: strength
r | m | pitch radius at the contact
dr | m | slope of the pitch radius, per polar angle
towards | rad | pressure angle of the flank on the side to which the pitch radius grows
against | rad | pressure angle of the flank on the opposite side
F | N | normal force between the teeth
b | m | width of the face
E | N/m2 | Young's modulus, of both gears
nu | 1 | Poisson's ratio, of both gears
E_contact | N/m2 | contact modulus: 1/E_contact is the sum of (1 - nu^2)/E over both gears
kappa | 1/m | relative curvature of both flanks at the pitch point
square | N2/m4 | square of the largest pressure in the contact
p0 | N/m2 | largest pressure in the contact of the flanks
half_width | m | half the width of the strip on which the flanks touch
teeth_inverse | 1 | one over the number of teeth of the gear on the osculating circle
Y | 1 | Lewis's form factor, in modules
sigma | N/m2 | bending stress at the root of a tooth
"""
)
"""Quantities of this module."""


TEETH = Vector("teeth", t.select("module ha1 ha2 alpha0"))


SQUARE_MINIMUM = sp.Rational(1, 10**12)
"""Lower bound of the square under the root, so that the path of action has a finite slope inside
the base circle.
"""


def line_of_action(angle: Expr) -> Vec:
    """Return the unit vector at the pressure angle from the common tangent, in the transverse
    section.
    """
    return unit(Frame("line of action", TRANSVERSE, Z, angle), X).resolved(TRANSVERSE)


def path_of_action(radius: Expr, addendum: Expr, angle: Expr) -> Expr:
    """Return the length of the line of action from the pitch point to the circle through the tips
    of the teeth [m].
    """
    return _plain_path().subs(dict(zip(_PLAIN, (radius, addendum, angle), strict=True)))


_PLAIN = sp.symbols("r h alpha", positive=True)


@cache
def _plain_path() -> Expr:
    """Return the path of action for a radius, an addendum and a pressure angle that are plain
    symbols.
    """
    s = sp.Symbol("s")
    r, h, alpha = _PLAIN
    arm = s * line_of_action(alpha) - Vec(TRANSVERSE, (S.Zero, -r, S.Zero))
    intersections = sp.solve(sp.expand(arm.dot(arm) - (r + h) ** 2), s)
    return next(root for root in intersections if root.subs({r: 1, h: 1, alpha: pi / 6}) > 0)


def base_pitch(pitch: Expr, angle: Expr) -> Expr:
    """Return a pitch along the tangent as projected on the line of action [m]."""
    return line_of_action(angle).dot(Vec(TRANSVERSE, (pitch, S.Zero, S.Zero)))


def height_over_base_circle(kappa: Expr, addendum: Expr, angle: Expr) -> Expr:
    """Return tip radius minus base radius over the radius of curvature [1]; the line of action
    touches the base.
    """
    r = sp.Symbol("r", positive=True)
    base = line_of_action(angle).cross(Vec(TRANSVERSE, (S.Zero, r, S.Zero)))[2]
    return sp.expand((r + addendum - base) / r).subs(r, 1 / kappa)


def path_by_curvature(
    kappa: Expr, addendum: Expr, angle: Expr, square: Expr | None = None
) -> tuple[Expr, Expr]:
    """Return the path of action in a form that is finite at curvature 0: the square under its root,
    and the path.

    The square is that over the squared radius. The path is rationalised; ``square`` replaces the
    square in it.
    """
    curvature, h, alpha = sp.symbols("known h alpha", positive=True)
    root = sp.expand(path_of_action(1 / curvature, h, alpha))
    (surd,) = (power for power in root.atoms(sp.Pow) if power.exp == S.Half)
    conjugate = root.subs(surd, -surd)
    numerator = -sp.expand(curvature * sp.simplify(root * conjugate))
    radicand = sp.expand(curvature**2 * surd**2)
    path = numerator / (
        sp.sqrt(radicand if square is None else square) - sp.expand(curvature * (conjugate + surd))
    )
    values = {curvature: kappa, h: addendum, alpha: angle}
    return radicand.subs(values), path.subs(values)


def contact_ratio() -> ClosedForm:
    """Return both paths of action over the base pitch, and the heights of the tips over their base
    circles.
    """
    steps: list[Let] = []
    for square, g, outside, kappa, ha in (
        (t.square1, t.g1, t.outside1, t.kappa1, t.ha1),
        (t.square2, t.g2, t.outside2, t.kappa2, t.ha2),
    ):
        radicand, path = path_by_curvature(
            kappa, ha * t.module, t.alpha0, sp.Max(square, SQUARE_MINIMUM)
        )
        steps += [
            Let(square, radicand, "derived: path of action"),
            Let(g, path, "derived: path of action"),
            Let(
                outside,
                height_over_base_circle(kappa, ha * t.module, t.alpha0),
                "derived: base circle",
            ),
        ]
    ratio = Let(
        t.epsilon, (t.g1 + t.g2) / base_pitch(pi * t.module, t.alpha0), "derived: contact ratio"
    )
    outputs = Vector("meshing", t.select("epsilon g1 g2 outside1 outside2"))
    return ClosedForm("contact_ratio", (t.kappa1, t.kappa2, TEETH), (*steps, ratio), outputs)


def build_teeth_system() -> System:
    """Build the model of rack teeth on pitch curves."""
    return System(
        "gear_teeth",
        "Rack teeth on pitch curves",
        "derived (geometry)",
        TEETH_ASSUMPTIONS,
        closed_forms=(contact_ratio(),),
    )


STRENGTH_ASSUMPTIONS = (
    "one pair of teeth bears the whole force, at the pitch point (contact) and at the tip (bending)",
    "flanks touch along the whole width of the face, evenly loaded; no dynamic, mounting or life "
    "factors",
    "contact: smooth elastic bodies without friction, touching along a strip that is narrow "
    "compared with their radii "
    "(Hertz)",
    "bending: 20 deg full-depth teeth, a static load, no stress concentration at the root (Lewis)",
)
PAPER_HERTZ = "Johnson, Contact Mechanics (1985), 4.2(c)"
PAPER_LEWIS = "Lewis (1892), form factor of 20 deg full-depth teeth: 0.154 - 0.912/z, times pi"
_strength = partial(Quantity, source="derived: strength")


LOAD = Vector("load", t.select("F b alpha0"))
MATERIAL = Vector("material", t.select("E nu"))


def tangent_inclination() -> Expr:
    """Return the angle of the pitch curves' common tangent to the perpendicular of the line of
    centres [rad].
    """
    angle = sp.Dummy("turned")
    line = Frame("line of centres", TRANSVERSE)
    point = Vec(line, (t.r + t.dr * angle, S.Zero, S.Zero)).resolved(TRANSVERSE)
    velocity = Vec(TRANSVERSE, tuple(c.diff(angle) for c in point.components)) + unit(
        TRANSVERSE, Z
    ).cross(point)
    tangent = [c.subs(angle, 0) for c in velocity.components]
    return sp.atan2(tangent[0], tangent[1])


def flank_curvature(pitch_curvature: Expr) -> Expr:
    """Return the curvature of a flank at the pitch point [1/m]: its centre is the touch point on
    the base circle.
    """
    radius = sp.Symbol("radius", positive=True)
    base_distance = line_of_action(t.alpha0).dot(Vec(TRANSVERSE, (S.Zero, radius, S.Zero)))
    return (1 / base_distance).subs(radius, 1 / pitch_curvature)


def hertz_pressure() -> tuple[Expr, Expr]:
    """Return the square of the largest pressure and half the width of the strip of two cylinders in
    line contact.

    An elliptic pressure over the strip carries the force; it deforms the surfaces by their
    difference in curvature.
    """
    x, a, top = sp.symbols("x a top", positive=True)
    load = sp.integrate(top * sp.sqrt(1 - (x / a) ** 2), (x, -a, a))
    (width,) = sp.solve(2 * top / (a * t.E_contact) - t.kappa, a)
    (squared,) = sp.solve(load.subs(a, width).subs(top, sp.sqrt(t.square)) - t.F / t.b, t.square)
    return squared, width.subs(top, t.p0)


def pressure_angles() -> ClosedForm:
    """Return the angle between the normal and the perpendicular of the line of centres, for both
    flanks of a tooth.
    """
    inclination = tangent_inclination()
    steps = tuple(
        Let(symbol, t.alpha0 + sign * inclination, "derived: pitch curve's tangent")
        for symbol, sign in ((t.towards, 1), (t.against, -1))
    )
    return ClosedForm(
        "pressure_angles",
        (t.r, t.dr, t.alpha0),
        steps,
        Vector("pressure", t.select("towards against")),
    )


def contact_stress() -> ClosedForm:
    """Return the Hertzian contact stress of two flanks at the pitch point."""
    squared, width = hertz_pressure()
    steps = (
        Let(t.E_contact, t.E / (2 * (1 - t.nu**2)), PAPER_HERTZ),
        Let(
            t.kappa,
            flank_curvature(t.kappa1) + flank_curvature(t.kappa2),
            "derived: flanks at the pitch point",
        ),
        Let(t.square, squared, PAPER_HERTZ),
        Let(t.p0, sp.sqrt(sp.Max(t.square, S.Zero)), PAPER_HERTZ),
        Let(t.half_width, width, PAPER_HERTZ),
    )
    inputs = (t.kappa1, t.kappa2, LOAD, MATERIAL)
    return ClosedForm(
        "contact_stress", inputs, steps, Vector("contact", t.select("square p0 half_width kappa"))
    )


def bending_stress() -> ClosedForm:
    """Return the bending stress by Lewis of a tooth, as on the circle that osculates its pitch
    curve.
    """
    steps = (
        Let(t.teeth_inverse, t.module * t.kappa1 / 2, "derived: osculating circle"),
        Let(t.Y, pi * (Rational(154, 1000) - Rational(912, 1000) * t.teeth_inverse), PAPER_LEWIS),
        Let(t.sigma, t.F * sp.cos(t.alpha0) / (t.b * t.module * t.Y), PAPER_LEWIS),
    )
    inputs = (t.kappa1, t.module, LOAD)
    return ClosedForm(
        "bending_stress", inputs, steps, Vector("bending", t.select("sigma Y teeth_inverse"))
    )


def build_strength_system() -> System:
    """Build the model of pressure angles and stresses of teeth."""
    forms = (pressure_angles(), contact_stress(), bending_stress())
    title = "Pressure angles and stresses of teeth on pitch curves"
    return System(
        "gear_strength", title, "derived; Hertz, Lewis", STRENGTH_ASSUMPTIONS, closed_forms=forms
    )


LOCKING_ASSUMPTIONS = (
    "locking arcs lie about the driving gear's axis while they act",
    "the tips of the driven gear on both sides of the line of centres lie on a circle about its "
    "axis",
)
q = quantities(
    """
    distance | m   | distance of the gears' axes
    tips     | m   | radius of the driven gear's tip circle near the line of centres
    friction | 1   | coefficient of friction between the arcs
    radius   | m   | radius of the locking arcs
    reach    | rad | angle at the driving gear's axis to the point where the arc leaves the driven gear's tip circle
    """,
    source="derived: locking arcs",
    section="",
)
HORN = Frame("horn's edge")
"""Its origin is the driving gear's axis, its x axis goes through the edge of a horn, where the arc
meets the tips.

The horns are what the concave arc leaves of the driven gear's teeth on both sides of the line of
centres; each of them prevents the rotation in one direction.
"""


def _add_radius(f: Formulas) -> None:
    """Add the radius at which a horn is about to slip: the force on its edge goes through the
    driven gear's axis.

    The force is the arc's normal force, outwards, with the largest possible friction. With a larger
    radius the force turns the gear back whatever the friction is.
    """
    r, tips, a = sp.symbols("r tips a", positive=True)
    force = Vec(HORN, (S.One, q.friction, S.Zero))
    to_axis = tuple(tips * c / sp.sqrt(force.dot(force)) for c in force.components)
    axis = Vec(HORN, (r + to_axis[0], *to_axis[1:]))
    radii = sp.solve(axis.dot(axis) - a**2, r)
    radius = max(radii, key=lambda root: float(root.subs({a: 3, tips: 2, q.friction: 0})))
    f.function(
        "least",
        (q.distance, q.tips, q.friction),
        let(q.radius, radius.subs({a: q.distance, tips: q.tips})),
        told="held",
    )


def _add_reach(f: Formulas) -> None:
    """Add the angle at which the arc leaves the driven gear's tip circle, from the triangle with
    both axes.

    Sines of half the angle remain exact if the angle is small.
    """
    cosine, tips = sp.Dummy("cosine"), sp.Symbol("tips", positive=True)
    triangle = q.distance**2 + q.radius**2 - 2 * q.distance * q.radius * cosine - tips**2
    (solution,) = sp.solve(triangle, cosine)
    sine_square = sp.factor((1 - solution) / 2).subs(tips, q.tips)
    f.function(
        "horn",
        (q.distance, q.radius, q.tips),
        let(q.reach, 2 * sp.asin(sp.sqrt(sine_square))),
        told="arc",
    )


def build_locking_system() -> System:
    """Build the model of the locking arcs of intermittent gears: a convex arc, and a concave one
    cut into the teeth.
    """
    title = "Locking arcs of intermittent gears"
    f = Formulas(
        "locking_arcs",
        given=q,
        title=title,
        source="derived (geometry)",
        assumptions=LOCKING_ASSUMPTIONS,
    )
    _add_radius(f)
    _add_reach(f)
    return f.system()


SYSTEMS = (build_teeth_system, build_strength_system, build_locking_system)
