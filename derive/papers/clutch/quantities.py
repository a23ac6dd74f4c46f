"""Quantities of the Reuleaux-pentagon clutch and the relations between them that derivation and
paper state (shi2021).

Frame xOy: origin at the centre of the hexagonal hole, x to the right along its upper side, y up;
XOY is turned by 60 deg counter-clockwise. Vertices A and B slide on the two sides that meet at the
upper left corner, C is opposite.
"""

from __future__ import annotations

from ...quantity import Quantity, read_quantities

TABLE = read_quantities(
    """
shi2021
R | m | constant width of the polygon, diagonal of its pentagon
a | m | side of the hexagonal hole | sleeve.hexagon_side_mm
theta | rad | direction of AC below +x
beta | rad | direction of BC below +X

derived: clutch
x_A | m | vertex A, x
y_A | m | vertex A, y
X_B | m | vertex B, X
Y_B | m | vertex B, Y
x_C | m | vertex C, x
y_C | m | vertex C, y
X_C | m | vertex C, X
Y_C | m | vertex C, Y
A1 | 1 | share of R sin(theta) in the path of C, x
A2 | 1 | share of R cos(theta) in the path of C, x
x_E | m | centre of the ellipse that C describes, x
y_E | m | centre of the ellipse that C describes, y
x_F | m | focus of the ellipse, x
y_F | m | focus of the ellipse, y
s_1 | m | semi-major axis of the ellipse
s_2 | m | semi-minor axis of the ellipse
rho_C | m | radius of curvature of the path of C where it leaves the side of the hexagon
e_3 | m | overlap of the outline with the third pair of sides while the other two pairs are touched

shi2021
a1 | m | edge of the hexagonal section of the output shaft
r | m | fillet radius on the corners of the output shaft | shaft.fillet_mm

derived: clutch
rho_t | m | radius of curvature of the tooth tips' path where it leaves the flat of the output shaft

shi2021
b1 | m | distance of the tooth tips from the centroid of the body | tooth.tip_mm
b2 | m | distance of the tooth roots from the centroid of the body | tooth.root_mm

derived: clutch
xi | rad | full angle between the two faces of a tooth

shi2021
phi | rad | inclination of the tapered contact surface to the axis | sleeve.axial_angle_deg
c | m | axial travel of the sleeve | sleeve.travel_mm

derived: clutch
c_min | m | smallest axial travel with which the body can turn coaxially
b | m | largest outline radius of the body: distance of a vertex from the centroid

shi2021
R1 | m | largest outline radius of the body at the left end
R2 | m | largest outline radius of the body at the right end | sleeve.right_radius_mm
d | m | axial length of the body | sleeve.length_mm
F1 | N | engaging force | sleeve.engaging_force_N
F2 | N | preload of the spring | sleeve.spring_preload_N
mu | 1 | coefficient of friction of body and sleeve | sleeve.friction

derived: clutch
F_N | N | normal force between body and sleeve
f | N | friction force between body and sleeve

shi2021
alpha | rad | inclination of the links of the parallel four-bar to the horizontal
gamma | rad | mounting phase angle of the arc rack | linkage.rack_phase_deg
r_A | m | pitch radius of the crank gear | linkage.crank_gear_radius_mm
r_D | m | pitch radius of the arc rack | linkage.rack_radius_mm
k | 1 | gear radius ratio, crank gear to arc rack

derived: clutch
theta_A | rad | rotation of the crank gear, counted in the fixed frame
theta_AR | rad | rotation of the crank gear relative to the link that carries it
theta_Amax | rad | rotation of the crank gear from the start of mesh to the limit
n | 1 | teeth that the crank gear turns through from the start of mesh to the limit

shi2021
m | m | module of crank gear and rack | linkage.module_mm
l_AB | m | length of the crank | linkage.crank_mm
l_BC | m | length of the connecting rod | linkage.rod_mm
l_AC | m | distance from the crank's axis A to the sleeve's pin C when engaged | linkage.distance_mm
x | m | position along the output shaft, from its bearing
t | s | time since contact
l | m | overhang of the output shaft: the contact is at x = l | shaft.overhang_mm
E | N/m2 | modulus of elasticity of the output shaft | shaft.modulus_GPa
I | m4 | second moment of area of the output shaft
rho | kg/m3 | density of the output shaft | shaft.density_kg_m3
S | m2 | section of the output shaft
m1 | kg | mass of the engaging body | engagement.body_kg
m2 | kg | mass of the overhanging end of the output shaft, all of it
F_M | N | driving force on the engaging body
Delta_omega | rad/s | speed of the engaging body less that of the output shaft
r1 | m | turning radius of the contact point | engagement.contact_radius_mm

derived: clutch
N | N | contact load N(t)
N_max | N | largest contact load
y | m | deflection y(x, t) of the output shaft
y_max | m | deflection at the contact: the one coordinate of the mode
y_4x | 1/m3 | fourth derivative of the deflection along the shaft, at x
a_x | m/s2 | acceleration of the shaft at x
a_l | m/s2 | acceleration of the shaft at the contact, x = l

shi2021
fixity | 1 | share k l/(k l + E I) of a bearing with the stiffness k against turning: 1 clamps

derived: clutch
v_0 | m/s | speed of the shaft at the contact when it begins, x = l and t = 0
delta_l | 1/m | Dirac's delta of x - l; where a number is needed, its part in the one mode
K_1 | N/m | modal stiffness of the output shaft
M_1 | kg | modal mass of the output shaft
B1 | rad/s | circular frequency of shaft and body in contact
B2 | m/s2 | acceleration that the driving force gives to shaft and body in contact

shi2021
theta0 | rad | angle between the engaging surface and the slider's reaction F_x | slip.angle_deg
F_x | N | reaction of the slider on the tooth that pulls it along the surface and presses it on
F_y | N | reaction of the slider at right angles to F_x, it too presses on | slip.reaction_N
f0 | N | friction between tooth and shaft, against the slip | slip.friction_N

derived: clutch
a0 | m/s2 | acceleration of the tooth along the surface

shi2021
Y1 | m | lag distance at engagement
Y2 | m | lag distance at cut-off
S1 | m | position of the first seed along the row | field.first_seed_mm
S2 | m | position at which the opener enters the soil | field.entry_mm
S3 | m | position of the last seed along the row | field.last_seed_mm
S4 | m | position at which the opener leaves the soil | field.exit_mm
t_c | s | time to switch
v_c | m/s | mean switching speed of the sleeve | sleeve.switching_speed_mm_s
"""
)
"""Quantities by their names, which are attributes of this module too."""
__all__ = [*TABLE]


def __getattr__(name: str) -> Quantity:
    return getattr(TABLE, name)
