"""Yu et al. 2023, design and test of an eight-row seedling pick-up: equations (1)-(20) and the formulas between them.

Transcriptions only. Nearly all displays of the source are images that are gone; where one is, nothing is transcribed
but the place where it stood.
"""

from __future__ import annotations

from sympy import Expr, Integer, S, asin, atan, cos, pi, sin

from ..audit.paper import Paper
from ..quantity import Quantity
from ..systems.pickup.quantities import *

PAPER = Paper("yu2023", "Yu, Wang, Liu, Ye, Li, Zhao 2023, dense-planting seedling pick-up mechanism")

mu_i = PAPER.symbol("mu_i", "1", "knot i, as (3) writes it")
mu_ip1 = PAPER.symbol("mu_ip1", "1", "knot i + 1, as (3) writes it")


def lost(number: str, claims: str) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# 1 requirements
PAPER.defines("push less pick", swing, theta_box, "turn of the needle from pick to push")

# 2 path
PAPER.defines("knot vector", i_last, n + k + 1, "index of the last knot")
lost("1", "point of the curve")
PAPER.defines("range, start", i_first, Integer(3), "index of the knot where the curve begins")
PAPER.defines("range, end", i_end, n + 1, "index of the knot where the curve ends")
lost("2", "row of a knot")
lost("3a", "coefficient of the control point before")
lost("3b", "coefficient of the control point at the knot")
lost("3c", "coefficient of the control point after")
lost("3d", "right side of the row of a knot")
PAPER.defines("Delta", Delta_i, mu_ip1 - mu_i, "length of a knot interval")

# 3.1 kinematics
lost("4a", "place of M1, x")
lost("4b", "place of M1, y")
PAPER.defines("Y1", Y1, beta1 + phi50 + phi5, "direction of O-M1")
lost("5a", "place of O1, x")
lost("5b", "place of O1, y")
PAPER.defines("W1", W1, beta1 + phi50 + pi - gamma + phi5, "direction of M1-O1")
lost("6a", "place of S, x")
lost("6b", "place of S, y")
PAPER.defines("Z1", Z1, beta1 + phi50 + pi - gamma + phi5 + phi3, "direction of O1-S")
for number, point in (("7", "M1"), ("8", "O1"), ("9", "S")):
    lost(f"{number}a", f"velocity of {point}, x")
    lost(f"{number}b", f"velocity of {point}, y")

# 3.2 total ratio
lost("10", "distance of the tip")
PAPER.defines("far, phi6", phi6_far, S.Zero, "angle at O, tip farthest")
PAPER.defines("far, phi1", phi1_far, pi, "arm's angle, tip farthest")
PAPER.defines("far, L3", L3_max, L1 + L2, "distance, tip farthest")
PAPER.defines("phi6", phi6, phi5 - phi4, "angle at O from the directions")
PAPER.defines("near, phi6", phi6_near, pi, "angle at O, tip nearest")
PAPER.defines("near, phi1", phi1_near, 2 * pi, "arm's angle, tip nearest")
PAPER.defines("near, L3", L3_min, L2 - L1, "distance, tip nearest")
lost("11a", "bar L1 from the extremes")
lost("11b", "bar L2 from the extremes")
lost("12", "angle at O from the tip's distance")
lost("13", "arm's angle from the tip's distance")
PAPER.defines("phi5", phi5, phi6 + phi4, "direction of O-O1 from the tip's")
PAPER.defines("phi4, third quadrant", phi4, atan(y_S / x_S) - pi, "direction of the tip, third quadrant")
PAPER.defines("phi4, other quadrants", phi4, atan(y_S / x_S), "direction of the tip, other quadrants")
PAPER.defines("iZ", iZ, dphi5 / dphi1, "total ratio")
PAPER.defines("iZ, stages", iZ, i1, "total ratio through both stages")
PAPER.equation("iZ, locked", g_locked, "reciprocal of the total ratio in the dwell")

# 3.3 centre distances
PAPER.defines("14", a2, m_n * (z_1 + z_2) / cos(beta), "centre distance of the helical pair")
lost("15", "centre distance of stage 1")
PAPER.defines("U1", U1, pi - beta1 - gamma, "interior angle at O1")
PAPER.defines("beta1", beta1, asin(a2 * sin(gamma) / L1), "interior angle at O")

# 3.4 pitch curves
PAPER.defines("R1", R1, a1 - R2, "pitch radius of the sun")
PAPER.defines("R2", R2, a1 * i1 / (1 + i1), "pitch radius of the intermediate gear")
lost("16a", "pitch curve of the sun, x")
lost("16b", "pitch curve of the sun, y")
lost("17a", "pitch curve of the intermediate gear, x")
lost("17b", "pitch curve of the intermediate gear, y")

# 4.1 contact ratio
lost("18", "contact ratio of the non-circular pair")
lost("19", "path of action to the sun's addendum")
lost("20", "path of action to the intermediate gear's addendum")
PAPER.inequality("Fig. 9a", epsilon_ha, ">", S.Zero, "contact ratio grows with the addendum")
PAPER.inequality("Fig. 9b", epsilon_m, "<", S.Zero, "contact ratio falls with the module")

_TURNED = {phi5: phi5 - phi50}
READINGS: dict[str, dict[Quantity, Expr]] = {
    "Delta": {mu_i: u_i, mu_ip1: u_ip1},
    "Y1": _TURNED,
    "W1": _TURNED,
    "Z1": _TURNED,
}
"""By equation, what a printed symbol stands for in the named quantities where the paper leaves two meanings to it.

Beside phi50, its value at the initial position, phi5 counts from there. The knots are called u before and mu in (3).
"""
