"""What teeth on pitch curves bear: pressure angles, contact stress by Hertz, bending stress by Lewis.

Flanks touch at the pitch point, where their radii of curvature are those of the osculating circles times the sine of
the pressure angle. One pair of teeth bears the whole force. In terms of curvatures, as `teeth`.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Rational, S, pi

from ..mechanics.frames import Frame, Vec, X, Z, unit
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector
from .teeth import alpha0, kappa1, kappa2, module

ASSUMPTIONS = (
    "one pair of teeth bears the whole force, at the pitch point (contact) and at the tip (bending)",
    "flanks touch along the whole width of the face, evenly loaded; no dynamic, mounting or life factors",
    "contact: smooth elastic bodies without friction, touching along a strip that is narrow beside their radii (Hertz)",
    "bending: 20 deg full-depth teeth, a static load, no stress concentration at the root (Lewis)",
)
SECTION = Frame("transverse section")
PAPER_HERTZ = "Johnson, Contact Mechanics (1985), 4.2(c)"
PAPER_LEWIS = "Lewis (1892), form factor of 20 deg full-depth teeth: 0.154 - 0.912/z, times pi"


def _given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: strength")


r = _given("r", "m", "pitch radius at the contact")
dr = _given("dr", "m", "slope of the pitch radius, per polar angle")
towards = _given("towards", "rad", "pressure angle of the flank that faces where the pitch radius grows to")
against = _given("against", "rad", "pressure angle of the flank that faces the other way")
F = _given("F", "N", "normal force between the teeth")
b = _given("b", "m", "width of the face")
E = _given("E", "N/m2", "Young's modulus, of both gears")
nu = _given("nu", "1", "Poisson's ratio, of both gears")
E_contact = _given(
    "E_contact", "N/m2", "modulus of the contact: 1/E_contact is the sum of (1 - nu^2)/E over both gears"
)
kappa = _given("kappa", "1/m", "relative curvature of both flanks at the pitch point")
square = _given("square", "N2/m4", "square of the largest pressure in the contact")
p0 = _given("p0", "N/m2", "largest pressure in the contact of the flanks")
half_width = _given("half_width", "m", "half of the width of the strip on which the flanks touch")
teeth_inverse = _given("teeth_inverse", "1", "one over the number of teeth of the gear whose pitch circle osculates")
Y = _given("Y", "1", "Lewis's form factor, in modules")
sigma = _given("sigma", "N/m2", "bending stress at the root of a tooth")
LOAD = Vector("load", (F, b, alpha0))
MATERIAL = Vector("material", (E, nu))


def inclination() -> Expr:
    """Angle by which the pitch curves' common tangent is off the perpendicular of the line of centres."""
    turned = sp.Dummy("turned")
    line = Frame("line of centres", SECTION)
    place = Vec(line, (r + dr * turned, S.Zero, S.Zero)).resolved(SECTION)
    swept = Vec(SECTION, tuple(c.diff(turned) for c in place.components)) + unit(SECTION, Z).cross(place)
    tangent = [c.subs(turned, 0) for c in swept.components]
    return sp.atan2(tangent[0], tangent[1])


def flank_curvature(pitch: Expr) -> Expr:
    """Curvature of a flank at the pitch point: its centre is where the line of action touches the base circle."""
    radius = sp.Symbol("radius", positive=True)
    action = unit(Frame("line of action", SECTION, Z, alpha0), X).resolved(SECTION)
    to_touch = action.dot(Vec(SECTION, (S.Zero, radius, S.Zero)))
    return (1 / to_touch).subs(radius, 1 / pitch)


def hertz() -> tuple[Expr, Expr]:
    """Square of the largest pressure, and half the width of the strip, of two cylinders along a line.

    An elliptic pressure over the strip carries the force; it bends the surfaces by as much as they differ in curvature.
    """
    x, a, top = sp.symbols("x a top", positive=True)
    carried = sp.integrate(top * sp.sqrt(1 - (x / a) ** 2), (x, -a, a))
    bent = 2 * top / (a * E_contact)
    (width,) = sp.solve(bent - kappa, a)
    (squared,) = sp.solve(carried.subs(a, width).subs(top, sp.sqrt(square)) - F / b, square)
    return squared, width.subs(top, p0)


def pressure_angles() -> ClosedForm:
    """On both flanks of a tooth, between the flank's normal and the perpendicular of the line of centres."""
    off = inclination()
    steps = tuple(Let(symbol, alpha0 + sign * off, "derived: pitch curve's tangent")
                  for symbol, sign in ((towards, 1), (against, -1)))  # fmt: skip
    return ClosedForm("pressure_angles", (r, dr, alpha0), steps, Vector("pressure", (towards, against)))


def contact_stress() -> ClosedForm:
    """Of two flanks at the pitch point."""
    squared, width = hertz()
    steps = (
        Let(E_contact, E / (2 * (1 - nu**2)), PAPER_HERTZ),
        Let(kappa, flank_curvature(kappa1) + flank_curvature(kappa2), "derived: flanks at the pitch point"),
        Let(square, squared, PAPER_HERTZ),
        Let(p0, sp.sqrt(sp.Max(square, S.Zero)), PAPER_HERTZ),
        Let(half_width, width, PAPER_HERTZ),
    )
    inputs = (kappa1, kappa2, LOAD, MATERIAL)
    return ClosedForm("contact_stress", inputs, steps, Vector("contact", (square, p0, half_width, kappa)))


def bending_stress() -> ClosedForm:
    """Of one tooth by the circle that osculates its pitch curve."""
    steps = (
        Let(teeth_inverse, module * kappa1 / 2, "derived: osculating circle"),
        Let(Y, pi * (Rational(154, 1000) - Rational(912, 1000) * teeth_inverse), PAPER_LEWIS),
        Let(sigma, F * sp.cos(alpha0) / (b * module * Y), PAPER_LEWIS),
    )
    inputs = (kappa1, module, LOAD)
    return ClosedForm("bending_stress", inputs, steps, Vector("bending", (sigma, Y, teeth_inverse)))


def exact() -> System:
    """Pressure angles and stresses of teeth."""
    return System("gear_strength", "What teeth on pitch curves bear", "derived; Hertz, Lewis", ASSUMPTIONS,
                  closed_forms=(pressure_angles(), contact_stress(), bending_stress()))  # fmt: skip


SYSTEMS = (exact,)
