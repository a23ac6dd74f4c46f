"""Quantities of the seedling pick-up and the relations that derivation and paper state (yu2023).

Frame at the sun's centre O, x right, y up, angles counter-clockwise; M1 is the intermediate axis,
O1 the planet's axis, S the tip of the needle. A knot's neighbours carry ``im1``, ``ip1`` for the
indices i - 1, i + 1.
"""

from __future__ import annotations

from enum import unique
from functools import partial

from ...equations import Claim
from ...quantity import Quantity

_PAPER = "yu2023"


def _paper(section: str, name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, f"{_PAPER} {section}", key)


_derived = partial(Quantity, source="derived: pick-up")


# cubic B-spline through the value points
i_last = _paper("2", "i_last", "1", "index of the last knot")
i_first = _paper("2", "i_first", "1", "index of the knot where the curve begins")
i_end = _paper("2", "i_end", "1", "index of the knot where the curve ends")
n = _paper("2", "n", "1", "index of the last control point")
k = _paper("2", "k", "1", "degree of the basis functions")
u = _paper("2", "u", "1", "parameter of the curve, between u_i and u_ip1")
u_im2, u_im1, u_i, u_ip1, u_ip2, u_ip3 = (
    _paper("2", f"u_{name}", "1", f"knot {where}")
    for name, where in (
        ("im2", "i - 2"),
        ("im1", "i - 1"),
        ("i", "i"),
        ("ip1", "i + 1"),
        ("ip2", "i + 2"),
        ("ip3", "i + 3"),
    )
)
Delta_im2, Delta_im1, Delta_i, Delta_ip1 = (
    _paper("2", f"Delta_{name}", "1", f"length of the knot interval that begins at knot {where}")
    for name, where in (("im2", "i - 2"), ("im1", "i - 1"), ("i", "i"), ("ip1", "i + 1"))
)
d_im1, d_i, d_ip1, d_ip2 = (
    _paper(
        "2",
        f"d_{name}",
        "m",
        f"control point, one coordinate, whose basis function peaks at knot {where}",
    )
    for name, where in (("im1", "i - 1"), ("i", "i"), ("ip1", "i + 1"), ("ip2", "i + 2"))
)
p_u = _paper("2", "p_u", "m", "point of the curve at u, one coordinate")
q_i = _paper("2", "q_i", "m", "value point at knot i, one coordinate")
a_i, b_i, c_i = (
    _paper(
        "2",
        f"{name}_i",
        "1",
        f"coefficient of the control point at knot {where} in the row of knot i",
    )
    for name, where in (("a", "i - 1"), ("b", "i"), ("c", "i + 1"))
)
e_i = _paper("2", "e_i", "m", "right side of the row of knot i, one coordinate")

# bars and carrier
L1 = _paper("3.1", "L1", "m", "distance from the sun's centre O to the planet's axis O1", "L1_mm")
L2 = _paper(
    "3.1", "L2", "m", "distance from the planet's axis O1 to the tip S, longer than L1", "L2_mm"
)
L3 = _paper("3.1", "L3", "m", "distance from O to S", "L3_mm")
L3_max = _paper("3.2", "L3_max", "m", "largest distance from O to S", "L3_max_mm")
L3_min = _paper("3.2", "L3_min", "m", "smallest distance from O to S", "L3_min_mm")
a1 = _paper("3.1", "a1", "m", "centre distance of stage 1, O to M1", "a1_mm")
a2 = _paper("3.3", "a2", "m", "centre distance of stage 2, M1 to O1", "a2_mm")
gamma = _paper(
    "3.1", "gamma", "rad", "interior angle of the triangle O-M1-O1 at M1, obtuse", "gamma_deg"
)
beta1 = _paper(
    "3.1",
    "beta1",
    "rad",
    "interior angle of that triangle at O; M1 lies counter-clockwise of O1",
    "beta1_deg",
)
U1 = _paper("3.3", "U1", "rad", "interior angle of that triangle at O1")

# angles of the cycle
phi1 = _paper(
    "3.2", "phi1", "rad", "angle at O1 from the ray to O to the ray to S, clockwise, counted on"
)
phi2 = _paper("3.4", "phi2", "rad", "rotation of the intermediate gear relative to the carrier")
phi3 = _paper(
    "3.1",
    "phi3",
    "rad",
    "rotation of the planet and its arm relative to the carrier; zero (not printed) "
    "where the arm prolongs M1-O1",
)
phi4 = _paper("3.2", "phi4", "rad", "direction of O-S from x, in (-pi, pi]")
phi5 = _paper("3.1", "phi5", "rad", "direction of O-O1 from x")
phi50 = _paper("3.1", "phi50", "rad", "phi5 at the initial position")
phi30 = _derived(
    "phi30", "rad", "phi3 at the initial position: the mounting angle of the arm on the planet"
)
phi6 = _paper("3.2", "phi6", "rad", "angle at O from the ray to S to the ray to O1, in [0, 2 pi)")
phi1_far = _paper("3.2", "phi1_far", "rad", "phi1 where the tip is farthest from O")
phi6_far = _paper("3.2", "phi6_far", "rad", "phi6 where the tip is farthest from O")
phi1_near = _paper("3.2", "phi1_near", "rad", "phi1 where the tip is nearest to O")
phi6_near = _paper("3.2", "phi6_near", "rad", "phi6 where the tip is nearest to O")
Y1 = _paper("3.1", "Y1", "rad", "direction of O-M1 from x")
W1 = _paper(
    "3.1", "W1", "rad", "direction of M1-O1 from x; a full turn more or less is the same direction"
)
Z1 = _paper(
    "3.1", "Z1", "rad", "direction of O1-S from x; a full turn more or less is the same direction"
)
dphi1 = _paper("3.2", "dphi1", "rad", "increment of phi1 that goes with dphi5")
dphi2 = _derived("dphi2", "rad", "increment of phi2 that goes with dphi5")
dphi5 = _paper("3.2", "dphi5", "rad", "increment of phi5, the carrier's")
dL3 = _derived(
    "dL3",
    "m",
    "increment of L3 that goes with dphi5; negative from the farthest to the nearest point",
)
omega = _paper(
    "3.2", "omega", "rad/s", "speed of the carrier, constant, counter-clockwise", "speed_deg_per_s"
)
phi3_dot = _derived("phi3_dot", "rad/s", "rate of phi3")

x_M1, y_M1 = (_paper("3.1", f"{axis}_M1", "m", f"intermediate axis M1, {axis}") for axis in "xy")
x_O1, y_O1 = (_paper("3.1", f"{axis}_O1", "m", f"planet's axis O1, {axis}") for axis in "xy")
x_S, y_S = (_paper("3.1", f"{axis}_S", "m", f"tip S, {axis}", f"tip_{axis}_mm") for axis in "xy")
vx_M1, vy_M1 = (_paper("3.1", f"v{axis}_M1", "m/s", f"velocity of M1, {axis}") for axis in "xy")
vx_O1, vy_O1 = (_paper("3.1", f"v{axis}_O1", "m/s", f"velocity of O1, {axis}") for axis in "xy")
vx_S, vy_S = (_paper("3.1", f"v{axis}_S", "m/s", f"velocity of S, {axis}") for axis in "xy")

# gear train
iZ = _paper(
    "3.2",
    "iZ",
    "1",
    "total ratio: turn of the sun per turn of the planet, both seen from the carrier",
)
i1 = _paper(
    "3.4",
    "i1",
    "1",
    "ratio of stage 1: turn of the sun per opposite turn of the intermediate gear, both seen "
    "from the carrier",
)
g_locked = _paper(
    "3.2", "g_locked", "1", "reciprocal of the total ratio while the locking arcs act"
)
R1 = _paper("3.4", "R1", "m", "pitch radius of the sun at the contact", "sun_radius_mm")
R2 = _paper("3.4", "R2", "m", "pitch radius of the intermediate gear at the contact")
dR1 = _derived("dR1", "m", "slope of the sun's pitch radius, per phi5")
ddR1 = _derived("ddR1", "m", "second derivative of the sun's pitch radius, per phi5")
x1, y1 = (_paper("3.4", f"{axis}1", "m", f"pitch curve of the sun, {axis}") for axis in "xy")
x2, y2 = (
    _paper("3.4", f"{axis}2", "m", f"pitch curve of the intermediate gear, {axis}") for axis in "xy"
)
rho1 = _paper(
    "4.1",
    "rho1",
    "m",
    "radius of curvature of the sun's pitch curve, positive if convex",
    "rho1_mm",
)
rho2 = _paper(
    "4.1",
    "rho2",
    "m",
    "radius of curvature of the intermediate gear's, positive if convex",
    "rho2_mm",
)

# teeth
m_n = _paper("3.3", "m_n", "m", "normal module of the helical pair", "mn_mm")
z_1 = _paper("3.3", "z_1", "1", "teeth of the helical gear on the intermediate axis", "z1")
z_2 = _paper("3.3", "z_2", "1", "teeth of the planet", "z2")
beta = _paper("3.3", "beta", "rad", "helix angle", "helix_deg")
B = _paper("3.3", "B", "m", "face width of the helical pair", "B_mm")
alpha_n = Quantity(
    "alpha_n", "rad", "normal pressure angle of the helical pair", "assumed", "alpha_n_deg"
)
ha_n = Quantity("ha_n", "1", "addendum coefficient of the helical pair", "assumed", "ha_helical")
alpha_t = _derived("alpha_t", "rad", "transverse pressure angle of the helical pair")
epsilon_h = _paper(
    "3.3", "epsilon_h", "1", "contact ratio of the helical pair", "helical_contact_ratio"
)
alpha0 = _paper(
    "4.1",
    "alpha0",
    "rad",
    "angle from the pitch curves' common tangent to the line of action",
    "alpha0_deg",
)
m = _paper("4.1", "m", "m", "module of the non-circular pair", "m_mm")
ha1 = _paper("4.1", "ha1", "1", "addendum coefficient of the sun", "ha1")
ha2 = _paper("4.1", "ha2", "1", "addendum coefficient of the intermediate gear", "ha2")
g1 = _derived("g1", "m", "path of action from the pitch point to the sun's addendum")
g2 = _derived("g2", "m", "path of action from the pitch point to the intermediate gear's addendum")
epsilon = _paper("4.1", "epsilon", "1", "contact ratio of the non-circular pair", "contact_ratio")
epsilon_ha = _paper(
    "4.1", "epsilon_ha", "1", "slope of the contact ratio as both addendum coefficients grow alike"
)
epsilon_m = _paper("4.1", "epsilon_m", "1/m", "slope of the contact ratio as the module grows")

# seedlings
theta_box = _paper(
    "1", "theta_box", "rad", "inclination of the tray box to the horizontal", "box_inclination_deg"
)
swing = _paper("1", "swing", "rad", "push angle less pick angle of the needle", "swing_deg")


@unique
class PickupClaim(Claim):
    """Relations of spline, carrier and tip, gear train, teeth."""

    # spline
    KNOT_INTERVAL = "length of a knot interval"
    KNOT_INTERVAL_BEFORE = "length of the knot interval before"
    SECOND_KNOT_INTERVAL_BEFORE = "length of the second knot interval before"
    KNOT_INTERVAL_AFTER = "length of the knot interval after"
    LAST_KNOT = "index of the last knot"
    FIRST_CURVE_KNOT = "index of the knot where the curve begins"
    LAST_CURVE_KNOT = "index of the knot where the curve ends"
    CURVE_POINT = "point of the curve"
    VALUE_POINT = "value point at a knot"
    CONTROL_BEFORE = "coefficient of the control point before"
    CONTROL_AT_KNOT = "coefficient of the control point at the knot"
    CONTROL_AFTER = "coefficient of the control point after"
    KNOT_ROW_RIGHT_SIDE = "right side of the row of a knot"
    KNOT_ROW = "row of a knot"

    # carrier, arm and tip
    DIRECTION_O_M1 = "direction of O-M1"
    DIRECTION_M1_O1 = "direction of M1-O1"
    DIRECTION_O1_S = "direction of O1-S"
    INTERIOR_ANGLE_O1 = "interior angle at O1"
    INTERIOR_ANGLE_O = "interior angle at O"
    CENTRE_DISTANCE_1 = "centre distance of stage 1"
    PLACE = "place of {}, {}"
    VELOCITY = "velocity of {}, {}"
    TIP_DISTANCE = "distance of the tip"
    TIP_DISTANCE_BY_ARM = "distance of the tip from the arm's angle"
    TIP_DISTANCE_INCREMENT = "increment of the tip's distance"
    ARM_ANGLE = "arm's angle from the tip's distance"
    ANGLE_AT_O = "angle at O from the tip's distance"
    DIRECTION_O_O1 = "direction of O-O1 from the tip's"
    ANGLE_AT_O_BY_DIRECTIONS = "angle at O from the directions"
    TIP_DIRECTION = "direction of the tip"
    TIP_DIRECTION_THIRD_QUADRANT = "direction of the tip, third quadrant"
    TIP_DIRECTION_OTHER_QUADRANTS = "direction of the tip, other quadrants"
    PLANET_ANGLE = "planet's angle from the arm's"
    PLANET_RATE = "rate of the planet's angle"
    EXTREME_ARM_ANGLE = "arm's angle, tip {}"
    EXTREME_ANGLE_AT_O = "angle at O, tip {}"
    EXTREME_DISTANCE = "distance, tip {}"
    BAR_L1 = "bar L1 from the extremes"
    BAR_L2 = "bar L2 from the extremes"
    NEEDLE_TURN = "turn of the needle from pick to push"

    # gear train
    MIDDLE_TURN = "turn of the intermediate gear"
    RATIO_1 = "ratio of stage 1"
    TOTAL_RATIO = "total ratio"
    TOTAL_RATIO_BY_STAGES = "total ratio through both stages"
    DWELL_RATIO = "reciprocal of the total ratio in the dwell"
    MIDDLE_PITCH_RADIUS = "pitch radius of the intermediate gear"
    SUN_PITCH_RADIUS = "pitch radius of the sun"
    PITCH_CURVE = "pitch curve of the {}, {}"
    CURVATURE_RADIUS = "radius of curvature of the {}"

    # teeth
    CENTRE_DISTANCE_2 = "centre distance of the helical pair"
    TRANSVERSE_PRESSURE_ANGLE = "transverse pressure angle of the helical pair"
    HELICAL_CONTACT_RATIO = "contact ratio of the helical pair"
    CONTACT_RATIO = "contact ratio of the non-circular pair"
    SUN_PATH_OF_ACTION = "path of action to the sun's addendum"
    MIDDLE_PATH_OF_ACTION = "path of action to the intermediate gear's addendum"
    ADDENDUM_SLOPE = "slope of the contact ratio per addendum coefficient"
    MODULE_SLOPE = "slope of the contact ratio per module"
    GROWS_WITH_ADDENDUM = "contact ratio grows with the addendum"
    FALLS_WITH_MODULE = "contact ratio falls with the module"
