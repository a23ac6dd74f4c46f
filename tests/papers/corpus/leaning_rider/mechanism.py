"""A bicycle's rear frame, free to yaw, roll and pitch over its rear contact, and a rider who leans
about a hinge.

The hinge lies along the bicycle: horizontal while the frame is upright and pitched by the tilt of
its steering axis.
"""

from derive import Mechanism, X, Y, quantities

q = quantities("""
    g     | m/s2    | free fall                                | 9.81
    lam   | rad     | tilt of the steering axis                | 0.32
    r_R   | m       | radius of the rear wheel                 | 0.34
    d_4   | m       | hinge of the rider below the rear hub    | 0.15
    l_5   | m       | hinge to centroid of the rider, forward  | 0.2
    l_6   | m       | hinge to centroid of the rider, down     | -0.5
    m_G   | kg      | upper body of the rider                  | 45
    k_9   | N m     | stiffness of the hip                     | 120
    c_hip | kg m2/s | damping of the hip                       | 30
    T_4   | N m     | roll torque                              | 1
    T_6   | N m     | torque on the rear wheel                 | 1
    T_7   | N m     | steer torque                             | 1
    T_9   | N m     | torque between rider and rear frame      | 1
    I_G11 | kg m2   | upper body, forward                      | 2.1
    I_G22 | kg m2   | upper body, across                       | 1.9
    I_G33 | kg m2   | upper body, upright                      | 0.6
    I_G13 | kg m2   | upper body, product                      | 0.2
""")

m = Mechanism("leaning_rider", q, spatial=True)
q1, q2 = (
    m.coordinate("q_1", "m", "rear contact, forward"),
    m.coordinate("q_2", "m", "rear contact, to the right"),
)
q3, q4, q5 = (
    m.coordinate(f"q_{i}", "rad", name) for i, name in ((3, "yaw"), (4, "roll"), (5, "pitch"))
)
q9 = m.coordinate("q_9", "rad", "lean of the rider against the frame")

A = m.frame("A", q3)
B = m.frame("B", q4, X, A)
C = m.frame("C", q5, Y, B)
level = m.frame("level", -q.lam, Y, C)  # along the ground while the bicycle stands upright
G = m.frame("G", q9, X, level)

d_o = m.point("d_o", m.point("d_n", m.O, m.world, q1, q2), B, 0, 0, -q.r_R)
c_g = m.point("c_g", d_o, level, 0, 0, q.d_4)
g_o = m.point("g_o", c_g, G, q.l_5, 0, q.l_6)
