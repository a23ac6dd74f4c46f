"""Shi et al. 2021, doi:10.6041/j.issn.1000-1298.2021.02.006: equations (1)-(14) as they stand in
print.

Transcriptions only, misprints included; formulas and statements without a number have a short name.
Printed degrees stand as such: sines and cosines of them are not worked out.
"""

# mypy: disable-error-code="name-defined"
# A transcription speaks the vocabulary of its machine; a name that this lacks stops the import.
from __future__ import annotations

from sympy import (
    Expr,
    Function,
    Integer,
    Piecewise,
    Rational,
    acos,
    asin,
    atan,
    cos,
    pi,
    sin,
    sqrt,
    tan,
)

from ..audit.case import Case
from ..audit.paper import Paper, Reading
from ..equations import Definition
from ..model import System
from .clutch import model, motion
from .clutch.quantities import *
from .clutch.subject import SUBJECT

PAPER = Paper("shi2021", "Shi et al. 2021, doi:10.6041/j.issn.1000-1298.2021.02.006", place=2)

DEG = pi / 180
unread = PAPER.symbol("unread", "1", "denominator that cannot be read")


def at(function: type[Function], degrees: int) -> Expr:
    """A sine or cosine of printed degrees."""
    return function(degrees * DEG, evaluate=False)


# 2.1 path of a vertex
PAPER.defines("contact", e_3, Integer(0), "overlap with the third pair of sides")
PAPER.defines("1a", x_C, x_A + R * cos(theta), "vertex C from vertex A, x")
PAPER.defines("1b", y_C, y_A - R * sin(theta), "vertex C from vertex A, y")
PAPER.defines("1c", X_C, X_B + R * cos(beta), "vertex C from vertex B, X")
PAPER.defines("1d", Y_C, Y_B - R * sin(beta), "vertex C from vertex B, Y")
PAPER.defines(
    "X_C", X_C, x_C * at(cos, 60) + y_C * at(cos, 30), "coordinates of C in the turned frame, X"
)
PAPER.defines(
    "Y_C", Y_C, x_C * at(cos, 60) - y_C * at(cos, 30), "coordinates of C in the turned frame, Y"
)
PAPER.defines("beta", beta, theta + 24 * DEG, "direction of BC from that of AC")
PAPER.defines("2a", x_C, -a / 2 + R * (A1 * sin(theta) + A2 * cos(theta)), "path of C, x")
PAPER.defines("2b", y_C, sqrt(3) / 2 * a - R * sin(theta), "path of C, y")
PAPER.defines(
    "A1", A1, (2 * sqrt(3) * at(cos, 24) - 1) / 3, "coefficient of the sine in the path of C"
)
PAPER.defines("A2", A2, 2 * sqrt(3) * at(sin, 24) / 3, "coefficient of the cosine in the path of C")
PAPER.defines("a", a, R / unread, "side of the hexagon that fits the polygon's width", "lost")
PAPER.defines("centre x", x_E, -sqrt(3) * R / 6, "centre of the ellipse, x")
PAPER.defines("centre y", y_E, R / 2, "centre of the ellipse, y")
PAPER.defines("foci", y_F, -sqrt(3) * x_F, "line of the foci")
PAPER.defines("semi-major", s_1, Rational("1.12") * R, "semi-major axis of the ellipse")
PAPER.defines("semi-minor", s_2, Rational("0.43") * R, "semi-minor axis of the ellipse")
PAPER.inequality("fillet", r, "<", rho_t, "fillet that the tooth tips clear")
PAPER.defines(
    "curvature", rho_C, Rational("0.24") * R, "curvature of the path where it leaves the side"
)

PAPER.approximates("semi-major", "semi-minor", "curvature")

# 2.2 teeth
PAPER.inequality("3a", b1, ">=", sqrt(3) * a1 / (2 * at(sin, 72)), "tooth tips go round the shaft")
PAPER.inequality(
    "3b", b2, ">=", a1 - (2 * sqrt(3) / 3 - 1) * r, "tooth roots clear the shaft's corners"
)
PAPER.defines("3c", xi, 2 * asin(sqrt(3) * a1 / (2 * b1)), "angle between the faces of a tooth")
PAPER.defines("xi", xi, 144 * DEG, "angle between the faces at the least tip distance")

# 2.3 axial angle and travel
PAPER.inequality("4a", c, ">=", c_min, "travel of the sleeve")
PAPER.defines("4b", c_min, (2 * b - sqrt(3) * a) / tan(phi), "least travel of the sleeve")
PAPER.inequality("4c", (F1 - F2) * cos(phi), ">=", f, "sleeve slides along the taper")
PAPER.equation("4d", (F1 - F2) * sin(phi) - F_N, "sleeve on the taper, force across it")
PAPER.defines("b", b, sqrt(3 / (2 + 2 * at(cos, 36))) * a, "largest outline radius of the body")
PAPER.defines("f", f, mu * F_N, "friction of body and sleeve")
PAPER.defines("5a", phi, (R1 - R2) / d, "axial angle from the outline radii")
PAPER.inequality(
    "5b", (R1 - R2) / d, ">", (R1 - b2) / d, "material between tooth roots and outline"
)
PAPER.inequality("5c", atan((2 * b - sqrt(3) * a) / c), "<=", phi, "least axial angle for a travel")
PAPER.inequality("5d", phi, "<=", atan(1 / mu), "largest axial angle at which the sleeve slides")

# 2.4 control linkage
PAPER.defines(
    "6",
    theta_A,
    Piecewise((0, alpha < 90 * DEG - gamma), ((1 + 1 / k) * alpha, alpha >= 90 * DEG - gamma)),
    "rotation of the crank gear with the link",
)
PAPER.defines("k", k, r_A / r_D, Definition("gear radius ratio"))
PAPER.defines(
    "7a",
    theta_Amax,
    n * (180 * DEG * m / (2 * r_A)),
    "rotation of the crank gear for a number of teeth",
)
PAPER.defines(
    "7b",
    theta_Amax,
    acos((l_AC**2 + l_AB**2 - l_BC**2) / (2 * l_AC * l_AB))
    - acos(((l_AC + c) ** 2 + l_AB**2 - l_BC**2) / (2 * (l_AC + c) * l_AB)),
    "rotation of the crank for the travel of the sleeve",
)

# 3.1 impact
PAPER.equation("8a", F_M - N - m1 * a_l, "force on the engaging body")
PAPER.equation("8b", E * I * y_4x + rho * S * a_l - N * delta_l, "force on the output shaft")
PAPER.defines(
    "start", v_0, Delta_omega * r1, "speed of body and shaft at the start, when they move together"
)
PAPER.defines("9", y, y_max * sin(pi * x / (2 * t)), "deflection of the shaft in its mode")
PAPER.defines(
    "10",
    y,
    (Delta_omega * r1 / B1 * sin(B1 * t) - B2 / B1**2 * cos(B1 * t) + B2 / B1**2)
    * sin(pi * x / (2 * l)),
    "deflection of the shaft over time",
)
PAPER.defines("B1", B1, sqrt(pi**4 * E * I / (32 * m2 * l**3)), "circular frequency in contact")
PAPER.defines("B2", B2, F_M / m2, "acceleration by the driving force")
PAPER.defines(
    "11",
    N,
    F_M + m1 * (Delta_omega * r1 * B1 * sin(B1 * t) - B2 * cos(B1 * t)),
    "contact load over time",
)
PAPER.defines(
    "12",
    N_max,
    F_M + m1 * sqrt(pi**4 * E * I * Delta_omega**2 * r1**2 / (32 * m2 * l**3) + F_M**2 / m2**2),
    "largest contact load",
)

# 3.2 slip
PAPER.equation(
    "13a", N - (F_x * sin(theta0) + F_y * cos(theta0)), "forces on the tooth across the surface"
)
PAPER.equation(
    "13b",
    F_x * cos(theta0) + F_y * sin(theta0) - f0 - m1 * a0,
    "forces on the tooth along the surface",
)
PAPER.defines(
    "14",
    a0,
    (N * cos(theta0) - f0 * sin(theta0) - F_y) / (m1 * sin(theta0)),
    "acceleration of the slip",
)
PAPER.inequality(
    "slip", N, ">", f0 * tan(theta0) + F_x * (1 / cos(theta0)), "load at which the tooth slips"
)
PAPER.equation(
    "no slip", F_x - (N * cos(theta0) - f0 * sin(theta0)), "forces on the tooth without slip"
)

# 4 field test
PAPER.defines("Y1", Y1, S1 - S2, Definition("lag distance at engagement"))
PAPER.defines("Y2", Y2, S3 - S4, Definition("lag distance at cut-off"))
PAPER.defines("time", t_c, c / v_c, "time to switch")

# What the paper leaves open: which mass m2 is, how the bearing holds the shaft, what moves at the
# start of contact, against what rotations of the crank gear count, and whether phi is the taper's
# whole angle.
PAPER.admits(
    ["B1", "B2", "12"],
    Reading("m2 is the mass of all of the overhanging shaft"),
    Reading(
        "m2 is the modal mass of the shaft", {m2: M_1}, because="(9) takes the first mode alone"
    ),
    Reading(
        "m2 is the mass of the shaft's end, as if all of it were at the contact",
        {m2: M_1},
        because="the list below (10) calls it the mass of the cantilever's end",
    ),
)
PAPER.admits(
    ["9", "10"],
    Reading(
        "the bearing clamps the shaft",
        derived={fixity: Integer(1)},
        because="3.1 calls what overhangs a cantilever, where it names m2",
    ),
    Reading(
        "the bearing holds the shaft elastically",
        because="3.1 names a bearing and no stiffness of it",
    ),
    Reading(
        "the shaft turns freely in its bearing",
        derived={fixity: Integer(0)},
        because="3.1 puts the origin in a bearing and states no condition for the slope there",
    ),
)
PAPER.admits(
    ["start"],
    Reading(
        "the shaft's end starts with the speed at which it leaves the impact together with the body"
    ),
    Reading(
        "the shaft's end starts with the speed of the body",
        derived={rho: Integer(0)},
        because="(8) is the equation of a beam, whose end has no mass of its own: no impulse is "
        "needed to move it",
    ),
)
PAPER.admits(
    ["6", "7a", "7b"],
    Reading(
        "rotations of the crank gear count absolutely",
        {theta_Amax: (1 + k) * theta_Amax},
        because="the list below (6) names a rotation of the crank gear, and nothing that it is "
        "counted against",
    ),
    Reading(
        "rotations of the crank gear count relative to the link",
        derived={motion.gear_rate(): motion.gear_rate() - 1},
        because="(7) gives the largest of them by the angle between crank and guide, which the "
        "link carries",
    ),
)
PAPER.admits(
    ["4b", "4c", "4d", "5a", "5c", "5d"],
    Reading("phi is the inclination of the surface to the axis"),
    Reading(
        "phi is the whole angle of the taper",
        {phi: 2 * phi},
        because="2.3 says axial angle; fig. 6 is lost",
    ),
)

PAPER.shows("k", "the radii for a ratio of 0.3", r_A="14", r_D="46", k="0.3")
PAPER.shows("k", "the radii for a ratio of 0.4", r_A="17", r_D="43", k="0.4")
PAPER.shows("k", "the radii for a ratio of 0.5", r_A="20", r_D="40", k="0.5")

LACKING = frozenset({"focus of the ellipse, x", "rotation of the crank gear relative to the link"})
"""What the stages of a clutch ask for and the paper does not state."""

COMPLETION = {
    unread: sqrt(3),
    rho_t: (rho_C - PAPER.equations["curvature"].residual).xreplace({R: sqrt(3) * a1}),
}
"""What it takes to compute with the print, no reading of it: the denominator with which six sides
are touched at all times, and the printed radius of curvature for the tooth tips, whose polygon is
as wide as the shaft.
"""


def printed_equation() -> System:
    """The clutch as this paper prints it."""
    return model.build_printed_clutch(PAPER.equations, COMPLETION, LACKING)


def printed_beam() -> System:
    """The engagement as this paper prints it."""
    return model.build_printed_beam(PAPER.equations)


SYSTEMS = (printed_equation, printed_beam)
CASE = Case(PAPER, SUBJECT)
