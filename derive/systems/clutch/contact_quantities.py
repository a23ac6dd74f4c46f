"""Quantities of both clutches in contact: coordinates, what each contact does, and the data they share.

Everything is in the plane across the shafts and along their axis. The body turns with the input and slides on it; the
output shaft's end, with its hexagon, is where the body meets it.
"""

from __future__ import annotations

from sympy import Rational

from ...mechanics.impact import Impact, ImpactLaw
from ...quantity import Quantity, Vector

_SOURCE = "derived: clutch in contact"


def given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "clutch file")


def found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, _SOURCE)


COORDINATES = (
    ("x", "m", "centre of the body, x"),
    ("y", "m", "centre of the body, y"),
    ("way", "m", "way of the sleeve from its engaged place"),
    ("output", "rad", "rotation of the output shaft"),
    ("shaft_x", "m", "end of the output shaft, x"),
    ("shaft_y", "m", "end of the output shaft, y"),
    ("angle", "rad", "rotation of the input and the body"),
    ("pushed", "m", "way to which the linkage has pushed the sleeve"),
)
FREE = 6
"""The first of them are free to move; the others are prescribed."""
PLACES = Vector("places", tuple(found(*of) for of in COORDINATES))
RATES = Vector("rates", tuple(found(f"{n}_dot", f"{unit}/s", f"rate: {what}") for n, unit, what in COORDINATES))
FORCES = Vector("forces", tuple(
    found(f"on_{n}", "N" if unit == "m" else "N m", f"generalised force of the contacts along: {what}")
    for n, unit, what in COORDINATES
))  # fmt: skip
x, y, way, output, shaft_x, shaft_y, angle, pushed = PLACES
way_dot, output_dot, angle_dot, pushed_dot = (RATES.quantities[i] for i in (2, 3, 6, 7))

stiffness = given("stiffness", "N/m1.5", "stiffness K of a contact: its force is K d^1.5")
dissipation = given("dissipation", "s/m", "dissipation D of a contact: the factor of its force is 1 + D d'")
friction = given("friction", "1", "coefficient of friction of every contact")
slip_speed = given("slip_speed", "m/s", "slip below which friction fades")
least_depth = given("least_depth", "m", "depth at which the slope of a force is taken where there is no contact")
LAW = Vector("law", (stiffness, dissipation, friction, slip_speed, least_depth))
HERTZ = ImpactLaw(stiffness, Rational(3, 2), dissipation, friction, slip_speed, least_depth)

stored = found("stored", "J", "energy that the depth of the contact holds")
damped = found("damped", "W", "power lost along the normal")
rubbed = found("rubbed", "W", "power lost to friction")
CONTACT = Impact(
    gap=found("gap", "m", "signed distance, negative where surfaces overlap"),
    depth=found("overlap", "m", "depth to which surfaces overlap"),
    elastic=found("elastic", "N", "force of the depth alone"),
    closing=found("closing", "m/s", "rate of the depth"),
    normal=found("normal", "N", "normal force"),
    slip=(found("slip_1", "m/s", "slip velocity in the section"), found("slip_2", "m/s", "slip velocity across it")),
    drag=found("drag", "N s/m", "friction per slip velocity"),
    rates=RATES.quantities,
    forces=FORCES.quantities,
    stored=stored,
    damped=damped,
    rubbed=rubbed,
)

index = given("index", "1", "which of the equal ones, counted from 0")
heading = found(
    "heading", "rad", "direction of the body, or of what points from its centre, as the output shaft sees it"
)
c_x = found("c_x", "m", "centre of the body as the turning shaft sees it, x")
c_y = found("c_y", "m", "centre of the body as the turning shaft sees it, y")
normal_x = found("normal_x", "1", "slope of the distance in the centre's x: the normal off the shaft, x")
normal_y = found("normal_y", "1", "slope of the distance in the centre's y: the normal off the shaft, y")
lever = found("lever", "m", "slope of the distance in the direction")
point_x = found("point_x", "m", "point of contact as the turning shaft sees it, x")
point_y = found("point_y", "m", "point of contact as the turning shaft sees it, y")
