"""Sun and Wang, patent CN107654585B (2019): equations (1)-(9) and the formulas between them, as they stand in print.

Transcriptions only. Most displays of the source are images that are gone; where one is, nothing is transcribed but
the place where it stood.
"""

from __future__ import annotations

from sympy import Abs, Integer, S, pi

from ..audit.paper import Paper
from ..systems.mapping.quantities import *

PAPER = Paper("sun2019", "Sun and Wang 2019, Chinese patent CN107654585B")


def lost(number: str, claims: str) -> None:
    """A formula of which nothing can be read."""
    PAPER.equation(number, S.Zero, claims, "lost")


# step 2: pose, mapping, circle
lost("1a", "moving hinge in the fixed frame by the pose, X")
lost("1b", "moving hinge in the fixed frame by the pose, Y")
PAPER.defines("d1", d1, Y_o, "coordinate 1 of a pose")
PAPER.defines("d2", d2, X_o, "coordinate 2 of a pose")
for name in MAPPED:
    lost(str(name), f"mapping parameter {name} of a pose")
lost("2a", "moving hinge in the fixed frame by the mapping parameters, X")
lost("2b", "moving hinge in the fixed frame by the mapping parameters, Y")
PAPER.equation("3", 2 * a1 * X + 2 * a2 * Y + a3 - a0 * (X**2 + Y**2), "moving hinge on a circle about the fixed hinge")
lost("4", "circle as a linear form")
PAPER.defines("p1", p1, -a0, "coefficient p1 of the linear form")
PAPER.defines("p2", p2, a0 * x, "coefficient p2 of the linear form")
PAPER.defines("p3", p3, a0 * y, "coefficient p3 of the linear form")
PAPER.defines("p4", p4, a1, "coefficient p4 of the linear form")
PAPER.defines("p5", p5, a2, "coefficient p5 of the linear form")
PAPER.defines("p6", p6, -a1 * y + a2 * x, "coefficient p6 of the linear form")
PAPER.defines("p7", p7, -(a1 * x + a2 * y) / 2, "coefficient p7 of the linear form")
PAPER.defines("p8", p8, (a3 - a0 * (x**2 + y**2)) / 4, "coefficient p8 of the linear form")
PAPER.equation("5", p1 * p6 + p2 * p5 - p3 * p4, "first condition on the coefficients")
PAPER.equation("6", 2 * p1 * p7 - p2 * p4 - p3 * p5, "second condition on the coefficients")

# step 2: five poses
lost("A_j1", "entry A_j1 of the matrix")
PAPER.defines("A_j2", A_j2, Z_j1 * Z_j3 - Z_j2 * Z_j4, "entry A_j2 of the matrix")
PAPER.defines("A_j3", A_j3, Z_j2 * Z_j3 + Z_j1 * Z_j4, "entry A_j3 of the matrix")
PAPER.defines("A_j4", A_j4, Z_j1 * Z_j3 + Z_j2 * Z_j4, "entry A_j4 of the matrix")
PAPER.defines("A_j5", A_j5, Z_j2 * Z_j3 - Z_j1 * Z_j4, "entry A_j5 of the matrix")
PAPER.defines("A_j6", A_j6, Z_j3 * Z_j4, "entry A_j6 of the matrix")
lost("A_j7", "entry A_j7 of the matrix")
lost("A_j8", "entry A_j8 of the matrix")
lost("A p", "row of the linear system")
PAPER.defines("zero eigenvalues", n_zero, Integer(3), "zero eigenvalues of the squared matrix")
for letter, p_k, *v_k in zip("abcdefgh", COEFFICIENTS, *BASIS, strict=True):
    PAPER.equation(
        f"7{letter}", p_k - (alpha * v_k[0] + beta * v_k[1] + gamma * v_k[2]), f"vector in the null space, {p_k}"
    )
PAPER.equation(
    "8",
    K10 * alpha**2 + K11 * beta**2 + K12 * alpha * beta + K13 * alpha * gamma + K14 * beta * gamma + K15 * gamma**2,
    "first condition on the null space",
)
PAPER.equation(
    "9",
    K20 * alpha**2 + K21 * beta**2 + K22 * alpha * beta + K23 * alpha * gamma + K24 * beta * gamma + K25 * gamma**2,
    "second condition on the null space",
)
PAPER.defines("real solutions", n_real, Integer(2), "real solutions of the two conditions")

# step 3: angle curve and total ratio
PAPER.equation("y", Abs(y_rel) - Abs(theta - phi), "definition: ordinate of the angle curve")
PAPER.equation("first and last y", Abs(y_last - y_first) - 2 * pi, "ordinates of the first and last point")
lost("i", "total ratio by the speeds")
PAPER.defines("i by slope", i, -1 / slope, "total ratio by the slope of the angle curve")

# step 5: stages and pitch curves
lost("i1", "ratio i1 of a stage")
lost("i2", "ratio i2 of a stage")
lost("r1", "pitch radius r1")
lost("polar angle 1", "polar angle of the first driver")
PAPER.defines("r2", r2, a - r1, "pitch radius r2")
lost("polar angle 2", "polar angle of the first follower")
PAPER.defines("turn 2", turn2, 2 * pi, "turn of the first follower")
lost("x_s", "split parameter")
PAPER.defines("turn 4", turn4, 2 * pi, "turn of the second follower")
lost("r3", "pitch radius r3")
lost("polar angle 3", "polar angle of the second driver")
PAPER.defines("r4", r4, a - r3, "pitch radius r4")
lost("polar angle 4", "polar angle of the second follower")
