"""Quantities of the design by kinematic mapping and the relations that derivation and paper state
(sun2019).

Upper-case X, Y are coordinates in the fixed frame, lower-case x, y those of the moving frame, which
is fixed to the arm with its origin in the tip. A pose is the position of that origin and the
rotation of the frame.
"""

from __future__ import annotations

from enum import unique

from ...equations import Claim
from ...quantity import Quantity

_UNITS = ("1", "m", "m", "m", "m", "m2", "m2", "m2")


def _paper(name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, "sun2019", key)


def _derived(name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, "derived: kinematic mapping", key)


d1 = _paper(
    "d1", "m", "first coordinate of a pose: position of the moving origin along X", "pose.x_mm"
)
d2 = _paper(
    "d2", "m", "second coordinate of a pose: position of the moving origin along Y", "pose.y_mm"
)
phi = _paper("phi", "rad", "angle of a pose, from X to x", "pose.phi_deg")
X_o = _derived("X_o", "m", "abscissa of the moving origin: its signed distance from the Y axis")
Y_o = _derived("Y_o", "m", "ordinate of the moving origin: its signed distance from the X axis")
x = _paper("x", "m", "moving hinge in the moving frame, x", "dyad.moving_point_mm[0]")
y = _paper("y", "m", "moving hinge in the moving frame, y", "dyad.moving_point_mm[1]")
X = _paper("X", "m", "moving hinge in the fixed frame, X")
Y = _paper("Y", "m", "moving hinge in the fixed frame, Y")
MAPPED = tuple(
    _paper(f"Z{k}", unit, f"mapping parameter {k} of a pose")
    for k, unit in zip((1, 2, 3, 4), "mm11", strict=True)
)
Z1, Z2, Z3, Z4 = MAPPED
MAPPED_J = tuple(
    _paper(f"Z_j{k}", z.unit, f"{z.meaning}, the pose being number j")
    for k, z in enumerate(MAPPED, start=1)
)
Z_j1, Z_j2, Z_j3, Z_j4 = MAPPED_J

a0 = _paper("a0", "1", "coefficient of the circle: of minus X^2 + Y^2")
a1 = _paper("a1", "m", "coefficient of the circle: half of that of X")
a2 = _paper("a2", "m", "coefficient of the circle: half of that of Y")
a3 = _paper("a3", "m2", "coefficient of the circle: the term without X and Y")
X_c = _derived("X_c", "m", "fixed hinge, X", "dyad.centre_mm[0]")
Y_c = _derived("Y_c", "m", "fixed hinge, Y", "dyad.centre_mm[1]")
L1 = _paper(
    "L1", "m", "length of the carrier: distance of moving and fixed hinge", "dyad.radius_mm"
)
L2 = _paper("L2", "m", "length of the arm: distance of tip and moving hinge", "arm_length_mm")

COEFFICIENTS = tuple(
    _paper(
        f"p{k}",
        unit,
        f"coefficient {k} of the linear form; its scale and sign as its leading term has them",
    )
    for k, unit in enumerate(_UNITS, start=1)
)
p1, p2, p3, p4, p5, p6, p7, p8 = COEFFICIENTS
ENTRIES = tuple(
    _paper(f"A_j{k}", unit, f"entry {k} of row j of the matrix: what p{k} multiplies in pose j")
    for k, unit in enumerate(("m2", "m", "m", "m", "m", "1", "1", "1"), start=1)
)
A_j1, A_j2, A_j3, A_j4, A_j5, A_j6, A_j7, A_j8 = ENTRIES
BASIS = tuple(
    tuple(
        _paper(f"v_{v}{k}", unit, f"component {k} of the null vector {v}")
        for k, unit in enumerate(_UNITS, 1)
    )
    for v in ("alpha", "beta", "gamma")
)
v_alpha, v_beta, v_gamma = BASIS
PARAMETERS = tuple(
    _paper(name, "1", f"parameter of the null space: multiple of v_{name}")
    for name in ("alpha", "beta", "gamma")
)
alpha, beta, gamma = PARAMETERS
MONOMIALS = {
    0: alpha**2,
    1: beta**2,
    2: alpha * beta,
    3: alpha * gamma,
    4: beta * gamma,
    5: gamma**2,
}
"""Monomials by the second index of a coefficient K."""
K1, K2 = (
    tuple(
        _paper(
            f"K{row}{n}",
            "m2",
            f"coefficient of {monomial} in the {condition} condition on the null space",
        )
        for n, monomial in MONOMIALS.items()
    )
    for row, condition in ((1, "first"), (2, "second"))
)
K10, K11, K12, K13, K14, K15 = K1
K20, K21, K22, K23, K24, K25 = K2
n_zero = _paper(
    "n_zero", "1", "number of zero eigenvalues of the transposed matrix times the matrix"
)
n_real = _paper("n_real", "1", "number of real solutions of the two conditions on the null space")
n_pairs = _derived(
    "n_pairs", "1", "number of pairs of complex solutions of the two conditions on the null space"
)

theta = _paper("theta", "rad", "carrier angle: direction from fixed to moving hinge", "carrier_deg")
y_rel = _paper(
    "y_rel",
    "rad",
    "ordinate of the angle curve: rotation of the arm less that of the carrier",
    "relative_deg",
)
y_first = _paper("y_first", "rad", "ordinate of the first point of the angle curve")
y_last = _paper(
    "y_last",
    "rad",
    "ordinate of the last point of the angle curve, one revolution of the carrier later",
)
slope = _paper("slope", "1", "slope of the angle curve between neighbouring points")
w1 = _paper("w1", "rad/s", "angular speed of the carrier", "train.carrier_speed_rpm")
w2 = _paper("w2", "rad/s", "angular speed of the arm")
i = _paper(
    "i",
    "1",
    "total ratio: of the rates of first driver and second follower relative to the carrier",
)
i1 = _paper(
    "i1",
    "1",
    "ratio of stage 1: of the rates of driver and follower relative to the carrier, positive",
)
i2 = _paper(
    "i2",
    "1",
    "ratio of stage 2: of the rates of driver and follower relative to the carrier, positive",
)
x_s = _paper("x_s", "1", "split parameter: square root of i1/i2", "x_s")
mean_root = _derived("mean_root", "1", "mean of 1/sqrt(i) over a revolution of the carrier")
a = _paper("a", "m", "centre distance of either stage", "train.centre_distance_mm")
r1 = _paper("r1", "m", "pitch radius of the first driver")
r2 = _paper("r2", "m", "pitch radius of the first follower")
r3 = _paper("r3", "m", "pitch radius of the second driver")
r4 = _paper("r4", "m", "pitch radius of the second follower")
GEARS = ("first driver", "first follower", "second driver", "second follower")
POLAR_RATES = tuple(
    _derived(
        f"dpsi{k}",
        "1",
        f"rate of the polar angle of the {gear} at the contact, per carrier angle; positive",
    )
    for k, gear in enumerate(GEARS, start=1)
)
dpsi1, dpsi2, dpsi3, dpsi4 = POLAR_RATES
turn2 = _paper(
    "turn2",
    "rad",
    "rotation of the first follower relative to the carrier, in a revolution of the carrier",
)
turn4 = _paper(
    "turn4",
    "rad",
    "rotation of the second follower relative to the carrier, in a revolution of the carrier",
)

_NAMED = tuple(symbol for symbol in globals().values() if isinstance(symbol, Quantity))
ALL = (*_NAMED, *v_alpha, *v_beta, *v_gamma)
POSITIVE = (L1, L2, i, i1, i2, x_s, mean_root, a, r1, r2, r3, r4)
"""Quantities under roots, or in sums that must not vanish."""


@unique
class MappingClaim(Claim):
    """Relations from poses to dyads, and from the angle curve to gears."""

    # pose, mapping, circle
    HINGE_BY_POSE = "moving hinge in the fixed frame by the pose, {}"
    POSE_COORDINATE = "coordinate {} of a pose"
    MAPPING_PARAMETER = "mapping parameter {} of a pose"
    POSE_BY_MAPPING = "coordinate {} of a pose by the mapping parameters"
    HINGE_BY_MAPPING = "moving hinge in the fixed frame by the mapping parameters, {}"
    CIRCLE = "moving hinge on a circle about the fixed hinge"
    CIRCLE_COEFFICIENT = "coefficient {} of the circle"
    HINGE_BY_CIRCLE = "{} by the coefficients of the circle"
    ARM_LENGTH = "length of the arm"
    LINEAR_COEFFICIENT = "coefficient {} of the linear form"
    LINEAR_FORM = "circle as a linear form"

    # five poses
    MATRIX_ENTRY = "entry {} of the matrix"
    LINEAR_ROW = "row of the linear system"
    COEFFICIENT_CONDITION = "{} condition on the coefficients"
    ZERO_EIGENVALUES = "zero eigenvalues of the squared matrix"
    NULL_VECTOR = "vector in the null space, {}"
    CONIC_COEFFICIENT = "{} by the basis of the null space"
    NULL_SPACE_CONDITION = "{} condition on the null space"
    REAL_SOLUTIONS = "real solutions of the two conditions"

    # angle curve and ratios
    TIP_BY_ANGLES = "coordinate {} of the tip by the angles of carrier and arm"
    CURVE_ORDINATE = "ordinate of the angle curve"
    CURVE_ENDS = "ordinates of the first and last point"
    CURVE_SLOPE = "slope of the angle curve"
    TOTAL_RATIO = "total ratio by the speeds"
    TOTAL_RATIO_BY_SLOPE = "total ratio by the slope of the angle curve"
    SPLIT_PARAMETER = "split parameter"
    STAGE_RATIO = "ratio {} of a stage"

    # pitch curves
    PITCH_RADIUS = "pitch radius {}"
    POLAR_ANGLE = "polar angle of the {}"
    FIRST_FOLLOWER_TURN = "turn of the first follower"
    SECOND_FOLLOWER_TURN = "turn of the second follower"
