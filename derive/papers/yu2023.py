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
from ..systems.pickup.quantities import *
from ..systems.pickup.subject import SUBJECT

PAPER = Paper(
    "yu2023", "Yu, Wang, Liu, Ye, Li, Zhao 2023, dense-planting seedling pick-up mechanism", place=3
)

mu_i = PAPER.symbol("mu_i", "1", "knot i, as (3) writes it")
mu_ip1 = PAPER.symbol("mu_ip1", "1", "knot i + 1, as (3) writes it")


def lost_equation(number: str, claims: Claimed) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# 1 requirements
PAPER.defines("push less pick", swing, theta_box, PickupClaim.NEEDLE_TURN)

# 2 path
PAPER.defines("knot vector", i_last, n + k + 1, PickupClaim.LAST_KNOT)
lost_equation("1", PickupClaim.CURVE_POINT)
PAPER.defines("range, start", i_first, Integer(3), PickupClaim.FIRST_CURVE_KNOT)
PAPER.defines("range, end", i_end, n + 1, PickupClaim.LAST_CURVE_KNOT)
lost_equation("2", PickupClaim.KNOT_ROW)
lost_equation("3a", PickupClaim.CONTROL_BEFORE)
lost_equation("3b", PickupClaim.CONTROL_AT_KNOT)
lost_equation("3c", PickupClaim.CONTROL_AFTER)
lost_equation("3d", PickupClaim.KNOT_ROW_RIGHT_SIDE)
PAPER.defines("Delta", Delta_i, mu_ip1 - mu_i, PickupClaim.KNOT_INTERVAL)

# 3.1 kinematics
lost_equation("4a", PickupClaim.PLACE.of("M1", "x"))
lost_equation("4b", PickupClaim.PLACE.of("M1", "y"))
PAPER.defines("Y1", Y1, beta1 + phi50 + phi5, PickupClaim.DIRECTION_O_M1)
lost_equation("5a", PickupClaim.PLACE.of("O1", "x"))
lost_equation("5b", PickupClaim.PLACE.of("O1", "y"))
PAPER.defines("W1", W1, beta1 + phi50 + pi - gamma + phi5, PickupClaim.DIRECTION_M1_O1)
lost_equation("6a", PickupClaim.PLACE.of("S", "x"))
lost_equation("6b", PickupClaim.PLACE.of("S", "y"))
PAPER.defines("Z1", Z1, beta1 + phi50 + pi - gamma + phi5 + phi3, PickupClaim.DIRECTION_O1_S)
for number, point in (("7", "M1"), ("8", "O1"), ("9", "S")):
    lost_equation(f"{number}a", PickupClaim.VELOCITY.of(point, "x"))
    lost_equation(f"{number}b", PickupClaim.VELOCITY.of(point, "y"))

# 3.2 total ratio
lost_equation("10", PickupClaim.TIP_DISTANCE)
PAPER.defines("far, phi6", phi6_far, S.Zero, PickupClaim.EXTREME_ANGLE_AT_O.of("farthest"))
PAPER.defines("far, phi1", phi1_far, pi, PickupClaim.EXTREME_ARM_ANGLE.of("farthest"))
PAPER.defines("far, L3", L3_max, L1 + L2, PickupClaim.EXTREME_DISTANCE.of("farthest"))
PAPER.defines("phi6", phi6, phi5 - phi4, PickupClaim.ANGLE_AT_O_BY_DIRECTIONS)
PAPER.defines("near, phi6", phi6_near, pi, PickupClaim.EXTREME_ANGLE_AT_O.of("nearest"))
PAPER.defines("near, phi1", phi1_near, 2 * pi, PickupClaim.EXTREME_ARM_ANGLE.of("nearest"))
PAPER.defines("near, L3", L3_min, L2 - L1, PickupClaim.EXTREME_DISTANCE.of("nearest"))
lost_equation("11a", PickupClaim.BAR_L1)
lost_equation("11b", PickupClaim.BAR_L2)
lost_equation("12", PickupClaim.ANGLE_AT_O)
lost_equation("13", PickupClaim.ARM_ANGLE)
PAPER.defines("phi5", phi5, phi6 + phi4, PickupClaim.DIRECTION_O_O1)
PAPER.defines(
    "phi4, third quadrant", phi4, atan(y_S / x_S) - pi, PickupClaim.TIP_DIRECTION_THIRD_QUADRANT
)
PAPER.defines(
    "phi4, other quadrants", phi4, atan(y_S / x_S), PickupClaim.TIP_DIRECTION_OTHER_QUADRANTS
)
PAPER.defines("iZ", iZ, dphi5 / dphi1, PickupClaim.TOTAL_RATIO)
PAPER.defines("iZ, stages", iZ, i1, PickupClaim.TOTAL_RATIO_BY_STAGES)
PAPER.equation("iZ, locked", g_locked, PickupClaim.DWELL_RATIO)

# 3.3 centre distances
PAPER.defines("14", a2, m_n * (z_1 + z_2) / cos(beta), PickupClaim.CENTRE_DISTANCE_2)
lost_equation("15", PickupClaim.CENTRE_DISTANCE_1)
PAPER.defines("U1", U1, pi - beta1 - gamma, PickupClaim.INTERIOR_ANGLE_O1)
PAPER.defines("beta1", beta1, asin(a2 * sin(gamma) / L1), PickupClaim.INTERIOR_ANGLE_O)

# 3.4 pitch curves
PAPER.defines("R1", R1, a1 - R2, PickupClaim.SUN_PITCH_RADIUS)
PAPER.defines("R2", R2, a1 * i1 / (1 + i1), PickupClaim.MIDDLE_PITCH_RADIUS)
lost_equation("16a", PickupClaim.PITCH_CURVE.of("sun", "x"))
lost_equation("16b", PickupClaim.PITCH_CURVE.of("sun", "y"))
lost_equation("17a", PickupClaim.PITCH_CURVE.of("intermediate gear", "x"))
lost_equation("17b", PickupClaim.PITCH_CURVE.of("intermediate gear", "y"))

# 4.1 contact ratio
lost_equation("18", PickupClaim.CONTACT_RATIO)
lost_equation("19", PickupClaim.SUN_PATH_OF_ACTION)
lost_equation("20", PickupClaim.MIDDLE_PATH_OF_ACTION)
PAPER.inequality("Fig. 9a", epsilon_ha, ">", S.Zero, PickupClaim.GROWS_WITH_ADDENDUM)
PAPER.inequality("Fig. 9b", epsilon_m, "<", S.Zero, PickupClaim.FALLS_WITH_MODULE)

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
