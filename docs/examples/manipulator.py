"""A manipulator of two arms in a vertical plane that swings down and settles: motors hold it by springs and dampers.

Each motor pulls its joint towards a pose as a spring with a damper does; gravity holds it a little off. The gripper's
place and the motors' torques are told.
"""

from derive import Mechanism, quantities

q = quantities("""
    g    | m/s2    | free fall                         | 9.81
    l_1  | mm      | upper arm                         | 420
    l_2  | mm      | forearm                           | 360
    c_1  | mm      | centroid of the upper arm         | 190
    c_2  | mm      | centroid of the forearm           | 150
    m_1  | kg      | upper arm                         | 3.2
    m_2  | kg      | forearm with the gripper          | 1.9
    J_1  | kg m2   | upper arm, about its centroid     | 0.052
    J_2  | kg m2   | forearm, about its centroid       | 0.027
    k_1  | N m     | shoulder: torque for each radian  | 60
    k_2  | N m     | elbow: torque for each radian     | 25
    d_1  | N m s   | shoulder: damping                 | 6
    d_2  | N m s   | elbow: damping                    | 1.8
    aim_1 | deg    | shoulder, where the motor pulls   | -40
    aim_2 | deg    | elbow, where the motor pulls      | 75
    at_1 | deg     | shoulder at the start             | 60
    at_2 | deg     | elbow at the start                | 0
""")

m = Mechanism("manipulator", q, gravity=q.g, source="the example of the guide")
shoulder = m.coordinate("shoulder", "rad", "upper arm from the horizontal")
elbow = m.coordinate("elbow", "rad", "forearm from the upper arm")
upper = m.frame("upper", shoulder)
lower = m.frame("lower", elbow, parent=upper)
E = m.point("E", m.O, upper, q.l_1)
G = m.point("G", E, lower, q.l_2)

arm = m.body("upper arm", upper, q.m_1, m.point("C1", m.O, upper, q.c_1), q.J_1)
forearm = m.body("forearm", lower, q.m_2, m.point("C2", E, lower, q.c_2), q.J_2)
m.pin("O", arm, m.ground, m.O)
m.pin("E", forearm, arm, E)
M_1 = m.report(
    "M_1", "N m", "torque at the shoulder", q.k_1 * (q.aim_1 - shoulder) - q.d_1 * m.rate(shoulder)
)
M_2 = m.report(
    "M_2", "N m", "torque at the elbow", q.k_2 * (q.aim_2 - elbow) - q.d_2 * m.rate(elbow)
)
m.torque("shoulder", arm, m.ground, M_1)
m.torque("elbow", forearm, arm, M_2)
m.report("x_G", "m", "gripper, x", m.position(G)[0])
m.report("y_G", "m", "gripper, y", m.position(G)[1])

m.begin({shoulder: q.at_1, elbow: q.at_2})
SYSTEM = m.system()
