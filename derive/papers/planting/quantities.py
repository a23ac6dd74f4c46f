"""Quantities of the planting device and the relations that derivation and paper state (wang2017).

Points A, C1, C2, E, F carry coordinates of the planet frame x'y'z', relative to B1 (or to the hinge
A, if the name ends in that of A); points A1, B1, CA, CB, P, Q carry global ones.
"""

from __future__ import annotations

from ...quantity import OpenVector, Quantity, Vector, read_quantities

TABLE = read_quantities(
    """
wang2017
phi | rad | carrier angle | phi_deg

wang2017 3.4
theta | rad | initial mounting angle of the nozzle | theta_deg
gamma | rad | angle between the two centre lines | gamma_deg
alpha3 | rad | initial phase of the sun | alpha3_deg
beta6 | rad | initial phase of gear 6 | beta6_deg

wang2017
omega | rad/s | carrier speed, constant | operation.speed_rpm
g | m/s2 | gravity | operation.gravity_m_s2
v_f | m/s | forward speed of the machine | operation.forward_speed_m_s
alpha_n | rad | pressure angle of the teeth | contact.pressure_angle_deg
mu1 | rad | friction angle of cam and roller | contact.cam_friction_angle_deg
mu2 | rad | friction angle of the teeth | contact.tooth_friction_angle_deg
m1 | kg | mass of the sun | mass.sun_kg
m2 | kg | mass of the middle body | mass.middle_kg
m3 | kg | mass of planet, shaft and funnel | mass.planet_kg
m4 | kg | mass of the carrier | mass.carrier_kg
m_C1 | kg | mass of the rocker | mass.half_C1_kg
m_C2 | kg | mass of the nozzle half | mass.half_C2_kg
J_56 | kg m2 | moment of inertia of the middle body about A1 | inertia.J56_about_A1_kg_m2
J_7 | kg m2 | moment of inertia of planet, shaft and funnel about B1 | inertia.J7_about_B1_kg_m2
I_C1x | kg m2 | centroidal moment of inertia of the rocker, x | inertia.C1_centroidal_xx_yy_zz_kg_m2[0]
I_C1y | kg m2 | centroidal moment of inertia of the rocker, y | inertia.C1_centroidal_xx_yy_zz_kg_m2[1]
I_C1z | kg m2 | centroidal moment of inertia of the rocker, z | inertia.C1_centroidal_xx_yy_zz_kg_m2[2]
I_C2x | kg m2 | centroidal moment of inertia of the nozzle half, x | inertia.C2_centroidal_xx_yy_zz_kg_m2[0]
I_C2y | kg m2 | centroidal moment of inertia of the nozzle half, y | inertia.C2_centroidal_xx_yy_zz_kg_m2[1]
I_C2z | kg m2 | centroidal moment of inertia of the nozzle half, z | inertia.C2_centroidal_xx_yy_zz_kg_m2[2]
rho_CO | m | distance of the sun's centroid from O | centroid.sun_radius_mm
beta_CO | rad | direction of the sun's centroid | centroid.sun_angle_deg
rho_CA | m | distance of the middle body's centroid from A1 | centroid.middle_radius_mm
beta_CA | rad | direction of the middle body's centroid at phi = 0 | centroid.middle_angle_deg
c_CBx | m | centroid of planet, shaft and funnel, x' | centroid.planet_xy_mm[0]
c_CBy | m | centroid of planet, shaft and funnel, y' | centroid.planet_xy_mm[1]
x_A | m | hinge A, x' | nozzle.hinge_A_mm[0]
y_A | m | hinge A, y' | nozzle.hinge_A_mm[1]
z_A | m | hinge A, z' | nozzle.hinge_A_mm[2]
c_C1x | m | centroid of the rocker from the hinge, closed, x' | nozzle.C1_mm[0]
c_C1y | m | centroid of the rocker from the hinge, closed, y' | nozzle.C1_mm[1]
c_C1z | m | centroid of the rocker from the hinge, closed, z' | nozzle.C1_mm[2]
c_C2x | m | centroid of the nozzle half from the hinge, closed, x' | nozzle.C2_mm[0]
c_C2y | m | centroid of the nozzle half from the hinge, closed, y' | nozzle.C2_mm[1]
c_C2z | m | centroid of the nozzle half from the hinge, closed, z' | nozzle.C2_mm[2]
c_Fx | m | spring hook from the hinge, closed, x' | nozzle.hook_F_mm[0]
c_Fy | m | spring hook from the hinge, closed, y' | nozzle.hook_F_mm[1]
c_Fz | m | spring hook from the hinge, closed, z' | nozzle.hook_F_mm[2]
L_tip | m | distance of the tip from B1 along x' | nozzle.tip_distance_mm
L_AE | m | length of the rocker | cam.rocker_length_mm
psi0 | rad | initial angle of the rocker | cam.psi0_deg
R_b | m | radius of the base cylinder of the cam | cam.base_radius_mm
H | rad | opening angle of a nozzle half | cam.opening_deg
delta_r0 | rad | start of the rise | cam.rise_delta_deg[0]
delta_r1 | rad | end of the rise | cam.rise_delta_deg[1]
delta_f0 | rad | start of the fall | cam.fall_delta_deg[0]
delta_f1 | rad | end of the fall | cam.fall_delta_deg[1]
S0 | N | preload of the return spring | spring.preload_N
k_s | N/m | rate of the return spring | spring.rate_N_m

wang2017 2.1
z_mirror | m | plane of symmetry of the nozzle, z'; undisclosed, cancels

derived: kinematics
a1 | m | centre distance of stage 1
a2 | m | centre distance of stage 2
t1 | rad | sun's polar angle at contact P
t2 | rad | gear 6's polar angle at contact Q
r3 | m | pitch radius of the sun at P
dr3 | m | slope of the sun's pitch radius, per polar angle
r6 | m | pitch radius of gear 6 at Q
dr6 | m | slope of gear 6's pitch radius, per polar angle
r5 | m | pitch radius of gear 5 at P
r7 | m | pitch radius of the planet at Q
i1 | 1 | ratio of stage 1: rotation of the middle body per rotation of the carrier
di1 | 1 | slope of the ratio of stage 1, per polar angle
i2 | 1 | ratio of stage 2: rotation of the planet back per rotation of the middle body
di2 | 1 | slope of the ratio of stage 2, per polar angle
T1 | rad | rotation of gear 5 since the sun's polar angle was zero
T2 | rad | rotation of the planet since gear 6's polar angle was zero
T1_0 | rad | T1 at phi = 0
T2_0 | rad | T2 at phi = 0
phi52 | rad | rotation of the middle body relative to the carrier
phi52_dot | rad/s | rate of phi52
phi52_ddot | rad/s2 | acceleration of phi52
phi72 | rad | rotation of the planet relative to the carrier
phi72_dot | rad/s | rate of phi72
phi72_ddot | rad/s2 | acceleration of phi72
alpha | rad | angle from x down to x'; the nozzle points straight down at 90 deg
Omega | rad/s | absolute angular velocity of the planet | omega_rad_s
Omega_dot | rad/s2 | absolute angular acceleration of the planet | omega_dot_rad_s2
delta | rad | angle of the cam relative to the rocker, in [0, 2 pi)
x_rise | 1 | position in the rise, from 0 to 1
dx_rise | 1 | slope of the position in the rise, per cam angle
p_rise | 1 | completed share of the rise
dp_rise | 1 | slope of that share of the rise, per position
ddp_rise | 1 | second derivative of that share of the rise, per position
x_fall | 1 | position in the fall, from 0 to 1
dx_fall | 1 | slope of the position in the fall, per cam angle
p_fall | 1 | completed share of the fall
dp_fall | 1 | slope of that share of the fall, per position
ddp_fall | 1 | second derivative of that share of the fall, per position
theta1 | rad | swing of the inner half (angle psi of the rocker)
theta1_dot | rad/s | rate of theta1
theta1_ddot | rad/s2 | acceleration of theta1
dpsi_ddelta | 1 | slope of the cam law
S | N | force of the return spring
x_A1 | m | A1, x
y_A1 | m | A1, y
x_B1 | m | B1, x
y_B1 | m | B1, y
x_P | m | contact P, x
y_P | m | contact P, y
x_CA | m | centroid of the middle body, x
y_CA | m | centroid of the middle body, y
x_CB | m | centroid of planet, shaft and funnel, x
y_CB | m | centroid of planet, shaft and funnel, y
x_tip_machine | m | tip, x, in the machine's frame | tip_machine_x_mm
x_tip | m | tip, x | tip_x_mm
y_tip | m | tip, y | tip_y_mm
ax_A1 | m/s2 | acceleration of A1, x
ay_A1 | m/s2 | acceleration of A1, y
ax_B1 | m/s2 | acceleration of B1, x
ay_B1 | m/s2 | acceleration of B1, y
ax_A | m/s2 | absolute acceleration of the hinge, x'
ay_A | m/s2 | absolute acceleration of the hinge, y'
x_C1 | m | centroid of the rocker, x'
y_C1 | m | centroid of the rocker, y'
z_C1 | m | centroid of the rocker, z'
x_C2 | m | centroid of the nozzle half, x'
y_C2 | m | centroid of the nozzle half, y'
z_C2 | m | centroid of the nozzle half, z'
x_E | m | roller centre, x'
y_E | m | roller centre, y'
z_E | m | roller centre, z'
x_F | m | spring hook, x'
y_F | m | spring hook, y'
z_F | m | spring hook, z'
xi1 | rad | angle from the sun's radius vector to its tangent at P
xi2 | rad | angle from gear 6's radius vector to its tangent at Q

wang2017 3.4
m31 | 1 | deformation coefficient of the sun | m31
m61 | 1 | deformation coefficient of gear 6 | m61

wang2017
F_E | N | force of the cam on the roller
F_Ex | N | force of the cam on the roller, planet frame, x
F_Ey | N | force of the cam on the roller, planet frame, y
F_Ez | N | force of the cam on the roller, planet frame, z
F_E_loss | W | power lost to friction between cam and roller
F_Ax | N | force of the planet on the inner half, planet frame, x
F_Ay | N | force of the planet on the inner half, planet frame, y
F_Az | N | force of the planet on the inner half, planet frame, z
M_Q | N m | moment about B1 of gear 6's action on the planet
M_P | N m | moment about A1 of the sun's action on gear 5
F_NQ | N | normal force between the teeth at Q
F_NP | N | normal force between the teeth at P
F_Qx | N | force of the planet on gear 6, x
F_Qy | N | force of the planet on gear 6, y
F_Px | N | force of gear 5 on the sun, x
F_Py | N | force of gear 5 on the sun, y
F_B1x | N | force of the carrier on the planet's shaft, x
F_B1y | N | force of the carrier on the planet's shaft, y
F_B1z | N | force of the carrier on the planet's shaft, z
F_A1x | N | force of the carrier on the middle shaft, x
F_A1y | N | force of the carrier on the middle shaft, y
F_Ox | N | force of the frame on the sun, x
F_Oy | N | force of the frame on the sun, y
F_O1x | N | force of the sun's shaft on the carrier, x
F_O1y | N | force of the sun's shaft on the carrier, y
F_O1z | N | force of the sun's shaft on the carrier, z
M_1 | N m | torque of the frame on the sun
M_L | N m | torque of the motor on the carrier
F_support | N | vertical force of the frame on sun and carrier | support_N
F_support_x | N | horizontal force of the frame on sun and carrier | support_x_N
mu | rad | pressure angle of the end-face cam
M_T | N m | resisting moment of the rocker on the end-face cam
phi_P1 | rad | direction of the normal force at P, from the radius vector
phi_P2 | rad | direction of the friction force at P, from the radius vector
phi_Q1 | rad | direction of the normal force at Q, from the radius vector
phi_Q2 | rad | direction of the friction force at Q, from the radius vector
F_fP | N | friction force at P
F_fQ | N | friction force at Q

derived: kinematics
theta3 | rad | angle from x' down to the line from the hinge to C1
theta4 | rad | angle from x' down to the line from the hinge to C2
theta30 | rad | theta3 with the nozzle closed
theta40 | rad | theta4 with the nozzle closed
L_AC1 | m | distance of C1 from the hinge, in the plane of the swing
L_AC2 | m | distance of C2 from the hinge, in the plane of the swing

wang2017
F_high | N | largest vertical support force of a turn
F_low | N | least vertical support force of a turn
F_i | N | vertical support force at sample i
F_mean | N | mean of the samples of the vertical support force
mean_square | N2 | mean over the samples of (F_i - F_mean)^2
f_1 | N | first objective: range of the vertical support force
f_2 | N2 | second objective: variance of the vertical support force
f_total | N | objective: weighted sum of both
F_Aox | N | force of the planet on the outer half, planet frame, x
F_Aoy | N | force of the planet on the outer half, planet frame, y
F_Aoz | N | force of the planet on the outer half, planet frame, z
weight | N | weight of all parts that the frame carries

derived: kinematics
on_curve | rad | polar angle of the inner gear at a point of its pitch curve
on_radius | m | pitch radius at that angle
on_turned | rad | rotation of the outer gear at that angle, since the inner gear's polar angle was zero
x_inner | m | the point on the inner gear, x
y_inner | m | the point on the inner gear, y
x_outer | m | the corresponding point on the outer gear, x
y_outer | m | the corresponding point on the outer gear, y
"""
)
"""Quantities by their names, which are attributes of this module too."""


def _triple(name: str) -> tuple[Quantity, Quantity, Quantity]:
    return TABLE[f"{name}x"], TABLE[f"{name}y"], TABLE[f"{name}z"]


MOUNTING = Vector("mounting", TABLE.select("theta gamma alpha3 beta6"))
MACHINE = Vector(
    "machine",
    TABLE.select(
        "omega g v_f alpha_n mu1 mu2 m1 m2 m3 m4 m_C1 m_C2 J_56 J_7 I_C1x I_C1y I_C1z I_C2x I_C2y "
        "I_C2z rho_CO beta_CO rho_CA beta_CA c_CBx c_CBy x_A y_A z_A c_C1x c_C1y c_C1z c_C2x c_C2y "
        "c_C2z c_Fx c_Fy c_Fz L_tip L_AE psi0 R_b H delta_r0 delta_r1 delta_f0 delta_f1 S0 k_s"
    ),
)
I_C1, I_C2 = _triple("I_C1"), _triple("I_C2")
c_C1, c_C2, c_F = _triple("c_C1"), _triple("c_C2"), _triple("c_F")
delta_r, delta_f = (TABLE.delta_r0, TABLE.delta_r1), (TABLE.delta_f0, TABLE.delta_f1)
PARAMETERS1 = OpenVector(
    "parameters1",
    "parameters of the sun's pitch curve, its deformation coefficient last",
    {-1: TABLE.m31},
    "3",
    ("stage1", "parameters"),
)
PARAMETERS2 = OpenVector(
    "parameters2",
    "parameters of gear 6's pitch curve, its deformation coefficient last",
    {-1: TABLE.m61},
    "6",
    ("stage2", "parameters"),
)
HOISTED1 = OpenVector(
    "hoisted1",
    "prologue of the sun's pitch curve, its centre distance first",
    {0: TABLE.a1},
    sized_by=("stage1", "hoisted"),
)
HOISTED2 = OpenVector(
    "hoisted2",
    "prologue of gear 6's pitch curve, its centre distance first",
    {0: TABLE.a2},
    sized_by=("stage2", "hoisted"),
)
INPUTS = (MOUNTING, PARAMETERS1, HOISTED1, PARAMETERS2, HOISTED2, MACHINE)
REPORTED = TABLE.select(
    "phi52 phi72 alpha Omega Omega_dot x_tip y_tip theta1 F_E F_Ex M_Q M_P F_B1x F_B1y F_A1x F_A1y "
    "F_NP F_NQ F_E_loss F_Ez F_Ax F_Ay F_Qx F_Qy F_Px F_Py x_A1 y_A1 x_B1 y_B1 t1 t2 x_tip_machine"
)
"""What every model reports of one side."""
REPORTED_EXACT = (*REPORTED, *TABLE.select("F_Aox F_Aoy F_Az F_Aoz"))
TOTALS = TABLE.select("F_Ox F_Oy F_O1x F_O1y F_support F_support_x M_L M_1")
POINT = Vector("point", TABLE.select("on_curve on_radius on_turned"))
"""A point of a pitch curve, by its contact."""
PAIR = TABLE.select("x_inner y_inner x_outer y_outer")
__all__ = [
    *TABLE,
    "I_C1",
    "I_C2",
    "c_C1",
    "c_C2",
    "c_F",
    "delta_f",
    "delta_r",
    "twin",
]


def twin(symbol: Quantity) -> Quantity:
    """Return the corresponding quantity of side 2."""
    return Quantity(f"{symbol.name}_2", symbol.unit, f"{symbol.meaning}; side 2", symbol.source)


def __getattr__(name: str) -> Quantity:
    return getattr(TABLE, name)
