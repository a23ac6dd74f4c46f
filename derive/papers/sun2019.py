"""Sun and Wang, patent CN107654585B (2019): equations (1)-(9) and the formulas between them, as
they stand in print.

Transcriptions only. Most displays of the source are images that are gone; where one is, nothing is
transcribed but the place where it stood.
"""

# mypy: disable-error-code="name-defined"
# A transcription speaks the vocabulary of its machine; a name that this lacks stops the import.
from __future__ import annotations

from sympy import Abs, Integer, S, pi

from ..audit.case import Case
from ..audit.paper import Paper, Reading
from ..equations import Claimed
from ..systems.mapping.quantities import *
from ..systems.mapping.subject import SUBJECT

PAPER = Paper("sun2019", "Sun and Wang 2019, Chinese patent CN107654585B", place=4)


def lost_equation(number: str, claims: Claimed) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# step 2: pose, mapping, circle
lost_equation("1a", MappingClaim.HINGE_BY_POSE.of("X"))
lost_equation("1b", MappingClaim.HINGE_BY_POSE.of("Y"))
PAPER.defines("d1", d1, Y_o, MappingClaim.POSE_COORDINATE.of("1"))
PAPER.defines("d2", d2, X_o, MappingClaim.POSE_COORDINATE.of("2"))
for name in MAPPED:
    lost_equation(str(name), MappingClaim.MAPPING_PARAMETER.of(name))
lost_equation("2a", MappingClaim.HINGE_BY_MAPPING.of("X"))
lost_equation("2b", MappingClaim.HINGE_BY_MAPPING.of("Y"))
PAPER.equation("3", 2 * a1 * X + 2 * a2 * Y + a3 - a0 * (X**2 + Y**2), MappingClaim.CIRCLE)
lost_equation("4", MappingClaim.LINEAR_FORM)
PAPER.defines("p1", p1, -a0, MappingClaim.LINEAR_COEFFICIENT.of(p1))
PAPER.defines("p2", p2, a0 * x, MappingClaim.LINEAR_COEFFICIENT.of(p2))
PAPER.defines("p3", p3, a0 * y, MappingClaim.LINEAR_COEFFICIENT.of(p3))
PAPER.defines("p4", p4, a1, MappingClaim.LINEAR_COEFFICIENT.of(p4))
PAPER.defines("p5", p5, a2, MappingClaim.LINEAR_COEFFICIENT.of(p5))
PAPER.defines("p6", p6, -a1 * y + a2 * x, MappingClaim.LINEAR_COEFFICIENT.of(p6))
PAPER.defines("p7", p7, -(a1 * x + a2 * y) / 2, MappingClaim.LINEAR_COEFFICIENT.of(p7))
PAPER.defines("p8", p8, (a3 - a0 * (x**2 + y**2)) / 4, MappingClaim.LINEAR_COEFFICIENT.of(p8))
PAPER.equation("5", p1 * p6 + p2 * p5 - p3 * p4, MappingClaim.COEFFICIENT_CONDITION.of("first"))
PAPER.equation(
    "6", 2 * p1 * p7 - p2 * p4 - p3 * p5, MappingClaim.COEFFICIENT_CONDITION.of("second")
)

# step 2: five poses
lost_equation("A_j1", MappingClaim.MATRIX_ENTRY.of(A_j1))
PAPER.defines("A_j2", A_j2, Z_j1 * Z_j3 - Z_j2 * Z_j4, MappingClaim.MATRIX_ENTRY.of(A_j2))
PAPER.defines("A_j3", A_j3, Z_j2 * Z_j3 + Z_j1 * Z_j4, MappingClaim.MATRIX_ENTRY.of(A_j3))
PAPER.defines("A_j4", A_j4, Z_j1 * Z_j3 + Z_j2 * Z_j4, MappingClaim.MATRIX_ENTRY.of(A_j4))
PAPER.defines("A_j5", A_j5, Z_j2 * Z_j3 - Z_j1 * Z_j4, MappingClaim.MATRIX_ENTRY.of(A_j5))
PAPER.defines("A_j6", A_j6, Z_j3 * Z_j4, MappingClaim.MATRIX_ENTRY.of(A_j6))
lost_equation("A_j7", MappingClaim.MATRIX_ENTRY.of(A_j7))
lost_equation("A_j8", MappingClaim.MATRIX_ENTRY.of(A_j8))
lost_equation("A p", MappingClaim.LINEAR_ROW)
PAPER.defines("zero eigenvalues", n_zero, Integer(3), MappingClaim.ZERO_EIGENVALUES)
for letter, p_k, *v_k in zip("abcdefgh", COEFFICIENTS, *BASIS, strict=True):
    PAPER.equation(
        f"7{letter}",
        p_k - (alpha * v_k[0] + beta * v_k[1] + gamma * v_k[2]),
        MappingClaim.NULL_VECTOR.of(p_k),
    )
PAPER.equation(
    "8",
    K10 * alpha**2
    + K11 * beta**2
    + K12 * alpha * beta
    + K13 * alpha * gamma
    + K14 * beta * gamma
    + K15 * gamma**2,
    MappingClaim.NULL_SPACE_CONDITION.of("first"),
)
PAPER.equation(
    "9",
    K20 * alpha**2
    + K21 * beta**2
    + K22 * alpha * beta
    + K23 * alpha * gamma
    + K24 * beta * gamma
    + K25 * gamma**2,
    MappingClaim.NULL_SPACE_CONDITION.of("second"),
)
PAPER.defines("real solutions", n_real, Integer(2), MappingClaim.REAL_SOLUTIONS)

# step 3: angle curve and total ratio
PAPER.defines("y", y_rel, theta - phi, MappingClaim.CURVE_ORDINATE)
PAPER.equation("first and last y", Abs(y_last - y_first) - 2 * pi, MappingClaim.CURVE_ENDS)
lost_equation("i", MappingClaim.TOTAL_RATIO)
PAPER.defines("i by slope", i, -1 / slope, MappingClaim.TOTAL_RATIO_BY_SLOPE)

# step 5: stages and pitch curves
lost_equation("i1", MappingClaim.STAGE_RATIO.of(i1))
lost_equation("i2", MappingClaim.STAGE_RATIO.of(i2))
lost_equation("r1", MappingClaim.PITCH_RADIUS.of(r1))
lost_equation("polar angle 1", MappingClaim.POLAR_ANGLE.of("first driver"))
PAPER.defines("r2", r2, a - r1, MappingClaim.PITCH_RADIUS.of(r2))
lost_equation("polar angle 2", MappingClaim.POLAR_ANGLE.of("first follower"))
PAPER.defines("turn 2", turn2, 2 * pi, MappingClaim.FIRST_FOLLOWER_TURN)
lost_equation("x_s", MappingClaim.SPLIT_PARAMETER)
PAPER.defines("turn 4", turn4, 2 * pi, MappingClaim.SECOND_FOLLOWER_TURN)
lost_equation("r3", MappingClaim.PITCH_RADIUS.of(r3))
lost_equation("polar angle 3", MappingClaim.POLAR_ANGLE.of("second driver"))
PAPER.defines("r4", r4, a - r3, MappingClaim.PITCH_RADIUS.of(r4))
lost_equation("polar angle 4", MappingClaim.POLAR_ANGLE.of("second follower"))

# What the paper leaves open: distances "from" an axis, or "along" it; which angle is taken from
# which.
PAPER.admits(
    ["y", "i by slope"],
    Reading(
        "the difference is the carrier's angle less the arm's",
        {y_rel: -y_rel, slope: -slope},
        because="step 3 names the carrier first",
    ),
    Reading(
        "the difference is the arm's angle less the carrier's",
        {theta: phi, phi: theta},
        because="step 3 says difference, and takes the negative reciprocal of the slope",
    ),
)
PAPER.admits(
    ["d1", "d2"],
    Reading("d1 and d2 are distances from the axes X and Y"),
    Reading(
        "d1 and d2 are distances along the axes X and Y",
        {Y_o: X_o, X_o: Y_o},
        because="step 2 says distance to an axis; the printed poses and Z values count them along "
        "it",
    ),
)

CASE = Case(PAPER, SUBJECT)
