"""The Whipple bicycle by positions and turns alone: yaw, roll, pitch, steer and two thin wheels on
the ground.
"""

from sympy import Matrix, pi, sqrt

from derive import Frame, Mechanism, Point, Vec, X, Y, Z, displacement, quantities

q = quantities("""
    g    | m/s2  | free fall                                 | 9.81
    lam  | rad   | tilt of the steering axis                 | 0.3
    w    | m     | wheel base                                | 1.1
    c    | m     | trail                                     | 0.08
    r_R  | m     | radius of the rear wheel                  | 0.3
    r_F  | m     | radius of the front wheel                 | 0.35
    x_B  | m     | centroid of the rear frame, forward       | 0.3
    z_B  | m     | centroid of the rear frame, down          | -0.9
    x_H  | m     | centroid of the fork, forward             | 0.9
    z_H  | m     | centroid of the fork, down                | -0.7
    m_R  | kg    | rear wheel                                | 2
    m_B  | kg    | rear frame and rider                      | 85
    m_H  | kg    | fork and handlebar                        | 4
    m_F  | kg    | front wheel                               | 3
    I_Rxx | kg m2 | rear wheel, across the axle              | 0.06
    I_Ryy | kg m2 | rear wheel, about the axle               | 0.12
    I_Bxx | kg m2 | rear frame                               | 9.2
    I_Byy | kg m2 | rear frame                               | 11
    I_Bzz | kg m2 | rear frame                               | 2.8
    I_Bxz | kg m2 | rear frame                               | 2.4
    I_Hxx | kg m2 | fork                                     | 0.059
    I_Hyy | kg m2 | fork                                     | 0.06
    I_Hzz | kg m2 | fork                                     | 0.0071
    I_Hxz | kg m2 | fork                                     | -0.0076
    I_Fxx | kg m2 | front wheel, across the axle             | 0.14
    I_Fyy | kg m2 | front wheel, about the axle              | 0.28
    T_4   | N m   | roll torque                              | 1
    T_6   | N m   | torque on the rear wheel                 | 1
    T_7   | N m   | steer torque                             | 1
""")

m = Mechanism("whipple_kinematics", q, spatial=True)
q1, q2 = (
    m.coordinate("q_1", "m", "rear contact, forward"),
    m.coordinate("q_2", "m", "rear contact, to the right"),
)
q3, q4, q5 = (
    m.coordinate(f"q_{i}", "rad", name) for i, name in ((3, "yaw"), (4, "roll"), (5, "pitch"))
)
q6, q7, q8 = (
    m.coordinate(f"q_{i}", "rad", name)
    for i, name in ((6, "rear wheel"), (7, "steer"), (8, "front wheel"))
)

# The upright bicycle, going straight: its points along the tilted steering axis and across it.
tilted, half = m.frame("tilted", q.lam, Y), m.frame("half", pi, Y)
hub_R, hub_F = (
    m.point("hub_R", m.O, m.world, 0, 0, -q.r_R),
    m.point("hub_F", m.O, m.world, q.w, 0, -q.r_F),
)
foot = m.point("foot", m.O, m.world, q.w + q.c)  # where the steering axis meets the ground
centroid_B = m.point("centroid_B", m.O, m.world, q.x_B, 0, q.z_B)
centroid_H = m.point("centroid_H", m.O, m.world, q.x_H, 0, q.z_H)
rear, front = displacement(hub_R, foot, tilted), displacement(foot, hub_F, tilted)
at_B, at_H = displacement(hub_R, centroid_B, tilted), displacement(hub_F, centroid_H, tilted)
d_1 = m.name_("d_1", "m", "rear hub to steering axis, across it", rear[0])
d_2 = m.name_("d_2", "m", "between the hubs, along the steering axis", rear[2] + front[2])
d_3 = m.name_("d_3", "m", "steering axis to front hub, across it", front[0])
l_1 = m.name_("l_1", "m", "rear hub to centroid of the rear frame, across the axis", at_B[0])
l_2 = m.name_("l_2", "m", "rear hub to centroid of the rear frame, along the axis", at_B[2])
l_3 = m.name_("l_3", "m", "front hub to centroid of the fork, across the axis", at_H[0])
l_4 = m.name_("l_4", "m", "front hub to centroid of the fork, along the axis", at_H[2])
for name, mass in (("m_C", q.m_B), ("m_D", q.m_R), ("m_E", q.m_H)):
    m.name_(name, "kg", "mass of a body by its other name", mass)
for name, inertia in (
    ("I_D11", q.I_Rxx),
    ("I_D22", q.I_Ryy),
    ("I_F11", q.I_Fxx),
    ("I_F22", q.I_Fyy),
):
    m.name_(name, "kg m2", "inertia of a wheel by its other name", inertia)
for body, xx, yy, zz, xz in (
    ("C", q.I_Bxx, q.I_Byy, q.I_Bzz, q.I_Bxz),
    ("E", q.I_Hxx, q.I_Hyy, q.I_Hzz, q.I_Hxz),
):
    turn = Matrix(
        [list(m.vector(m.world, *axis).resolved(tilted).components) for axis in (X, Y, Z)]
    ).T
    tensor = turn * Matrix([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]) * turn.T
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 2)):
        m.name_(f"I_{body}{i + 1}{j + 1}", "kg m2", "inertia along the tilted axes", tensor[i, j])

A = m.frame("A", q3)
B = m.frame("B", q4, X, A)
C = m.frame("C", q5, Y, B)
D = m.frame("D", q6, Y, C)
E = m.frame("E", q7, Z, C)
F = m.frame("F", q8, Y, E)

n_o = m.O
d_n = m.point("d_n", n_o, m.world, q1, q2)
d_o = m.point("d_o", d_n, B, 0, 0, -q.r_R)
c_o = m.point("c_o", d_o, C, l_1, 0, l_2)
c_e = m.point("c_e", d_o, C, d_1)
s_f = m.point("s_f", c_e, C, 0, 0, d_2)
f_o = m.point("f_o", s_f, E, d_3)
e_o = m.point("e_o", f_o, E, l_3, 0, l_4)

# The lowest point of the front wheel: the way down, without its part along the axle, a radius long.
down, axle = m.vector(m.world, 0, 0, 1), m.vector(E, 0, 1).resolved(m.world)
tilt = axle.dot(down)
way = (q.r_F / sqrt(1 - tilt**2)) * (down + (-tilt) * axle)
f_n = m.point("f_n", f_o, m.world, *way.components)
m.constrain("front", m.position(f_n)[2], start={q5: q.lam})


def wheel_point_velocity(wheel: Frame, hub: Point, contact: Point) -> Vec:
    """Return the velocity [m/s] of the point of a wheel that is at the contact, along the axes of
    yaw.
    """
    arm = displacement(hub, contact, m.world)
    return (m.velocity(hub) + m.motion.spin(wheel).resolved(m.world).cross(arm)).resolved(A)


for name, velocity in (
    ("rear", wheel_point_velocity(D, d_o, d_n)),
    ("front", wheel_point_velocity(F, f_o, f_n)),
):
    m.roll(f"{name}_along", velocity[0])
    m.roll(f"{name}_across", velocity[1])
