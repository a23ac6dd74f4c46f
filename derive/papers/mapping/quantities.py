"""Quantities of the design by kinematic mapping and the relations that derivation and paper state
(sun2019).

Upper-case X, Y are coordinates in the fixed frame, lower-case x, y those of the moving frame, which
is fixed to the arm with its origin in the tip. A pose is the position of that origin and the
rotation of the frame.
"""

from __future__ import annotations

from ...quantity import Quantity, read_quantities

TABLE = read_quantities(
    """
sun2019
d1 | m | first coordinate of a pose: position of the moving origin along X | pose.x_mm
d2 | m | second coordinate of a pose: position of the moving origin along Y | pose.y_mm
phi | rad | angle of a pose, from X to x | pose.phi_deg

derived: kinematic mapping
X_o | m | abscissa of the moving origin: its signed distance from the Y axis
Y_o | m | ordinate of the moving origin: its signed distance from the X axis

sun2019
x | m | moving hinge in the moving frame, x | dyad.moving_point_mm[0]
y | m | moving hinge in the moving frame, y | dyad.moving_point_mm[1]
X | m | moving hinge in the fixed frame, X
Y | m | moving hinge in the fixed frame, Y
Z1 | m | mapping parameter 1 of a pose
Z2 | m | mapping parameter 2 of a pose
Z3 | 1 | mapping parameter 3 of a pose
Z4 | 1 | mapping parameter 4 of a pose
Z_j1 | m | mapping parameter 1 of a pose, the pose being number j
Z_j2 | m | mapping parameter 2 of a pose, the pose being number j
Z_j3 | 1 | mapping parameter 3 of a pose, the pose being number j
Z_j4 | 1 | mapping parameter 4 of a pose, the pose being number j
a0 | 1 | coefficient of the circle: of minus X^2 + Y^2
a1 | m | coefficient of the circle: half of that of X
a2 | m | coefficient of the circle: half of that of Y
a3 | m2 | coefficient of the circle: the term without X and Y

derived: kinematic mapping
X_c | m | fixed hinge, X | dyad.centre_mm[0]
Y_c | m | fixed hinge, Y | dyad.centre_mm[1]

sun2019
L1 | m | length of the carrier: distance of moving and fixed hinge | dyad.radius_mm
L2 | m | length of the arm: distance of tip and moving hinge | arm_length_mm
p1 | 1 | coefficient 1 of the linear form; its scale and sign as its leading term has them
p2 | m | coefficient 2 of the linear form; its scale and sign as its leading term has them
p3 | m | coefficient 3 of the linear form; its scale and sign as its leading term has them
p4 | m | coefficient 4 of the linear form; its scale and sign as its leading term has them
p5 | m | coefficient 5 of the linear form; its scale and sign as its leading term has them
p6 | m2 | coefficient 6 of the linear form; its scale and sign as its leading term has them
p7 | m2 | coefficient 7 of the linear form; its scale and sign as its leading term has them
p8 | m2 | coefficient 8 of the linear form; its scale and sign as its leading term has them
A_j1 | m2 | entry 1 of row j of the matrix: what p1 multiplies in pose j
A_j2 | m | entry 2 of row j of the matrix: what p2 multiplies in pose j
A_j3 | m | entry 3 of row j of the matrix: what p3 multiplies in pose j
A_j4 | m | entry 4 of row j of the matrix: what p4 multiplies in pose j
A_j5 | m | entry 5 of row j of the matrix: what p5 multiplies in pose j
A_j6 | 1 | entry 6 of row j of the matrix: what p6 multiplies in pose j
A_j7 | 1 | entry 7 of row j of the matrix: what p7 multiplies in pose j
A_j8 | 1 | entry 8 of row j of the matrix: what p8 multiplies in pose j
alpha | 1 | parameter of the null space: multiple of v_alpha
beta | 1 | parameter of the null space: multiple of v_beta
gamma | 1 | parameter of the null space: multiple of v_gamma
K10 | m2 | coefficient of alpha**2 in the first condition on the null space
K11 | m2 | coefficient of beta**2 in the first condition on the null space
K12 | m2 | coefficient of alpha*beta in the first condition on the null space
K13 | m2 | coefficient of alpha*gamma in the first condition on the null space
K14 | m2 | coefficient of beta*gamma in the first condition on the null space
K15 | m2 | coefficient of gamma**2 in the first condition on the null space
K20 | m2 | coefficient of alpha**2 in the second condition on the null space
K21 | m2 | coefficient of beta**2 in the second condition on the null space
K22 | m2 | coefficient of alpha*beta in the second condition on the null space
K23 | m2 | coefficient of alpha*gamma in the second condition on the null space
K24 | m2 | coefficient of beta*gamma in the second condition on the null space
K25 | m2 | coefficient of gamma**2 in the second condition on the null space
n_zero | 1 | number of zero eigenvalues of the transposed matrix times the matrix
n_real | 1 | number of real solutions of the two conditions on the null space

derived: kinematic mapping
n_pairs | 1 | number of pairs of complex solutions of the two conditions on the null space

sun2019
theta | rad | carrier angle: direction from fixed to moving hinge | carrier_deg
y_rel | rad | ordinate of the angle curve: rotation of the arm less that of the carrier | relative_deg
y_first | rad | ordinate of the first point of the angle curve
y_last | rad | ordinate of the last point of the angle curve, one revolution of the carrier later
slope | 1 | slope of the angle curve between neighbouring points
w1 | rad/s | angular speed of the carrier | train.carrier_speed_rpm
w2 | rad/s | angular speed of the arm
i | 1 | total ratio: of the rates of first driver and second follower relative to the carrier
i1 | 1 | ratio of stage 1: of the rates of driver and follower relative to the carrier, positive
i2 | 1 | ratio of stage 2: of the rates of driver and follower relative to the carrier, positive
x_s | 1 | split parameter: square root of i1/i2 | x_s

derived: kinematic mapping
mean_root | 1 | mean of 1/sqrt(i) over a revolution of the carrier

sun2019
a | m | centre distance of either stage | train.centre_distance_mm
r1 | m | pitch radius of the first driver
r2 | m | pitch radius of the first follower
r3 | m | pitch radius of the second driver
r4 | m | pitch radius of the second follower

derived: kinematic mapping
dpsi1 | 1 | rate of the polar angle of the first driver at the contact, per carrier angle; positive
dpsi2 | 1 | rate of the polar angle of the first follower at the contact, per carrier angle; positive
dpsi3 | 1 | rate of the polar angle of the second driver at the contact, per carrier angle; positive
dpsi4 | 1 | rate of the polar angle of the second follower at the contact, per carrier angle; positive

sun2019
turn2 | rad | rotation of the first follower relative to the carrier, in a revolution of the carrier
turn4 | rad | rotation of the second follower relative to the carrier, in a revolution of the carrier

sun2019
v_alpha1 | 1 | component 1 of the null vector alpha
v_alpha2 | m | component 2 of the null vector alpha
v_alpha3 | m | component 3 of the null vector alpha
v_alpha4 | m | component 4 of the null vector alpha
v_alpha5 | m | component 5 of the null vector alpha
v_alpha6 | m2 | component 6 of the null vector alpha
v_alpha7 | m2 | component 7 of the null vector alpha
v_alpha8 | m2 | component 8 of the null vector alpha
v_beta1 | 1 | component 1 of the null vector beta
v_beta2 | m | component 2 of the null vector beta
v_beta3 | m | component 3 of the null vector beta
v_beta4 | m | component 4 of the null vector beta
v_beta5 | m | component 5 of the null vector beta
v_beta6 | m2 | component 6 of the null vector beta
v_beta7 | m2 | component 7 of the null vector beta
v_beta8 | m2 | component 8 of the null vector beta
v_gamma1 | 1 | component 1 of the null vector gamma
v_gamma2 | m | component 2 of the null vector gamma
v_gamma3 | m | component 3 of the null vector gamma
v_gamma4 | m | component 4 of the null vector gamma
v_gamma5 | m | component 5 of the null vector gamma
v_gamma6 | m2 | component 6 of the null vector gamma
v_gamma7 | m2 | component 7 of the null vector gamma
v_gamma8 | m2 | component 8 of the null vector gamma
"""
)
"""Quantities by their names, which are attributes of this module too."""
MAPPED = TABLE.select("Z1 Z2 Z3 Z4")
MAPPED_J = TABLE.select("Z_j1 Z_j2 Z_j3 Z_j4")
COEFFICIENTS = TABLE.select("p1 p2 p3 p4 p5 p6 p7 p8")
ENTRIES = TABLE.select("A_j1 A_j2 A_j3 A_j4 A_j5 A_j6 A_j7 A_j8")
PARAMETERS = TABLE.select("alpha beta gamma")
BASIS = tuple(tuple(TABLE[f"v_{parameter}{k}"] for k in range(1, 9)) for parameter in PARAMETERS)
v_alpha, v_beta, v_gamma = BASIS
_alpha, _beta, _gamma = PARAMETERS
MONOMIALS = (
    _alpha**2,
    _beta**2,
    _alpha * _beta,
    _alpha * _gamma,
    _beta * _gamma,
    _gamma**2,
)
K1 = TABLE.select("K10 K11 K12 K13 K14 K15")
K2 = TABLE.select("K20 K21 K22 K23 K24 K25")
GEARS = ("first driver", "first follower", "second driver", "second follower")
POLAR_RATES = TABLE.select("dpsi1 dpsi2 dpsi3 dpsi4")
POSITIVE = TABLE.select("L1 L2 i i1 i2 x_s mean_root a r1 r2 r3 r4")
"""Quantities that are positive in every machine."""
__all__ = [
    *TABLE,
    "BASIS",
    "COEFFICIENTS",
    "ENTRIES",
    "GEARS",
    "K1",
    "K2",
    "MAPPED",
    "MAPPED_J",
    "PARAMETERS",
    "POLAR_RATES",
    "v_alpha",
    "v_beta",
    "v_gamma",
]


def __getattr__(name: str) -> Quantity:
    return getattr(TABLE, name)
