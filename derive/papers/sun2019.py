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
from .mapping.quantities import *
from .mapping.subject import SUBJECT

PAPER = Paper("sun2019", "Sun and Wang 2019, Chinese patent CN107654585B", place=4)


def lost_equation(number: str, claims: Claimed) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# step 2: pose, mapping, circle
lost_equation("1a", "moving hinge in the fixed frame by the pose, X")
lost_equation("1b", "moving hinge in the fixed frame by the pose, Y")
PAPER.defines("d1", d1, Y_o, "coordinate 1 of a pose")
PAPER.defines("d2", d2, X_o, "coordinate 2 of a pose")
for name in MAPPED:
    lost_equation(str(name), f"mapping parameter {name} of a pose")
lost_equation("2a", "moving hinge in the fixed frame by the mapping parameters, X")
lost_equation("2b", "moving hinge in the fixed frame by the mapping parameters, Y")
PAPER.equation(
    "3",
    2 * a1 * X + 2 * a2 * Y + a3 - a0 * (X**2 + Y**2),
    "moving hinge on a circle about the fixed hinge",
)
lost_equation("4", "circle as a linear form")
PAPER.defines("p1", p1, -a0, f"coefficient {p1} of the linear form")
PAPER.defines("p2", p2, a0 * x, f"coefficient {p2} of the linear form")
PAPER.defines("p3", p3, a0 * y, f"coefficient {p3} of the linear form")
PAPER.defines("p4", p4, a1, f"coefficient {p4} of the linear form")
PAPER.defines("p5", p5, a2, f"coefficient {p5} of the linear form")
PAPER.defines("p6", p6, -a1 * y + a2 * x, f"coefficient {p6} of the linear form")
PAPER.defines("p7", p7, -(a1 * x + a2 * y) / 2, f"coefficient {p7} of the linear form")
PAPER.defines("p8", p8, (a3 - a0 * (x**2 + y**2)) / 4, f"coefficient {p8} of the linear form")
PAPER.equation("5", p1 * p6 + p2 * p5 - p3 * p4, "first condition on the coefficients")
PAPER.equation("6", 2 * p1 * p7 - p2 * p4 - p3 * p5, "second condition on the coefficients")

# step 2: five poses
lost_equation("A_j1", f"entry {A_j1} of the matrix")
PAPER.defines("A_j2", A_j2, Z_j1 * Z_j3 - Z_j2 * Z_j4, f"entry {A_j2} of the matrix")
PAPER.defines("A_j3", A_j3, Z_j2 * Z_j3 + Z_j1 * Z_j4, f"entry {A_j3} of the matrix")
PAPER.defines("A_j4", A_j4, Z_j1 * Z_j3 + Z_j2 * Z_j4, f"entry {A_j4} of the matrix")
PAPER.defines("A_j5", A_j5, Z_j2 * Z_j3 - Z_j1 * Z_j4, f"entry {A_j5} of the matrix")
PAPER.defines("A_j6", A_j6, Z_j3 * Z_j4, f"entry {A_j6} of the matrix")
lost_equation("A_j7", f"entry {A_j7} of the matrix")
lost_equation("A_j8", f"entry {A_j8} of the matrix")
lost_equation("A p", "row of the linear system")
PAPER.defines("zero eigenvalues", n_zero, Integer(3), "zero eigenvalues of the squared matrix")
for letter, p_k, *v_k in zip("abcdefgh", COEFFICIENTS, *BASIS, strict=True):
    PAPER.equation(
        f"7{letter}",
        p_k - (alpha * v_k[0] + beta * v_k[1] + gamma * v_k[2]),
        f"vector in the null space, {p_k}",
    )
PAPER.equation(
    "8",
    K10 * alpha**2
    + K11 * beta**2
    + K12 * alpha * beta
    + K13 * alpha * gamma
    + K14 * beta * gamma
    + K15 * gamma**2,
    "first condition on the null space",
)
PAPER.equation(
    "9",
    K20 * alpha**2
    + K21 * beta**2
    + K22 * alpha * beta
    + K23 * alpha * gamma
    + K24 * beta * gamma
    + K25 * gamma**2,
    "second condition on the null space",
)
PAPER.defines("real solutions", n_real, Integer(2), "real solutions of the two conditions")

# step 3: angle curve and total ratio
PAPER.defines("y", y_rel, theta - phi, "ordinate of the angle curve")
PAPER.equation(
    "first and last y", Abs(y_last - y_first) - 2 * pi, "ordinates of the first and last point"
)
lost_equation("i", "total ratio by the speeds")
PAPER.defines("i by slope", i, -1 / slope, "total ratio by the slope of the angle curve")

# step 5: stages and pitch curves
lost_equation("i1", f"ratio {i1} of a stage")
lost_equation("i2", f"ratio {i2} of a stage")
lost_equation("r1", f"pitch radius {r1}")
lost_equation("polar angle 1", "polar angle of the first driver")
PAPER.defines("r2", r2, a - r1, f"pitch radius {r2}")
lost_equation("polar angle 2", "polar angle of the first follower")
PAPER.defines("turn 2", turn2, 2 * pi, "turn of the first follower")
lost_equation("x_s", "split parameter")
PAPER.defines("turn 4", turn4, 2 * pi, "turn of the second follower")
lost_equation("r3", f"pitch radius {r3}")
lost_equation("polar angle 3", "polar angle of the second driver")
PAPER.defines("r4", r4, a - r3, f"pitch radius {r4}")
lost_equation("polar angle 4", "polar angle of the second follower")

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
