"""A bicycle with a rider's arms: rear frame, fork, upper arms in the shoulders, lower arms hinged
at the elbows.
"""

from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    r_R  | m     | radius of the rear wheel                  | 0.34
    d_1  | m     | rear hub to steering axis, across it      | 0.96
    d_2  | m     | between the hubs, along the steering axis | 0.26
    d_3  | m     | steering axis to front hub, across it     | 0.03
    d_4  | m     | rear hub to lateral force, across         | 0.3
    d_5  | m     | rear hub to lateral force, along          | -0.5
    d_6  | m     | rear hub to shoulders, across             | 0.45
    d_7  | m     | half the distance of the shoulders        | 0.2
    d_8  | m     | rear hub to shoulders, along              | -0.7
    d_9  | m     | front hub to grips, across                | -0.1
    d_10 | m     | half the distance of the grips            | 0.25
    d_11 | m     | front hub to grips, along                 | -0.6
    d_12 | m     | shoulder to elbow                         | 0.45
    d_13 | m     | elbow to hand                             | 0.45
    l_5  | m     | shoulder to centroid of the upper arm     | 0.14
    l_6  | m     | elbow to centroid of the lower arm        | 0.12
    F_c  | N     | lateral force                             | 10
    I_G11 | kg m2 | upper arm, across                        | 0.02
    I_G33 | kg m2 | upper arm, along                         | 0.003
    I_I11 | kg m2 | left upper arm, across                   | 0.02
    I_I33 | kg m2 | left upper arm, along                    | 0.003
    I_H11 | kg m2 | lower arm, across                        | 0.01
    I_H33 | kg m2 | lower arm, along                         | 0.001
    I_J11 | kg m2 | left lower arm, across                   | 0.01
    I_J33 | kg m2 | left lower arm, along                    | 0.001
""")

m = Mechanism("bicycle_arms", q, spatial=True)
q1, q2 = (
    m.coordinate("q_1", "m", "rear contact, forward"),
    m.coordinate("q_2", "m", "rear contact, to the right"),
)
q3, q4, q5, q7, q9, q10, q11, q12, q13, q14, q15, q16 = (
    m.coordinate(f"q_{i}", "rad", meaning)
    for i, meaning in {
        3: "yaw",
        4: "roll",
        5: "pitch",
        7: "steer",
        9: "right abduction",
        10: "right elevation",
        11: "right rotation",
        12: "right elbow",
        13: "left abduction",
        14: "left elevation",
        15: "left rotation",
        16: "left elbow",
    }.items()
)

A = m.frame("A", q3)
B = m.frame("B", q4, X, A)
C = m.frame("C", q5, Y, B)
E = m.frame("E", q7, Z, C)
G = m.frame("G", q11, Z, m.frame("right elevation", q10, Y, m.frame("right abduction", q9, X, C)))
H = m.frame("H", q12, Y, G)
I = m.frame("I", q15, Z, m.frame("left elevation", q14, Y, m.frame("left abduction", q13, X, C)))  # noqa: E741
J = m.frame("J", q16, Y, I)

d_o = m.point("d_o", m.point("d_n", m.O, m.world, q1, q2), B, 0, 0, -q.r_R)
c_l = m.point("c_l", d_o, C, q.d_4, 0, q.d_5)
f_o = m.point("f_o", m.point("s_f", d_o, C, q.d_1, 0, q.d_2), E, q.d_3)
s_r, s_l = m.point("s_r", d_o, C, q.d_6, q.d_7, q.d_8), m.point("s_l", d_o, C, q.d_6, -q.d_7, q.d_8)
e_r, e_l = m.point("e_r", s_r, G, 0, 0, q.d_12), m.point("e_l", s_l, I, 0, 0, q.d_12)
g_o, i_o = m.point("g_o", s_r, G, 0, 0, q.l_5), m.point("i_o", s_l, I, 0, 0, q.l_5)
h_o, j_o = m.point("h_o", e_r, H, 0, 0, q.l_6), m.point("j_o", e_l, J, 0, 0, q.l_6)
h_r, h_l = m.point("h_r", e_r, H, 0, 0, q.d_13), m.point("h_l", e_l, J, 0, 0, q.d_13)
g_r, g_l = (
    m.point("g_r", f_o, E, q.d_9, q.d_10, q.d_11),
    m.point("g_l", f_o, E, q.d_9, -q.d_10, q.d_11),
)

# The hands hold the grips, and the axes of the elbows are level as the roll frame sees them.
start = {q9: 0, q10: 0, q11: 0, q12: 1.8, q13: 0, q14: 0, q15: 0, q16: 1.8}
m.close(h_r, g_r, start=start)
m.close(h_l, g_l, start={})
down = m.vector(B, 0, 0, 1).resolved(m.world)
for name, arm in (("right_elbow", G), ("left_elbow", I)):
    m.constrain(name, q.d_12 * m.vector(arm, 0, 1).resolved(m.world).dot(down), start={})
