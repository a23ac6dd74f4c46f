"""Yu et al. 2023, design and test of an eight-row seedling pick-up: equations (1)-(20) and the
formulas between them.

Transcriptions only. Nearly all displays of the source are images that are gone; where one is,
nothing is transcribed but the place where it stood.
"""

# mypy: disable-error-code="name-defined"
# A transcription speaks the vocabulary of its machine; a name that this lacks stops the import.
from __future__ import annotations

from sympy import Integer, S, asin, atan, cos, pi, sin

from ..audit.case import Case
from ..audit.paper import Paper, Reading
from ..equations import Claimed
from .pickup.quantities import *
from .pickup.subject import SUBJECT

PAPER = Paper(
    "yu2023", "Yu, Wang, Liu, Ye, Li, Zhao 2023, dense-planting seedling pick-up mechanism", place=3
)

mu_i = PAPER.symbol("mu_i", "1", "knot i, as (3) writes it")
mu_ip1 = PAPER.symbol("mu_ip1", "1", "knot i + 1, as (3) writes it")


def lost_equation(number: str, claims: Claimed) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# 1 requirements
PAPER.defines("push less pick", swing, theta_box, "turn of the needle from pick to push")

# 2 path
PAPER.defines("knot vector", i_last, n + k + 1, "index of the last knot")
lost_equation("1", "point of the curve")
PAPER.defines("range, start", i_first, Integer(3), "index of the knot where the curve begins")
PAPER.defines("range, end", i_end, n + 1, "index of the knot where the curve ends")
lost_equation("2", "row of a knot")
lost_equation("3a", "coefficient of the control point before")
lost_equation("3b", "coefficient of the control point at the knot")
lost_equation("3c", "coefficient of the control point after")
lost_equation("3d", "right side of the row of a knot")
PAPER.defines("Delta", Delta_i, mu_ip1 - mu_i, "length of a knot interval")

# 3.1 kinematics
lost_equation("4a", "place of M1, x")
lost_equation("4b", "place of M1, y")
PAPER.defines("Y1", Y1, beta1 + phi50 + phi5, "direction of O-M1")
lost_equation("5a", "place of O1, x")
lost_equation("5b", "place of O1, y")
PAPER.defines("W1", W1, beta1 + phi50 + pi - gamma + phi5, "direction of M1-O1")
lost_equation("6a", "place of S, x")
lost_equation("6b", "place of S, y")
PAPER.defines("Z1", Z1, beta1 + phi50 + pi - gamma + phi5 + phi3, "direction of O1-S")
for number, point in (("7", "M1"), ("8", "O1"), ("9", "S")):
    lost_equation(f"{number}a", f"velocity of {point}, x")
    lost_equation(f"{number}b", f"velocity of {point}, y")

# 3.2 total ratio
lost_equation("10", "distance of the tip")
PAPER.defines("far, phi6", phi6_far, S.Zero, "angle at O, tip farthest")
PAPER.defines("far, phi1", phi1_far, pi, "arm's angle, tip farthest")
PAPER.defines("far, L3", L3_max, L1 + L2, "distance, tip farthest")
PAPER.defines("phi6", phi6, phi5 - phi4, "angle at O from the directions")
PAPER.defines("near, phi6", phi6_near, pi, "angle at O, tip nearest")
PAPER.defines("near, phi1", phi1_near, 2 * pi, "arm's angle, tip nearest")
PAPER.defines("near, L3", L3_min, L2 - L1, "distance, tip nearest")
lost_equation("11a", "bar L1 from the extremes")
lost_equation("11b", "bar L2 from the extremes")
lost_equation("12", "angle at O from the tip's distance")
lost_equation("13", "arm's angle from the tip's distance")
PAPER.defines("phi5", phi5, phi6 + phi4, "direction of O-O1 from the tip's")
PAPER.defines(
    "phi4, third quadrant", phi4, atan(y_S / x_S) - pi, "direction of the tip, third quadrant"
)
PAPER.defines(
    "phi4, other quadrants", phi4, atan(y_S / x_S), "direction of the tip, other quadrants"
)
PAPER.defines("iZ", iZ, dphi5 / dphi1, "total ratio")
PAPER.defines("iZ, stages", iZ, i1, "total ratio through both stages")
PAPER.equation("iZ, locked", g_locked, "reciprocal of the total ratio in the dwell")

# 3.3 centre distances
PAPER.defines("14", a2, m_n * (z_1 + z_2) / cos(beta), "centre distance of the helical pair")
lost_equation("15", "centre distance of stage 1")
PAPER.defines("U1", U1, pi - beta1 - gamma, "interior angle at O1")
PAPER.defines("beta1", beta1, asin(a2 * sin(gamma) / L1), "interior angle at O")

# 3.4 pitch curves
PAPER.defines("R1", R1, a1 - R2, "pitch radius of the sun")
PAPER.defines("R2", R2, a1 * i1 / (1 + i1), "pitch radius of the intermediate gear")
lost_equation("16a", "pitch curve of the sun, x")
lost_equation("16b", "pitch curve of the sun, y")
lost_equation("17a", "pitch curve of the intermediate gear, x")
lost_equation("17b", "pitch curve of the intermediate gear, y")

# 4.1 contact ratio
lost_equation("18", "contact ratio of the non-circular pair")
lost_equation("19", "path of action to the sun's addendum")
lost_equation("20", "path of action to the intermediate gear's addendum")
PAPER.inequality("Fig. 9a", epsilon_ha, ">", S.Zero, "contact ratio grows with the addendum")
PAPER.inequality("Fig. 9b", epsilon_m, "<", S.Zero, "contact ratio falls with the module")

# 3.3: L1 and L2, which do not change with the path, are computed "from (5), (6)".
PAPER.refers((L1, L2), "5a", "5b", "6a", "6b")

# The knots are called u before and mu in (3).
PAPER.reads({mu_i: u_i, mu_ip1: u_ip1}, "Delta")

# What the paper leaves open: from where phi5 and phi3 count.
PAPER.admits(
    ["Y1", "W1", "Z1"],
    Reading(
        "phi5 counts from the initial position",
        {phi5: phi5 - phi50},
        because="phi50 is added to it",
    ),
    Reading("phi5 is the direction of OO1", because="phi5 = phi6 + phi4 in 3.2"),
)
PAPER.admits(
    ["Z1"],
    Reading("phi3 is the angle of the arm"),
    Reading("phi3 counts from the initial position", {phi3: phi3 - phi30}, because="as phi5 does"),
)

CASE = Case(PAPER, SUBJECT)
