"""Quantities of both clutches in contact: coordinates, results of a contact, and the data they
share.

All vectors are in the plane across the shafts and along their axis. The body turns with the input
and slides on it; the output shaft's end, with its hexagon, is where the body meets it.
"""

from __future__ import annotations

from functools import partial

from sympy import Rational

from ...mechanics.impact import Impact, ImpactLaw
from ...quantity import Quantity, Vector, read_quantities

datum = partial(Quantity, source="clutch file")
derived = partial(Quantity, source="derived: clutch in contact")


TABLE = read_quantities(
    """
derived: clutch in contact
x | m | centre of the body, x
y | m | centre of the body, y
way | m | displacement of the sleeve from its engaged position
output | rad | rotation of the output shaft
shaft_x | m | end of the output shaft, x
shaft_y | m | end of the output shaft, y
angle | rad | rotation of the input and the body
pushed | m | displacement to which the linkage has pushed the sleeve
x_dot | m/s | rate: centre of the body, x
y_dot | m/s | rate: centre of the body, y
way_dot | m/s | rate: displacement of the sleeve from its engaged position
output_dot | rad/s | rate: rotation of the output shaft
shaft_x_dot | m/s | rate: end of the output shaft, x
shaft_y_dot | m/s | rate: end of the output shaft, y
angle_dot | rad/s | rate: rotation of the input and the body
pushed_dot | m/s | rate: displacement to which the linkage has pushed the sleeve
on_x | N | generalised force of the contacts on: centre of the body, x
on_y | N | generalised force of the contacts on: centre of the body, y
on_way | N | generalised force of the contacts on: displacement of the sleeve from its engaged position
on_output | N m | generalised force of the contacts on: rotation of the output shaft
on_shaft_x | N | generalised force of the contacts on: end of the output shaft, x
on_shaft_y | N | generalised force of the contacts on: end of the output shaft, y
on_angle | N m | generalised force of the contacts on: rotation of the input and the body
on_pushed | N | generalised force of the contacts on: displacement to which the linkage has pushed the sleeve

clutch file
stiffness | N/m1.5 | stiffness K of a contact: its force is K d^1.5
dissipation | s/m | dissipation D of a contact: the factor of its force is 1 + D d'
friction | 1 | coefficient of friction of every contact
slip_speed | m/s | slip below which friction fades
least_depth | m | depth at which the slope of a force is evaluated without contact

derived: clutch in contact
stored | J | energy stored in the depth of the contact
damped | W | power lost along the normal
rubbed | W | power lost to friction

clutch file
index | 1 | index of one of the equal contacts, from 0

derived: clutch in contact
heading | rad | direction of the body, or of a radius of it, in the output shaft's frame
c_x | m | centre of the body in the turning shaft's frame, x
c_y | m | centre of the body in the turning shaft's frame, y
normal_x | 1 | slope of the distance in the centre's x: the normal off the shaft, x
normal_y | 1 | slope of the distance in the centre's y: the normal off the shaft, y
lever | m | slope of the distance in the direction
point_x | m | point of contact in the turning shaft's frame, x
point_y | m | point of contact in the turning shaft's frame, y

derived: clutch in contact
gap | m | signed distance, negative where surfaces overlap
overlap | m | depth to which surfaces overlap
elastic | N | force due to the depth alone
closing | m/s | rate of the depth
normal | N | normal force
slip_1 | m/s | slip velocity in the section
slip_2 | m/s | slip velocity across it
drag | N s/m | friction per slip velocity
"""
)
"""Quantities by their names, which are attributes of this module too."""
COORDINATES = TABLE.select("x y way output shaft_x shaft_y angle pushed")
FREE = 6
"""The first of them are free to move; the others are prescribed."""
PLACES = Vector("places", COORDINATES)
RATES = Vector("rates", tuple(TABLE[f"{place}_dot"] for place in PLACES))
FORCES = Vector("forces", tuple(TABLE[f"on_{place}"] for place in PLACES))
LAW = Vector("law", TABLE.select("stiffness dissipation friction slip_speed least_depth"))
HERTZ = ImpactLaw(
    TABLE.stiffness,
    Rational(3, 2),
    TABLE.dissipation,
    TABLE.friction,
    TABLE.slip_speed,
    TABLE.least_depth,
)
CONTACT = Impact(
    gap=TABLE.gap,
    depth=TABLE.overlap,
    elastic=TABLE.elastic,
    closing=TABLE.closing,
    normal=TABLE.normal,
    slip=(TABLE.slip_1, TABLE.slip_2),
    drag=TABLE.drag,
    rates=RATES.quantities,
    forces=FORCES.quantities,
    stored=TABLE.stored,
    damped=TABLE.damped,
    rubbed=TABLE.rubbed,
)


def __getattr__(name: str) -> Quantity:
    return getattr(TABLE, name)
