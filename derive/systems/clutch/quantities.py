"""Quantities of the Reuleaux-pentagon clutch and the relations between them that derivation and
paper state (shi2021).

Frame xOy: origin at the centre of the hexagonal hole, x to the right along its upper side, y up;
XOY is turned by 60 deg counter-clockwise. Vertices A and B slide on the two sides that meet at the
upper left corner, C is opposite.
"""

from __future__ import annotations

from enum import unique
from functools import partial

from ...equations import Claim
from ...quantity import Quantity


def _paper(name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, "shi2021", key)


_derived = partial(Quantity, source="derived: clutch")


# polygon in the hexagon
R = _paper("R", "m", "constant width of the polygon, diagonal of its pentagon")
a = _paper("a", "m", "side of the hexagonal hole", "sleeve.hexagon_side_mm")
theta = _paper("theta", "rad", "direction of AC below +x")
beta = _paper("beta", "rad", "direction of BC below +X")
x_A = _derived("x_A", "m", "vertex A, x")
y_A = _derived("y_A", "m", "vertex A, y")
X_B = _derived("X_B", "m", "vertex B, X")
Y_B = _derived("Y_B", "m", "vertex B, Y")
x_C = _derived("x_C", "m", "vertex C, x")
y_C = _derived("y_C", "m", "vertex C, y")
X_C = _derived("X_C", "m", "vertex C, X")
Y_C = _derived("Y_C", "m", "vertex C, Y")
A1 = _derived("A1", "1", "share of R sin(theta) in the path of C, x")
A2 = _derived("A2", "1", "share of R cos(theta) in the path of C, x")
x_E = _derived("x_E", "m", "centre of the ellipse that C describes, x")
y_E = _derived("y_E", "m", "centre of the ellipse that C describes, y")
x_F = _derived("x_F", "m", "focus of the ellipse, x")
y_F = _derived("y_F", "m", "focus of the ellipse, y")
s_1 = _derived("s_1", "m", "semi-major axis of the ellipse")
s_2 = _derived("s_2", "m", "semi-minor axis of the ellipse")
rho_C = _derived(
    "rho_C", "m", "radius of curvature of the path of C where it leaves the side of the hexagon"
)
e_3 = _derived(
    "e_3",
    "m",
    "overlap of the outline with the third pair of sides while the other two pairs are touched",
)

# teeth and output shaft
a1 = _paper("a1", "m", "edge of the hexagonal section of the output shaft")
r = _paper("r", "m", "fillet radius on the corners of the output shaft", "shaft.fillet_mm")
rho_t = _derived(
    "rho_t",
    "m",
    "radius of curvature of the tooth tips' path where it leaves the flat of the output shaft",
)
b1 = _paper("b1", "m", "distance of the tooth tips from the centroid of the body", "tooth.tip_mm")
b2 = _paper("b2", "m", "distance of the tooth roots from the centroid of the body", "tooth.root_mm")
xi = _derived("xi", "rad", "full angle between the two faces of a tooth")

# travel of the sleeve
phi = _paper(
    "phi", "rad", "inclination of the tapered contact surface to the axis", "sleeve.axial_angle_deg"
)
c = _paper("c", "m", "axial travel of the sleeve", "sleeve.travel_mm")
c_min = _derived("c_min", "m", "smallest axial travel with which the body can turn coaxially")
b = _derived("b", "m", "largest outline radius of the body: distance of a vertex from the centroid")
R1 = _paper("R1", "m", "largest outline radius of the body at the left end")
R2 = _paper(
    "R2", "m", "largest outline radius of the body at the right end", "sleeve.right_radius_mm"
)
d = _paper("d", "m", "axial length of the body", "sleeve.length_mm")
F1 = _paper("F1", "N", "engaging force", "sleeve.engaging_force_N")
F2 = _paper("F2", "N", "preload of the spring", "sleeve.spring_preload_N")
mu = _paper("mu", "1", "coefficient of friction of body and sleeve", "sleeve.friction")
F_N = _derived("F_N", "N", "normal force between body and sleeve")
f = _derived("f", "N", "friction force between body and sleeve")

# control linkage
alpha = _paper(
    "alpha", "rad", "inclination of the links of the parallel four-bar to the horizontal"
)
gamma = _paper("gamma", "rad", "mounting phase angle of the arc rack", "linkage.rack_phase_deg")
r_A = _paper("r_A", "m", "pitch radius of the crank gear", "linkage.crank_gear_radius_mm")
r_D = _paper("r_D", "m", "pitch radius of the arc rack", "linkage.rack_radius_mm")
k = _paper("k", "1", "gear radius ratio, crank gear to arc rack")
theta_A = _derived("theta_A", "rad", "rotation of the crank gear, counted in the fixed frame")
theta_AR = _derived(
    "theta_AR", "rad", "rotation of the crank gear relative to the link that carries it"
)
theta_Amax = _derived(
    "theta_Amax", "rad", "rotation of the crank gear from the start of mesh to the limit"
)
n = _derived(
    "n", "1", "teeth that the crank gear turns through from the start of mesh to the limit"
)
m = _paper("m", "m", "module of crank gear and rack", "linkage.module_mm")
l_AB = _paper("l_AB", "m", "length of the crank", "linkage.crank_mm")
l_BC = _paper("l_BC", "m", "length of the connecting rod", "linkage.rod_mm")
l_AC = _paper(
    "l_AC",
    "m",
    "distance from the crank's axis A to the sleeve's pin C when engaged",
    "linkage.distance_mm",
)

# engagement
x = _paper("x", "m", "position along the output shaft, from its bearing")
t = _paper("t", "s", "time since contact")
l = _paper("l", "m", "overhang of the output shaft: the contact is at x = l", "shaft.overhang_mm")  # noqa: E741
E = _paper("E", "N/m2", "modulus of elasticity of the output shaft", "shaft.modulus_GPa")
I = _paper("I", "m4", "second moment of area of the output shaft")  # noqa: E741
rho = _paper("rho", "kg/m3", "density of the output shaft", "shaft.density_kg_m3")
S = _paper("S", "m2", "section of the output shaft")
m1 = _paper("m1", "kg", "mass of the engaging body", "engagement.body_kg")
m2 = _paper("m2", "kg", "mass of the overhanging end of the output shaft, all of it")
F_M = _paper("F_M", "N", "driving force on the engaging body")
Delta_omega = _paper(
    "Delta_omega", "rad/s", "speed of the engaging body less that of the output shaft"
)
r1 = _paper("r1", "m", "turning radius of the contact point", "engagement.contact_radius_mm")
N = _derived("N", "N", "contact load N(t)")
N_max = _derived("N_max", "N", "largest contact load")
y = _derived("y", "m", "deflection y(x, t) of the output shaft")
y_max = _derived("y_max", "m", "deflection at the contact: the one coordinate of the mode")
y_4x = _derived("y_4x", "1/m3", "fourth derivative of the deflection along the shaft, at x")
a_x = _derived("a_x", "m/s2", "acceleration of the shaft at x")
a_l = _derived("a_l", "m/s2", "acceleration of the shaft at the contact, x = l")
fixity = _paper(
    "fixity",
    "1",
    "share k l/(k l + E I) of a bearing with the stiffness k against turning: 1 clamps",
)
v_0 = _derived("v_0", "m/s", "speed of the shaft at the contact when it begins, x = l and t = 0")
delta_l = _derived(
    "delta_l", "1/m", "Dirac's delta of x - l; where a number is needed, its part in the one mode"
)
K_1 = _derived("K_1", "N/m", "modal stiffness of the output shaft")
M_1 = _derived("M_1", "kg", "modal mass of the output shaft")
B1 = _derived("B1", "rad/s", "circular frequency of shaft and body in contact")
B2 = _derived(
    "B2", "m/s2", "acceleration that the driving force gives to shaft and body in contact"
)

# slip
theta0 = _paper(
    "theta0",
    "rad",
    "angle between the engaging surface and the slider's reaction F_x",
    "slip.angle_deg",
)
F_x = _paper(
    "F_x",
    "N",
    "reaction of the slider on the tooth that pulls it along the surface and presses it on",
)
F_y = _paper(
    "F_y",
    "N",
    "reaction of the slider at right angles to F_x, it too presses on",
    "slip.reaction_N",
)
f0 = _paper("f0", "N", "friction between tooth and shaft, against the slip", "slip.friction_N")
a0 = _derived("a0", "m/s2", "acceleration of the tooth along the surface")

# field test
Y1 = _paper("Y1", "m", "lag distance at engagement")
Y2 = _paper("Y2", "m", "lag distance at cut-off")
S1 = _paper("S1", "m", "position of the first seed along the row", "field.first_seed_mm")
S2 = _paper("S2", "m", "position at which the opener enters the soil", "field.entry_mm")
S3 = _paper("S3", "m", "position of the last seed along the row", "field.last_seed_mm")
S4 = _paper("S4", "m", "position at which the opener leaves the soil", "field.exit_mm")
t_c = _paper("t_c", "s", "time to switch")
v_c = _paper("v_c", "m/s", "mean switching speed of the sleeve", "sleeve.switching_speed_mm_s")


@unique
class ClutchClaim(Claim):
    """Relations of polygon, teeth, taper, linkage, engagement and slip."""

    # polygon in the hexagon
    C_FROM_A_X = "vertex C from vertex A, x"
    C_FROM_A_Y = "vertex C from vertex A, y"
    C_FROM_B_X = "vertex C from vertex B, X"
    C_FROM_B_Y = "vertex C from vertex B, Y"
    C_TURNED_X = "coordinates of C in the turned frame, X"
    C_TURNED_Y = "coordinates of C in the turned frame, Y"
    DIRECTION_BC = "direction of BC from that of AC"
    SIDE_OF_A = "side that A slides on"
    SIDE_OF_B = "side that B slides on"
    A_SLIDING = "vertex A while A and B slide"
    PATH_X = "path of C, x"
    PATH_Y = "path of C, y"
    PATH_SINE = "coefficient of the sine in the path of C"
    PATH_COSINE = "coefficient of the cosine in the path of C"
    HEXAGON_SIDE = "side of the hexagon that fits the polygon's width"
    ELLIPSE_CENTRE_X = "centre of the ellipse, x"
    ELLIPSE_CENTRE_Y = "centre of the ellipse, y"
    FOCUS_X = "focus of the ellipse, x"
    FOCI_LINE = "line of the foci"
    SEMI_MAJOR_AXIS = "semi-major axis of the ellipse"
    SEMI_MINOR_AXIS = "semi-minor axis of the ellipse"
    PATH_CURVATURE = "curvature of the path where it leaves the side"
    THIRD_OVERLAP = "overlap with the third pair of sides"
    TIP_PATH_CURVATURE = "curvature of the tip path where it leaves the flat"
    FILLET = "fillet that the tooth tips clear"

    # teeth
    TIP_DISTANCE = "tooth tips go round the shaft"
    ROOT_DISTANCE = "tooth roots clear the shaft's corners"
    FACE_ANGLE = "angle between the faces of a tooth"
    LEAST_TIP_FACE_ANGLE = "angle between the faces at the least tip distance"

    # travel and taper
    OUTLINE_RADIUS = "largest outline radius of the body"
    LEAST_TRAVEL = "least travel of the sleeve"
    TRAVEL = "travel of the sleeve"
    SLEEVE_SLIDES = "sleeve slides along the taper"
    SLEEVE_ACROSS = "sleeve on the taper, force across it"
    SLEEVE_FRICTION = "friction of body and sleeve"
    AXIAL_ANGLE = "axial angle from the outline radii"
    WALL = "material between tooth roots and outline"
    LEAST_AXIAL_ANGLE = "least axial angle for a travel"
    LARGEST_AXIAL_ANGLE = "largest axial angle at which the sleeve slides"

    # control linkage
    CRANK_GEAR = "rotation of the crank gear with the link"
    CRANK_GEAR_ON_LINK = "rotation of the crank gear relative to the link"
    CRANK_BY_TEETH = "rotation of the crank gear for a number of teeth"
    CRANK_BY_TRAVEL = "rotation of the crank for the travel of the sleeve"
    SWITCHING_TIME = "time to switch"

    # engagement
    BODY_FORCE = "force on the engaging body"
    SHAFT_FORCE = "force on the output shaft"
    CONTACT_SPEED = "speed of the contact point at the start"
    COMMON_SPEED = "speed of body and shaft at the start, when they move together"
    MODAL_DEFLECTION = "deflection of the shaft in its mode"
    SHAFT_DEFLECTION = "deflection of the shaft over time"
    CONTACT_DEFLECTION = "deflection at the contact over time"
    SHAFT_SECTION = "section of the shaft"
    SECOND_MOMENT = "second moment of the shaft"
    MODAL_MASS = "modal mass of the shaft"
    MODAL_STIFFNESS = "modal stiffness of the shaft"
    OVERHANG_MASS = "mass of the overhanging shaft"
    CONTACT_FREQUENCY = "circular frequency in contact"
    DRIVING_ACCELERATION = "acceleration by the driving force"
    CONTACT_ACCELERATION = "acceleration of the shaft at the contact"
    SHAFT_ACCELERATION = "acceleration of the shaft"
    FOURTH_DERIVATIVE = "fourth derivative of the deflection"
    MODAL_DELTA = "Dirac's delta in the mode"
    CONTACT_LOAD = "contact load over time"
    LARGEST_LOAD = "largest contact load"

    # slip
    TOOTH_ACROSS = "forces on the tooth across the surface"
    TOOTH_ALONG = "forces on the tooth along the surface"
    SLIP_ACCELERATION = "acceleration of the slip"
    SLIP_LOAD = "load at which the tooth slips"
    TOOTH_AT_REST = "forces on the tooth without slip"
