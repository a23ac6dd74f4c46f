"""Quantities of the planting device and the relations that derivation and paper state (wang2017).

Points A, C1, C2, E, F carry coordinates of the planet frame x'y'z', relative to B1 (or to the hinge
A, if the name ends in that of A); points A1, B1, CA, CB, P, Q carry global ones.
"""

from __future__ import annotations

from enum import unique

from ...equations import Claim
from ...quantity import OpenVector, Quantity, Vector

_PAPER = "wang2017"


def _paper(name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, _PAPER, key)


def _triple(name: str, unit: str, meaning: str, key: str) -> tuple[Quantity, Quantity, Quantity]:
    x, y, z = (
        _paper(name.format(a), unit, meaning.format(a), f"{key}[{i}]") for i, a in enumerate("xyz")
    )
    return x, y, z


def _interval(name: str, meaning: str, key: str) -> tuple[Quantity, Quantity]:
    start = _paper(f"{name}0", "rad", f"start of the {meaning}", f"{key}[0]")
    return start, _paper(f"{name}1", "rad", f"end of the {meaning}", f"{key}[1]")


def _kinematic(name: str, unit: str, meaning: str, key: str = "") -> Quantity:
    return Quantity(name, unit, meaning, "derived: kinematics", key)


phi = Quantity("phi", "rad", "carrier angle", _PAPER, shown="phi_deg")

theta = Quantity(
    "theta", "rad", "initial mounting angle of the nozzle", "wang2017 3.4", shown="theta_deg"
)
gamma = Quantity(
    "gamma", "rad", "angle between the two centre lines", "wang2017 3.4", shown="gamma_deg"
)
alpha3 = Quantity("alpha3", "rad", "initial phase of the sun", "wang2017 3.4", shown="alpha3_deg")
beta6 = Quantity("beta6", "rad", "initial phase of gear 6", "wang2017 3.4", shown="beta6_deg")
MOUNTING = Vector("mounting", (theta, gamma, alpha3, beta6))

omega = _paper("omega", "rad/s", "carrier speed, constant", "operation.speed_rpm")
g = _paper("g", "m/s2", "gravity", "operation.gravity_m_s2")
v_f = _paper("v_f", "m/s", "forward speed of the machine", "operation.forward_speed_m_s")
alpha_n = _paper("alpha_n", "rad", "pressure angle of the teeth", "contact.pressure_angle_deg")
mu1 = _paper("mu1", "rad", "friction angle of cam and roller", "contact.cam_friction_angle_deg")
mu2 = _paper("mu2", "rad", "friction angle of the teeth", "contact.tooth_friction_angle_deg")
m1 = _paper("m1", "kg", "mass of the sun", "mass.sun_kg")
m2 = _paper("m2", "kg", "mass of the middle body", "mass.middle_kg")
m3 = _paper("m3", "kg", "mass of planet, shaft and funnel", "mass.planet_kg")
m4 = _paper("m4", "kg", "mass of the carrier", "mass.carrier_kg")
m_C1 = _paper("m_C1", "kg", "mass of the rocker", "mass.half_C1_kg")
m_C2 = _paper("m_C2", "kg", "mass of the nozzle half", "mass.half_C2_kg")
J_56 = _paper(
    "J_56", "kg m2", "moment of inertia of the middle body about A1", "inertia.J56_about_A1_kg_m2"
)
J_7 = _paper(
    "J_7",
    "kg m2",
    "moment of inertia of planet, shaft and funnel about B1",
    "inertia.J7_about_B1_kg_m2",
)
I_C1 = _triple(
    "I_C1{}",
    "kg m2",
    "centroidal moment of inertia of the rocker, {}",
    "inertia.C1_centroidal_xx_yy_zz_kg_m2",
)
I_C2 = _triple(
    "I_C2{}",
    "kg m2",
    "centroidal moment of inertia of the nozzle half, {}",
    "inertia.C2_centroidal_xx_yy_zz_kg_m2",
)
rho_CO = _paper("rho_CO", "m", "distance of the sun's centroid from O", "centroid.sun_radius_mm")
beta_CO = _paper("beta_CO", "rad", "direction of the sun's centroid", "centroid.sun_angle_deg")
rho_CA = _paper(
    "rho_CA", "m", "distance of the middle body's centroid from A1", "centroid.middle_radius_mm"
)
beta_CA = _paper(
    "beta_CA",
    "rad",
    "direction of the middle body's centroid at phi = 0",
    "centroid.middle_angle_deg",
)
c_CBx = _paper("c_CBx", "m", "centroid of planet, shaft and funnel, x'", "centroid.planet_xy_mm[0]")
c_CBy = _paper("c_CBy", "m", "centroid of planet, shaft and funnel, y'", "centroid.planet_xy_mm[1]")
x_A, y_A, z_A = _triple("{}_A", "m", "hinge A, {}'", "nozzle.hinge_A_mm")
c_C1 = _triple("c_C1{}", "m", "centroid of the rocker from the hinge, closed, {}'", "nozzle.C1_mm")
c_C2 = _triple(
    "c_C2{}", "m", "centroid of the nozzle half from the hinge, closed, {}'", "nozzle.C2_mm"
)
c_F = _triple("c_F{}", "m", "spring hook from the hinge, closed, {}'", "nozzle.hook_F_mm")
L_tip = _paper("L_tip", "m", "distance of the tip from B1 along x'", "nozzle.tip_distance_mm")
L_AE = _paper("L_AE", "m", "length of the rocker", "cam.rocker_length_mm")
psi0 = _paper("psi0", "rad", "initial angle of the rocker", "cam.psi0_deg")
R_b = _paper("R_b", "m", "radius of the base cylinder of the cam", "cam.base_radius_mm")
H = _paper("H", "rad", "opening angle of a nozzle half", "cam.opening_deg")
delta_r = _interval("delta_r", "rise", "cam.rise_delta_deg")
delta_f = _interval("delta_f", "fall", "cam.fall_delta_deg")
S0 = _paper("S0", "N", "preload of the return spring", "spring.preload_N")
k_s = _paper("k_s", "N/m", "rate of the return spring", "spring.rate_N_m")
MACHINE = Vector(
    "machine",
    (
        omega,
        g,
        v_f,
        alpha_n,
        mu1,
        mu2,
        m1,
        m2,
        m3,
        m4,
        m_C1,
        m_C2,
        J_56,
        J_7,
        *I_C1,
        *I_C2,
        rho_CO,
        beta_CO,
        rho_CA,
        beta_CA,
        c_CBx,
        c_CBy,
        x_A,
        y_A,
        z_A,
        *c_C1,
        *c_C2,
        *c_F,
        L_tip,
        L_AE,
        psi0,
        R_b,
        H,
        *delta_r,
        *delta_f,
        S0,
        k_s,
    ),
)

z_mirror = Quantity(
    "z_mirror", "m", "plane of symmetry of the nozzle, z'; undisclosed, cancels", "wang2017 2.1"
)

a1 = _kinematic("a1", "m", "centre distance of stage 1")
a2 = _kinematic("a2", "m", "centre distance of stage 2")
t1 = _kinematic("t1", "rad", "sun's polar angle at contact P")
t2 = _kinematic("t2", "rad", "gear 6's polar angle at contact Q")
r3 = _kinematic("r3", "m", "pitch radius of the sun at P")
dr3 = _kinematic("dr3", "m", "slope of the sun's pitch radius, per polar angle")
r6 = _kinematic("r6", "m", "pitch radius of gear 6 at Q")
dr6 = _kinematic("dr6", "m", "slope of gear 6's pitch radius, per polar angle")
r5 = _kinematic("r5", "m", "pitch radius of gear 5 at P")
r7 = _kinematic("r7", "m", "pitch radius of the planet at Q")
i1 = _kinematic(
    "i1", "1", "ratio of stage 1: rotation of the middle body per rotation of the carrier"
)
di1 = _kinematic("di1", "1", "slope of the ratio of stage 1, per polar angle")
i2 = _kinematic(
    "i2", "1", "ratio of stage 2: rotation of the planet back per rotation of the middle body"
)
di2 = _kinematic("di2", "1", "slope of the ratio of stage 2, per polar angle")
T1 = _kinematic("T1", "rad", "rotation of gear 5 since the sun's polar angle was zero")
T2 = _kinematic("T2", "rad", "rotation of the planet since gear 6's polar angle was zero")
T1_0 = _kinematic("T1_0", "rad", "T1 at phi = 0")
T2_0 = _kinematic("T2_0", "rad", "T2 at phi = 0")

phi52 = _kinematic("phi52", "rad", "rotation of the middle body relative to the carrier")
phi52_dot = _kinematic("phi52_dot", "rad/s", "rate of phi52")
phi52_ddot = _kinematic("phi52_ddot", "rad/s2", "acceleration of phi52")
phi72 = _kinematic("phi72", "rad", "rotation of the planet relative to the carrier")
phi72_dot = _kinematic("phi72_dot", "rad/s", "rate of phi72")
phi72_ddot = _kinematic("phi72_ddot", "rad/s2", "acceleration of phi72")
alpha = _kinematic(
    "alpha", "rad", "angle from x down to x'; the nozzle points straight down at 90 deg"
)
Omega = _kinematic("Omega", "rad/s", "absolute angular velocity of the planet", "omega_rad_s")
Omega_dot = _kinematic(
    "Omega_dot", "rad/s2", "absolute angular acceleration of the planet", "omega_dot_rad_s2"
)
delta = _kinematic("delta", "rad", "angle of the cam relative to the rocker, in [0, 2 pi)")


def _flank(name: str, meaning: str) -> tuple[Quantity, ...]:
    """Return position, slope per cam angle and law (share of the rise with two derivatives) of a
    flank of the cam.
    """
    return (
        _kinematic(f"x_{name}", "1", f"position in the {meaning}, from 0 to 1"),
        _kinematic(f"dx_{name}", "1", f"slope of the position in the {meaning}, per cam angle"),
        _kinematic(f"p_{name}", "1", f"completed share of the {meaning}"),
        _kinematic(f"dp_{name}", "1", f"slope of that share of the {meaning}, per position"),
        _kinematic(
            f"ddp_{name}", "1", f"second derivative of that share of the {meaning}, per position"
        ),
    )


x_rise, dx_rise, p_rise, dp_rise, ddp_rise = _flank("rise", "rise")
x_fall, dx_fall, p_fall, dp_fall, ddp_fall = _flank("fall", "fall")
theta1 = _kinematic("theta1", "rad", "swing of the inner half (angle psi of the rocker)")
theta1_dot = _kinematic("theta1_dot", "rad/s", "rate of theta1")
theta1_ddot = _kinematic("theta1_ddot", "rad/s2", "acceleration of theta1")
dpsi_ddelta = _kinematic("dpsi_ddelta", "1", "slope of the cam law")
S = _kinematic("S", "N", "force of the return spring")

x_A1 = _kinematic("x_A1", "m", "A1, x")
y_A1 = _kinematic("y_A1", "m", "A1, y")
x_B1 = _kinematic("x_B1", "m", "B1, x")
y_B1 = _kinematic("y_B1", "m", "B1, y")
x_P = _kinematic("x_P", "m", "contact P, x")
y_P = _kinematic("y_P", "m", "contact P, y")
x_CA = _kinematic("x_CA", "m", "centroid of the middle body, x")
y_CA = _kinematic("y_CA", "m", "centroid of the middle body, y")
x_CB = _kinematic("x_CB", "m", "centroid of planet, shaft and funnel, x")
y_CB = _kinematic("y_CB", "m", "centroid of planet, shaft and funnel, y")
x_tip_machine = _kinematic(
    "x_tip_machine", "m", "tip, x, in the machine's frame", "tip_machine_x_mm"
)
x_tip = _kinematic("x_tip", "m", "tip, x", "tip_x_mm")
y_tip = _kinematic("y_tip", "m", "tip, y", "tip_y_mm")
ax_A1 = _kinematic("ax_A1", "m/s2", "acceleration of A1, x")
ay_A1 = _kinematic("ay_A1", "m/s2", "acceleration of A1, y")
ax_B1 = _kinematic("ax_B1", "m/s2", "acceleration of B1, x")
ay_B1 = _kinematic("ay_B1", "m/s2", "acceleration of B1, y")
ax_A = _kinematic("ax_A", "m/s2", "absolute acceleration of the hinge, x'")
ay_A = _kinematic("ay_A", "m/s2", "absolute acceleration of the hinge, y'")
x_C1, y_C1, z_C1 = (_kinematic(f"{a}_C1", "m", f"centroid of the rocker, {a}'") for a in "xyz")
x_C2, y_C2, z_C2 = (_kinematic(f"{a}_C2", "m", f"centroid of the nozzle half, {a}'") for a in "xyz")
x_E, y_E, z_E = (_kinematic(f"{a}_E", "m", f"roller centre, {a}'") for a in "xyz")
x_F, y_F, z_F = (_kinematic(f"{a}_F", "m", f"spring hook, {a}'") for a in "xyz")
xi1 = _kinematic("xi1", "rad", "angle from the sun's radius vector to its tangent at P")
xi2 = _kinematic("xi2", "rad", "angle from gear 6's radius vector to its tangent at Q")
m31 = Quantity("m31", "1", "deformation coefficient of the sun", "wang2017 3.4", shown="m31")
m61 = Quantity("m61", "1", "deformation coefficient of gear 6", "wang2017 3.4", shown="m61")
PARAMETERS1 = OpenVector(
    "parameters1",
    "parameters of the sun's pitch curve, its deformation coefficient last",
    {-1: m31},
    "3",
    ("stage1", "parameters"),
)
PARAMETERS2 = OpenVector(
    "parameters2",
    "parameters of gear 6's pitch curve, its deformation coefficient last",
    {-1: m61},
    "6",
    ("stage2", "parameters"),
)
HOISTED1 = OpenVector(
    "hoisted1",
    "prologue of the sun's pitch curve, its centre distance first",
    {0: a1},
    sized_by=("stage1", "hoisted"),
)
HOISTED2 = OpenVector(
    "hoisted2",
    "prologue of gear 6's pitch curve, its centre distance first",
    {0: a2},
    sized_by=("stage2", "hoisted"),
)


def _force(name: str, meaning: str, axes: str) -> tuple[Quantity, ...]:
    return tuple(_paper(f"{name}{a}", "N", f"{meaning}, {a}") for a in axes)


F_E = _paper("F_E", "N", "force of the cam on the roller")
F_Ex, F_Ey, F_Ez = _force("F_E", "force of the cam on the roller, planet frame", "xyz")
F_E_loss = _paper("F_E_loss", "W", "power lost to friction between cam and roller")
F_Ax, F_Ay, F_Az = _force("F_A", "force of the planet on the inner half, planet frame", "xyz")
M_Q = _paper("M_Q", "N m", "moment about B1 of gear 6's action on the planet")
M_P = _paper("M_P", "N m", "moment about A1 of the sun's action on gear 5")
F_NQ = _paper("F_NQ", "N", "normal force between the teeth at Q")
F_NP = _paper("F_NP", "N", "normal force between the teeth at P")
F_Qx, F_Qy = _force("F_Q", "force of the planet on gear 6", "xy")
F_Px, F_Py = _force("F_P", "force of gear 5 on the sun", "xy")
F_B1x, F_B1y, F_B1z = _force("F_B1", "force of the carrier on the planet's shaft", "xyz")
F_A1x, F_A1y = _force("F_A1", "force of the carrier on the middle shaft", "xy")
F_Ox, F_Oy = _force("F_O", "force of the frame on the sun", "xy")
F_O1x, F_O1y, F_O1z = _force("F_O1", "force of the sun's shaft on the carrier", "xyz")
M_1 = _paper("M_1", "N m", "torque of the frame on the sun")
M_L = _paper("M_L", "N m", "torque of the motor on the carrier")
F_support = _paper("F_support", "N", "vertical force of the frame on sun and carrier", "support_N")
F_support_x = _paper(
    "F_support_x", "N", "horizontal force of the frame on sun and carrier", "support_x_N"
)

# Quantities between these that the paper names.
mu = _paper("mu", "rad", "pressure angle of the end-face cam")
M_T = _paper("M_T", "N m", "resisting moment of the rocker on the end-face cam")
phi_P1 = _paper("phi_P1", "rad", "direction of the normal force at P, from the radius vector")
phi_P2 = _paper("phi_P2", "rad", "direction of the friction force at P, from the radius vector")
phi_Q1 = _paper("phi_Q1", "rad", "direction of the normal force at Q, from the radius vector")
phi_Q2 = _paper("phi_Q2", "rad", "direction of the friction force at Q, from the radius vector")
F_fP = _paper("F_fP", "N", "friction force at P")
F_fQ = _paper("F_fQ", "N", "friction force at Q")

theta3 = _kinematic("theta3", "rad", "angle from x' down to the line from the hinge to C1")
theta4 = _kinematic("theta4", "rad", "angle from x' down to the line from the hinge to C2")
theta30 = _kinematic("theta30", "rad", "theta3 with the nozzle closed")
theta40 = _kinematic("theta40", "rad", "theta4 with the nozzle closed")
L_AC1 = _kinematic("L_AC1", "m", "distance of C1 from the hinge, in the plane of the swing")
L_AC2 = _kinematic("L_AC2", "m", "distance of C2 from the hinge, in the plane of the swing")
F_high = _paper("F_high", "N", "largest vertical support force of a turn")
F_low = _paper("F_low", "N", "least vertical support force of a turn")
F_i = _paper("F_i", "N", "vertical support force at sample i")
F_mean = _paper("F_mean", "N", "mean of the samples of the vertical support force")
mean_square = _paper("mean_square", "N2", "mean over the samples of (F_i - F_mean)^2")
f_1 = _paper("f_1", "N", "first objective: range of the vertical support force")
f_2 = _paper("f_2", "N2", "second objective: variance of the vertical support force")
f_total = _paper("f_total", "N", "objective: weighted sum of both")

REPORTED = (
    phi52,
    phi72,
    alpha,
    Omega,
    Omega_dot,
    x_tip,
    y_tip,
    theta1,
    F_E,
    F_Ex,
    M_Q,
    M_P,
    F_B1x,
    F_B1y,
    F_A1x,
    F_A1y,
    F_NP,
    F_NQ,
    F_E_loss,
    F_Ez,
    F_Ax,
    F_Ay,
    F_Qx,
    F_Qy,
    F_Px,
    F_Py,
    x_A1,
    y_A1,
    x_B1,
    y_B1,
    t1,
    t2,
    x_tip_machine,
)
"""What every model reports of one side."""
F_Aox, F_Aoy, F_Aoz = _force("F_Ao", "force of the planet on the outer half, planet frame", "xyz")
REPORTED_EXACT = (*REPORTED, F_Aox, F_Aoy, F_Az, F_Aoz)
TOTALS = (F_Ox, F_Oy, F_O1x, F_O1y, F_support, F_support_x, M_L, M_1)
INPUTS = (MOUNTING, PARAMETERS1, HOISTED1, PARAMETERS2, HOISTED2, MACHINE)


weight = _paper("weight", "N", "weight of all parts that the frame carries")
on_curve = _kinematic(
    "on_curve", "rad", "polar angle of the inner gear at a point of its pitch curve"
)
on_radius = _kinematic("on_radius", "m", "pitch radius at that angle")
on_turned = _kinematic(
    "on_turned",
    "rad",
    "rotation of the outer gear at that angle, since the inner gear's polar angle was zero",
)
POINT = Vector("point", (on_curve, on_radius, on_turned))
"""A point of a pitch curve, by its contact."""
x_inner, y_inner = (
    _kinematic(f"{a}_inner", "m", f"the point on the inner gear, {a}") for a in "xy"
)
x_outer, y_outer = (
    _kinematic(f"{a}_outer", "m", f"the corresponding point on the outer gear, {a}") for a in "xy"
)
PAIR = (x_inner, y_inner, x_outer, y_outer)


def twin(symbol: Quantity) -> Quantity:
    """Return the corresponding quantity of side 2."""
    return Quantity(f"{symbol.name}_2", symbol.unit, f"{symbol.meaning}; side 2", symbol.source)


@unique
class PlantingClaim(Claim):
    """Relations of cam and roller, of the swinging half, and of the teeth at P or Q."""

    # cam and roller
    CAM_PRESSURE_ANGLE = "pressure angle of the cam"
    CAM_FORCE = "force of the cam on the roller, {}'"
    CAM_MOMENT = "moment of the cam force about the planet's axis"

    # swinging half
    PLACE = "place of {}, {}'"
    HINGE_DISTANCE = "distance of {} from the hinge"
    HINGE_ANGLE_CLOSED = "angle of the line from the hinge to {}, closed"
    HINGE_ANGLE = "angle of the line from the hinge to {}"

    # teeth
    NORMAL_DIRECTION = "direction of the normal force at {}"
    FRICTION_DIRECTION = "direction of friction at {}"
    NORMAL_FORCE = "normal force at {}"
    FRICTION_FORCE = "friction force at {}"
    TOOTH_FORCE = "tooth force at {}, {}"
