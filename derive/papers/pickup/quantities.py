"""Quantities of the seedling pick-up and the relations that derivation and paper state (yu2023).

Frame at the sun's centre O, x right, y up, angles counter-clockwise; M1 is the intermediate axis,
O1 the planet's axis, S the tip of the needle. A knot's neighbours carry ``im1``, ``ip1`` for the
indices i - 1, i + 1.
"""

from __future__ import annotations

from ...quantity import Quantity, read_quantities

TABLE = read_quantities(
    """
yu2023 2
i_last | 1 | index of the last knot
i_first | 1 | index of the knot where the curve begins
i_end | 1 | index of the knot where the curve ends
n | 1 | index of the last control point
k | 1 | degree of the basis functions
u | 1 | parameter of the curve, between u_i and u_ip1
u_im2 | 1 | knot i - 2
u_im1 | 1 | knot i - 1
u_i | 1 | knot i
u_ip1 | 1 | knot i + 1
u_ip2 | 1 | knot i + 2
u_ip3 | 1 | knot i + 3
Delta_im2 | 1 | length of the knot interval that begins at knot i - 2
Delta_im1 | 1 | length of the knot interval that begins at knot i - 1
Delta_i | 1 | length of the knot interval that begins at knot i
Delta_ip1 | 1 | length of the knot interval that begins at knot i + 1
d_im1 | m | control point, one coordinate, whose basis function peaks at knot i - 1
d_i | m | control point, one coordinate, whose basis function peaks at knot i
d_ip1 | m | control point, one coordinate, whose basis function peaks at knot i + 1
d_ip2 | m | control point, one coordinate, whose basis function peaks at knot i + 2
p_u | m | point of the curve at u, one coordinate
q_i | m | value point at knot i, one coordinate
a_i | 1 | coefficient of the control point at knot i - 1 in the row of knot i
b_i | 1 | coefficient of the control point at knot i in the row of knot i
c_i | 1 | coefficient of the control point at knot i + 1 in the row of knot i
e_i | m | right side of the row of knot i, one coordinate

yu2023 3.1
L1 | m | distance from the sun's centre O to the planet's axis O1 | L1_mm
L2 | m | distance from the planet's axis O1 to the tip S, longer than L1 | L2_mm
L3 | m | distance from O to S | L3_mm

yu2023 3.2
L3_max | m | largest distance from O to S | L3_max_mm
L3_min | m | smallest distance from O to S | L3_min_mm

yu2023 3.1
a1 | m | centre distance of stage 1, O to M1 | a1_mm

yu2023 3.3
a2 | m | centre distance of stage 2, M1 to O1 | a2_mm

yu2023 3.1
gamma | rad | interior angle of the triangle O-M1-O1 at M1, obtuse | gamma_deg
beta1 | rad | interior angle of that triangle at O; M1 lies counter-clockwise of O1 | beta1_deg

yu2023 3.3
U1 | rad | interior angle of that triangle at O1

yu2023 3.2
phi1 | rad | angle at O1 from the ray to O to the ray to S, clockwise, counted on

yu2023 3.4
phi2 | rad | rotation of the intermediate gear relative to the carrier

yu2023 3.1
phi3 | rad | rotation of the planet and its arm relative to the carrier; zero (not printed) where the arm prolongs M1-O1

yu2023 3.2
phi4 | rad | direction of O-S from x, in (-pi, pi]

yu2023 3.1
phi5 | rad | direction of O-O1 from x
phi50 | rad | phi5 at the initial position

derived: pick-up
phi30 | rad | phi3 at the initial position: the mounting angle of the arm on the planet

yu2023 3.2
phi6 | rad | angle at O from the ray to S to the ray to O1, in [0, 2 pi)
phi1_far | rad | phi1 where the tip is farthest from O
phi6_far | rad | phi6 where the tip is farthest from O
phi1_near | rad | phi1 where the tip is nearest to O
phi6_near | rad | phi6 where the tip is nearest to O

yu2023 3.1
Y1 | rad | direction of O-M1 from x
W1 | rad | direction of M1-O1 from x; a full turn more or less is the same direction
Z1 | rad | direction of O1-S from x; a full turn more or less is the same direction

yu2023 3.2
dphi1 | rad | increment of phi1 that goes with dphi5

derived: pick-up
dphi2 | rad | increment of phi2 that goes with dphi5

yu2023 3.2
dphi5 | rad | increment of phi5, the carrier's

derived: pick-up
dL3 | m | increment of L3 that goes with dphi5; negative from the farthest to the nearest point

yu2023 3.2
omega | rad/s | speed of the carrier, constant, counter-clockwise | speed_deg_per_s

derived: pick-up
phi3_dot | rad/s | rate of phi3

yu2023 3.1
x_M1 | m | intermediate axis M1, x
y_M1 | m | intermediate axis M1, y
x_O1 | m | planet's axis O1, x
y_O1 | m | planet's axis O1, y
x_S | m | tip S, x | tip_x_mm
y_S | m | tip S, y | tip_y_mm
vx_M1 | m/s | velocity of M1, x
vy_M1 | m/s | velocity of M1, y
vx_O1 | m/s | velocity of O1, x
vy_O1 | m/s | velocity of O1, y
vx_S | m/s | velocity of S, x
vy_S | m/s | velocity of S, y

yu2023 3.2
iZ | 1 | total ratio: turn of the sun per turn of the planet, both seen from the carrier

yu2023 3.4
i1 | 1 | ratio of stage 1: turn of the sun per opposite turn of the intermediate gear, both seen from the carrier

yu2023 3.2
g_locked | 1 | reciprocal of the total ratio while the locking arcs act

yu2023 3.4
R1 | m | pitch radius of the sun at the contact | sun_radius_mm
R2 | m | pitch radius of the intermediate gear at the contact

derived: pick-up
dR1 | m | slope of the sun's pitch radius, per phi5
ddR1 | m | second derivative of the sun's pitch radius, per phi5

yu2023 3.4
x1 | m | pitch curve of the sun, x
y1 | m | pitch curve of the sun, y
x2 | m | pitch curve of the intermediate gear, x
y2 | m | pitch curve of the intermediate gear, y

yu2023 4.1
rho1 | m | radius of curvature of the sun's pitch curve, positive if convex | rho1_mm
rho2 | m | radius of curvature of the intermediate gear's, positive if convex | rho2_mm

yu2023 3.3
m_n | m | normal module of the helical pair | mn_mm
z_1 | 1 | teeth of the helical gear on the intermediate axis | z1
z_2 | 1 | teeth of the planet | z2
beta | rad | helix angle | helix_deg
B | m | face width of the helical pair | B_mm

assumed
alpha_n | rad | normal pressure angle of the helical pair | alpha_n_deg
ha_n | 1 | addendum coefficient of the helical pair | ha_helical

derived: pick-up
alpha_t | rad | transverse pressure angle of the helical pair

yu2023 3.3
epsilon_h | 1 | contact ratio of the helical pair | helical_contact_ratio

yu2023 4.1
alpha0 | rad | angle from the pitch curves' common tangent to the line of action | alpha0_deg
m | m | module of the non-circular pair | m_mm
ha1 | 1 | addendum coefficient of the sun | ha1
ha2 | 1 | addendum coefficient of the intermediate gear | ha2

derived: pick-up
g1 | m | path of action from the pitch point to the sun's addendum
g2 | m | path of action from the pitch point to the intermediate gear's addendum

yu2023 4.1
epsilon | 1 | contact ratio of the non-circular pair | contact_ratio
epsilon_ha | 1 | slope of the contact ratio as both addendum coefficients grow alike
epsilon_m | 1/m | slope of the contact ratio as the module grows

yu2023 1
theta_box | rad | inclination of the tray box to the horizontal | box_inclination_deg
swing | rad | push angle less pick angle of the needle | swing_deg
"""
)
"""Quantities by their names, which are attributes of this module too."""
__all__ = [*TABLE]


def __getattr__(name: str) -> Quantity:
    return getattr(TABLE, name)
