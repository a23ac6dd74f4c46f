"""Wang et al. 2017, doi:10.6041/j.issn.1000-1298.2017.01.006: equations (1)-(31) as they stand in
print.

Transcriptions only, misprints included. Signs, symbols and rates are the paper's; nothing here is
derived or repaired.
"""

# mypy: disable-error-code="name-defined"
# A transcription speaks the vocabulary of its machine; a name that this lacks stops the import.
from __future__ import annotations

from sympy import Piecewise, Rational, atan, cos, pi, sin, tan
from sympy import S as Number

from ..audit.case import Case
from ..audit.paper import Paper, Reading
from ..chain import Chain, Solve
from ..equations import Balance, Definition
from ..model import System
from .planting import derivation, variants
from .planting.quantities import *
from .planting.subject import SUBJECT

PAPER = Paper("wang2017", "Wang et al. 2017, doi:10.6041/j.issn.1000-1298.2017.01.006", place=1)

psi = PAPER.symbol("psi", "rad", "angle of the rocker")
F_Fz = PAPER.symbol("F_Fz", "N", "force of the spring on the inner half, z'")
J_C1y = PAPER.symbol("J_C1y", "kg m2", "moment of inertia of the rocker about the hinge")
J_C2y = PAPER.symbol("J_C2y", "kg m2", "moment of inertia of the nozzle half about the hinge")
x_CO = PAPER.symbol("x_CO", "m", "centroid of the sun, x")

F_Px2, F_Py2, x_P2, y_P2, M_T2 = (twin(s) for s in (F_Px, F_Py, x_P, y_P, M_T))
F_A1x2, F_A1y2, F_B1x2, F_B1y2, F_B1z2 = (twin(s) for s in (F_A1x, F_A1y, F_B1x, F_B1y, F_B1z))
x_A12, y_A12, x_B12, y_B12 = (twin(s) for s in (x_A1, y_A1, x_B1, y_B1))

# 2.1.1 end-face cam
PAPER.defines(
    "1",
    mu,
    atan((R_b * sin(psi + psi0) + L_AE * dpsi_ddelta) / (R_b * cos(psi + psi0))),
    "pressure angle of the cam",
)
PAPER.defines("2", F_Ex, F_E * sin(psi + psi0 - mu - mu1), "force of the cam on the roller, x'")
PAPER.defines("3", F_Ey, 0 * F_E, "force of the cam on the roller, y'")
PAPER.defines("4", F_Ez, F_E * cos(psi + psi0 - mu - mu1), "force of the cam on the roller, z'")

# 2.1.2 rocker and inner half of the nozzle
PAPER.equation(
    "5",
    F_Ax
    + F_Ex
    + m_C1 * g * sin(alpha)
    + m_C2 * g * sin(alpha)
    - m_C1
    * (
        ax_A
        - phi72_ddot * (y_C1 - y_A)
        + theta1_ddot * (z_C1 - z_A)
        - (phi72_dot**2 + theta1_dot**2) * (x_C1 - x_A)
    )
    - m_C2
    * (
        ax_A
        - phi72_ddot * (y_C2 - y_A)
        + theta1_ddot * (z_C2 - z_A)
        - (phi72_dot**2 + theta1_dot**2) * (x_C2 - x_A)
    ),
    Balance("inner half", "force", "x", "planet"),
)
PAPER.equation(
    "6",
    F_Ay
    - m_C1 * g * cos(alpha)
    - m_C2 * g * cos(alpha)
    - m_C1 * (ay_A + phi72_ddot * (x_C1 - x_A) - phi72_dot**2 * (y_C1 - y_A))
    - m_C2 * (ay_A + phi72_ddot * (x_C2 - x_A) - phi72_dot**2 * (y_C2 - y_A)),
    Balance("inner half", "force", "y", "planet"),
    "partly legible",
)
PAPER.equation(
    "7",
    -F_Az
    + F_Ez
    + F_Fz
    - m_C1 * (theta1_dot * (x_C1 - x_A) - theta1_dot**2 * (z_C1 - z_A))
    - m_C2 * (theta1_ddot * (x_C2 - x_A) - theta1_dot**2 * (z_C2 - z_A)),
    Balance("inner half", "force", "z", "planet"),
)
PAPER.equation(
    "8",
    theta1_ddot * (J_C1y + J_C2y)
    + m_C1 * ax_A * (z_C1 - z_A)
    + m_C2 * ax_A * (z_C2 - z_A)
    - F_Ex * (z_E - z_A)
    - m_C1 * g * sin(alpha) * (z_C1 - z_A)
    - m_C2 * g * sin(alpha) * (z_C2 - z_A)
    + F_Fz * (x_F - x_A)
    + F_Ez * (x_E - x_A),
    Balance("inner half", "moment", "y", "planet", "A"),
    "partly legible",
)

# coordinates below (8)
PAPER.defines(
    "theta3", theta3, theta30 + theta1, "angle of the line from the hinge to C1", "partly legible"
)
PAPER.defines(
    "theta4", theta4, theta40 + theta1, "angle of the line from the hinge to C2", "partly legible"
)
PAPER.defines(
    "x_E",
    x_E,
    x_A - L_AE * cos(psi + psi0),
    "place of the roller, x'",
    "partly legible",
)
PAPER.defines(
    "z_E",
    z_E,
    z_A + L_AE * sin(psi + psi0),
    "place of the roller, z'",
    "partly legible",
)
PAPER.defines("x_C1", x_C1, x_A + L_AC1 * cos(theta3), "place of C1, x'", "partly legible")
PAPER.defines("z_C1", z_C1, z_A - L_AC1 * sin(theta3), "place of C1, z'", "partly legible")
PAPER.defines("x_C2", x_C2, x_A + L_AC2 * cos(theta4), "place of C2, x'", "partly legible")
PAPER.defines("z_C2", z_C2, z_A - L_AC2 * sin(theta4), "place of C2, z'", "partly legible")

# 2.2.1 sun
PAPER.equation("9", F_Px2 + F_Px + F_Ox, Balance("sun", "force", "x", "frame"))
PAPER.equation("10", F_Py2 + F_Py + F_Oy - m1 * g, Balance("sun", "force", "y", "frame"))
PAPER.equation(
    "11",
    -F_Px * y_P + F_Py * x_P - F_Px2 * y_P2 + F_Py2 * x_P2 - m1 * g * x_CO + M_1,
    Balance("sun", "moment", "z", "frame", "O"),
)

# 2.2.2 middle gears
PAPER.equation(
    "12",
    -F_Px
    + F_Qx
    + F_A1x
    - m2 * (ax_A1 - phi52_ddot * (y_CA - y_A1) - (omega + phi52_dot) ** 2 * (x_CA - x_A1)),
    Balance("middle body", "force", "x", "frame"),
)
PAPER.equation(
    "13",
    -F_Py
    + F_Qy
    + F_A1y
    - m2 * g
    - m2 * (ay_A1 + phi52_ddot * (x_CA - x_A1) - (omega + phi52_dot) ** 2 * (y_CA - y_A1)),
    Balance("middle body", "force", "y", "frame"),
)
PAPER.equation(
    "14",
    M_P
    - F_Qx * r6 * sin(phi + pi / 2 + gamma)
    + F_Qy * r6 * cos(phi + pi / 2 + gamma)
    - m2 * g * (x_CA - x_A1)
    - J_56 * phi52_ddot
    - m2 * (ay_A1 * (x_CA - x_A1) - ax_A1 * (y_CA - y_A1)),
    Balance("middle body", "moment", "z", "frame", "A1"),
    "partly legible",
)
PAPER.defines(
    "15",
    F_Px,
    F_NP * cos(phi + pi / 2 + phi_P1) + F_fP * cos(phi + pi / 2 + phi_P2),
    "tooth force at P, x",
)
PAPER.defines(
    "16",
    F_Py,
    F_NP * sin(phi + pi / 2 + phi_P1) + F_fP * sin(phi + pi / 2 + phi_P2),
    "tooth force at P, y",
    "partly legible",
)
PAPER.defines(
    "P1",
    phi_P1,
    Piecewise((xi1 + pi / 9, M_P < 0), (xi1 + 8 * pi / 9, M_P > 0)),
    "direction of the normal force at P",
)
PAPER.defines(
    "P2",
    phi_P2,
    Piecewise((phi_P1 - pi / 2, M_P < 0), (phi_P1 + pi / 2, M_P > 0)),
    "direction of friction at P",
)
PAPER.defines(
    "NP",
    F_NP,
    Piecewise(
        (M_P / (r5 * cos(mu2 - xi1 + 7 * pi / 18) / cos(mu2)), M_P < 0),
        (M_P / (r5 * cos(mu2 + xi1 + 7 * pi / 18) / cos(mu2)), M_P > 0),
    ),
    "normal force at P",
)
PAPER.defines("fP", F_fP, F_NP * tan(mu2), "friction force at P")

# 2.2.3 planet, shaft and funnel
PAPER.equation(
    "17",
    F_B1x
    - F_Qx
    + F_Ax * cos(pi - alpha)
    - F_Ay * sin(pi - alpha)
    - m3 * (ax_B1 - phi72_ddot * (y_CB - y_B1) - (phi72_dot + omega) ** 2 * (x_CB - x_B1)),
    Balance("planet", "force", "x", "frame"),
)
PAPER.equation(
    "18",
    F_B1y
    - F_Qy
    - m3 * g
    + F_Ax * sin(pi - alpha)
    + F_Ay * cos(pi - alpha)
    - m3 * (ay_B1 + phi72_ddot * (x_CB - x_B1) - (phi72_dot + omega) ** 2 * (y_CB - x_B1)),
    Balance("planet", "force", "y", "frame"),
)
PAPER.equation("19", F_B1z - F_Az, Balance("planet", "force", "z", "frame"))
PAPER.equation(
    "20",
    M_Q
    - M_T
    - m3 * g * (x_CB - x_B1)
    + F_Ax * y_A
    + F_Ay * x_A
    - J_7 * phi72_ddot
    - m3 * (ay_B1 * (x_CB - x_B1) - ax_B1 * (y_CB - y_B1)),
    Balance("planet", "moment", "z", "frame", "B1"),
)
PAPER.defines(
    "21",
    F_Qx,
    F_NQ * cos(phi + pi / 2 + gamma + phi_Q1) + F_fQ * cos(phi + pi / 2 + gamma + phi_Q2),
    "tooth force at Q, x",
)
PAPER.defines(
    "22",
    F_Qy,
    F_NQ * sin(phi + pi / 2 + gamma + phi_Q1) + F_fQ * sin(phi + pi / 2 + gamma + phi_Q2),
    "tooth force at Q, y",
)
PAPER.defines("23", M_T, F_Ex * y_E, "moment of the cam force about the planet's axis")
PAPER.defines(
    "Q1",
    phi_Q1,
    Piecewise((xi2 + pi / 9, M_Q < 0), (xi2 + 8 * pi / 9, M_Q > 0)),
    "direction of the normal force at Q",
)
PAPER.defines(
    "Q2",
    phi_Q2,
    Piecewise((phi_Q1 - pi / 2, M_Q < 0), (phi_Q1 + pi / 2, M_Q > 0)),
    "direction of friction at Q",
)
PAPER.defines(
    "NQ",
    F_NQ,
    Piecewise(
        (M_Q / (r7 * cos(mu2 - xi2 + 7 * pi / 18) / cos(mu2)), M_Q < 0),
        (M_Q / (r7 * cos(mu2 + xi2 + 7 * pi / 18) / cos(mu2)), M_Q > 0),
    ),
    "normal force at Q",
)
PAPER.defines("fQ", F_fQ, F_NQ * tan(mu2), "friction force at Q")

# 2.2.4 carrier
PAPER.equation(
    "24", F_O1x - F_A1x - F_B1x - F_A1x2 - F_B1x2, Balance("carrier", "force", "x", "frame")
)
PAPER.equation(
    "25",
    F_O1y - F_A1y - F_B1y - F_A1y2 - F_B1y2 - m4 * g,
    Balance("carrier", "force", "y", "frame"),
)
PAPER.equation("26", F_O1z - F_B1z - F_B1z2, Balance("carrier", "force", "z", "frame"))
PAPER.equation(
    "27",
    -F_A1y2 * x_A12
    - F_B1y2 * x_B12
    + F_A1x2 * y_A12
    + F_B1x2 * y_B12
    - F_A1y * x_A1
    - F_B1y * x_B1
    + F_A1x * y_A1
    + F_B1x * y_B1
    + M_L
    + M_T
    + M_T2,
    Balance("carrier", "moment", "z", "frame", "O"),
)
PAPER.equation(
    "28",
    (F_A1x - F_A1x2) * y_A1
    - (F_A1y - F_A1y2) * x_A1
    + (F_B1x - F_B1x2) * y_B1
    - (F_B1y - F_B1y2) * x_B1
    + M_L
    + M_T
    + M_T2,
    Balance("carrier", "moment", "z", "frame", "O"),
)

# 3.2 objective
PAPER.defines("29", f_1, F_high - F_low, Definition("range of the support force"))
PAPER.defines("30", f_2, mean_square, Definition("variance of the support force"))
PAPER.defines("31", f_total, Rational("0.6") * f_1 + Rational("0.4") * f_2, Definition("objective"))

# What the paper says of (29) to (31) besides: Table 1, and the sentence that gives both terms their
# weights.
PAPER.shows("29", "Table 1, experiment", F_high="171.96", F_low="24.93", f_1="147.03")
PAPER.shows("29", "Table 1, theory", F_high="158.94", F_low="36.77", f_1="122.17")
for source, high, low, square in (
    ("experiment", "171.96", "24.93", "1033.23"),
    ("theory", "158.94", "36.77", "1907.32"),
):
    # No mean square about the mean exceeds the square of half the range (Popoviciu 1935).
    spread = {mean_square: (Number.Zero, ((F_high - F_low) / 2) ** 2)}
    PAPER.shows("30", f"Table 1, {source}", spread, f_2=square, F_high=high, F_low=low)
PAPER.shows(
    "31", "the weight of the range in the sentence before it", f_1="1", f_2="0", f_total="0.6"
)
PAPER.shows(
    "31", "the weight of the variance in the sentence before it", f_1="0", f_2="1", f_total="0.4"
)

# Pieces that cannot be read in the machine-read text and were completed.
PAPER.rebuilds("6", "left side", "hinge force", "both gravity terms", "sign of the first bracket")
PAPER.rebuilds(
    "8", "gravity term of C1", "spring term", "symbol of the force in the last term", "subscripts"
)
PAPER.rebuilds("14", "order of the terms between gravity and inertia")
PAPER.rebuilds("16", "subscripts, after (15)")
PAPER.rebuilds("20", "right side, zero")
PAPER.rebuilds("fP", "subscript of the left side")
PAPER.rebuilds("fQ", "subscript of the left side")
for number in ("theta3", "theta4", "x_C1", "z_C1", "x_C2", "z_C2"):
    PAPER.rebuilds(number, "pairing of the lines")
for number in ("x_E", "z_E"):
    PAPER.rebuilds(number, "pairing of the lines", "angle")

# What the paper leaves open.
PAPER.admits(
    ["x_E"],
    Reading("read as x_A less the arm times the cosine of the rocker's whole angle"),
    Reading(
        "read as x_A less the arm times the sine of theta1",
        text=x_E - (x_A - L_AE * sin(theta1)),
        because="the machine-read line below (8), whose parts are out of order",
    ),
)
PAPER.admits(
    ["z_E"],
    Reading("read as z_A plus the arm times the sine of the rocker's whole angle"),
    Reading(
        "read as z_A less the arm times the cosine of theta1",
        text=z_E - (z_A - L_AE * cos(theta1)),
        because="the machine-read line below (8), whose parts are out of order",
    ),
)
PAPER.admits(
    ["17", "18", "19", "20"],
    Reading("F_A is the hinge force of the inner half, which (5) to (7) give"),
    Reading(
        "F_A is the sum of the hinge forces of both halves",
        {F_Ax: F_Ax + F_Aox, F_Ay: F_Ay + F_Aoy, F_Az: F_Az + F_Aoz},
        because="the sentence before (17): the funnel takes the action of the inner and the outer "
        "half, known from 2.1",
    ),
)
PAPER.admits(
    ["7", "19"],
    Reading("F_Az counts along z', as F_Ax and F_Ay count along x' and y'"),
    Reading(
        "F_Az counts against z'",
        {F_Az: -F_Az},
        because="the minus before it in (7); fig. 3 is lost",
    ),
)
PAPER.admits(
    ["8"],
    Reading("two halves with an ideal coupling, driven by one cam force"),
    Reading(
        "one half with a cam force of its own",
        derived={derivation.coupling_moment(): Number.Zero},
        because="2.1.2 balances the inner half alone and does not say what drives the outer one",
    ),
)

PAPER.reads(
    {
        psi: theta1,
        F_Fz: S,
        J_C1y: I_C1[1] + m_C1 * ((x_C1 - x_A) ** 2 + (z_C1 - z_A) ** 2),
        J_C2y: I_C2[1] + m_C2 * ((x_C2 - x_A) ** 2 + (z_C2 - z_A) ** 2),
        x_CO: rho_CO * cos(beta_CO),
    }
)
"""The paper gives the moments of inertia about the hinge."""

SIDE = Chain(
    PAPER.equations,
    [
        Solve("1", mu),
        Solve("8", F_E, (("2", F_Ex), ("4", F_Ez))),
        Solve("2", F_Ex),
        Solve("4", F_Ez),
        Solve("5", F_Ax),
        Solve("7", F_Az),
        Solve("6", F_Ay),
        Solve("23", M_T),
        Solve("20", M_Q),
        Solve("Q1", phi_Q1),
        Solve("Q2", phi_Q2),
        Solve("NQ", F_NQ),
        Solve("fQ", F_fQ),
        Solve("21", F_Qx),
        Solve("22", F_Qy),
        Solve("17", F_B1x),
        Solve("18", F_B1y),
        Solve("19", F_B1z),
        Solve("14", M_P),
        Solve("P1", phi_P1),
        Solve("P2", phi_P2),
        Solve("NP", F_NP),
        Solve("fP", F_fP),
        Solve("15", F_Px),
        Solve("16", F_Py),
        Solve("12", F_A1x),
        Solve("13", F_A1y),
    ],
    PAPER.reading,
)
"""Order of solution of sections 2.1.3 and 2.2.5, one side."""

FRAME = Chain(
    PAPER.equations,
    [
        Solve("9", F_Ox),
        Solve("10", F_Oy),
        Solve("11", M_1),
        Solve("28", M_L),
        Solve("24", F_O1x),
        Solve("25", F_O1y),
        Solve("26", F_O1z),
    ],
    PAPER.reading,
)
"""Order of solution of section 2.2.5, what both sides share."""


def printed() -> System:
    """The device as this paper prints it."""
    return derivation.build_printed_system(SIDE, FRAME)


def printed_support() -> System:
    """The support force alone, as this paper prints it."""
    return variants.build_share_system(printed(), flat=False)


SYSTEMS = (printed, printed_support)
CASE = Case(PAPER, SUBJECT, (SIDE, FRAME))
