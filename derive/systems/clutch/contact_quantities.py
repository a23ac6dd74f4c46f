"""Quantities of both clutches in contact: coordinates, results of a contact, and the data they
share.

All vectors are in the plane across the shafts and along their axis. The body turns with the input
and slides on it; the output shaft's end, with its hexagon, is where the body meets it.
"""

from __future__ import annotations

from functools import partial

from sympy import Rational

from ...mechanics.impact import Impact, ImpactLaw
from ...quantity import Quantity, Vector

datum = partial(Quantity, source="clutch file")
derived = partial(Quantity, source="derived: clutch in contact")


COORDINATES = (
    ("x", "m", "centre of the body, x"),
    ("y", "m", "centre of the body, y"),
    ("way", "m", "displacement of the sleeve from its engaged position"),
    ("output", "rad", "rotation of the output shaft"),
    ("shaft_x", "m", "end of the output shaft, x"),
    ("shaft_y", "m", "end of the output shaft, y"),
    ("angle", "rad", "rotation of the input and the body"),
    ("pushed", "m", "displacement to which the linkage has pushed the sleeve"),
)
FREE = 6
"""The first of them are free to move; the others are prescribed."""
PLACES = Vector("places", tuple(derived(*coordinate) for coordinate in COORDINATES))
RATES = Vector(
    "rates",
    tuple(derived(f"{n}_dot", f"{unit}/s", f"rate: {meaning}") for n, unit, meaning in COORDINATES),
)
FORCES = Vector(
    "forces",
    tuple(
        derived(
            f"on_{n}",
            "N" if unit == "m" else "N m",
            f"generalised force of the contacts on: {meaning}",
        )
        for n, unit, meaning in COORDINATES
    ),
)
x, y, way, output, shaft_x, shaft_y, angle, pushed = PLACES
way_dot, output_dot, angle_dot, pushed_dot = (RATES.quantities[i] for i in (2, 3, 6, 7))

stiffness = datum("stiffness", "N/m1.5", "stiffness K of a contact: its force is K d^1.5")
dissipation = datum(
    "dissipation", "s/m", "dissipation D of a contact: the factor of its force is 1 + D d'"
)
friction = datum("friction", "1", "coefficient of friction of every contact")
slip_speed = datum("slip_speed", "m/s", "slip below which friction fades")
least_depth = datum(
    "least_depth", "m", "depth at which the slope of a force is evaluated without contact"
)
LAW = Vector("law", (stiffness, dissipation, friction, slip_speed, least_depth))
HERTZ = ImpactLaw(stiffness, Rational(3, 2), dissipation, friction, slip_speed, least_depth)

stored = derived("stored", "J", "energy stored in the depth of the contact")
damped = derived("damped", "W", "power lost along the normal")
rubbed = derived("rubbed", "W", "power lost to friction")
CONTACT = Impact(
    gap=derived("gap", "m", "signed distance, negative where surfaces overlap"),
    depth=derived("overlap", "m", "depth to which surfaces overlap"),
    elastic=derived("elastic", "N", "force due to the depth alone"),
    closing=derived("closing", "m/s", "rate of the depth"),
    normal=derived("normal", "N", "normal force"),
    slip=(
        derived("slip_1", "m/s", "slip velocity in the section"),
        derived("slip_2", "m/s", "slip velocity across it"),
    ),
    drag=derived("drag", "N s/m", "friction per slip velocity"),
    rates=RATES.quantities,
    forces=FORCES.quantities,
    stored=stored,
    damped=damped,
    rubbed=rubbed,
)

index = datum("index", "1", "index of one of the equal contacts, from 0")
heading = derived(
    "heading", "rad", "direction of the body, or of a radius of it, in the output shaft's frame"
)
c_x = derived("c_x", "m", "centre of the body in the turning shaft's frame, x")
c_y = derived("c_y", "m", "centre of the body in the turning shaft's frame, y")
normal_x = derived(
    "normal_x", "1", "slope of the distance in the centre's x: the normal off the shaft, x"
)
normal_y = derived(
    "normal_y", "1", "slope of the distance in the centre's y: the normal off the shaft, y"
)
lever = derived("lever", "m", "slope of the distance in the direction")
point_x = derived("point_x", "m", "point of contact in the turning shaft's frame, x")
point_y = derived("point_y", "m", "point of contact in the turning shaft's frame, y")
