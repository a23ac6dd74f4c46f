"""Segments of a human body in a vertical plane: one on a fixed joint, and a chain of two; a force
pulls at their ends.

Angles are from the horizontal, anticlockwise, that of the second segment of the chain from the
first one. Muscles turn a segment against the one that carries it.
"""

from derive import Mechanism, quantities

q = quantities("""
    g     | m/s2  | free fall                                     | 9.81
    m     | kg    | single segment                                | 3
    L     | m     | length of the single segment                  | 0.5
    d     | m     | its centroid from its joint                   | 0.2
    I     | kg m2 | single segment about its centroid             | 0.06
    T     | N m   | torque of its muscles                         | 9
    F_ex  | N     | force at the end, forward                     | 7
    F_ey  | N     | force at the end, upward                      | -4
    m_1   | kg    | first segment of the chain                    | 2.5
    m_2   | kg    | second segment                                | 1.5
    L_1   | m     | length of the first segment                   | 0.4
    L_2   | m     | length of the second segment                  | 0.3
    d_1   | m     | centroid of the first segment from its joint  | 0.17
    d_2   | m     | centroid of the second segment from its joint | 0.13
    I_1   | kg m2 | first segment about its centroid              | 0.04
    I_2   | kg m2 | second segment about its centroid             | 0.02
    T_1   | N m   | torque of the muscles at the first joint      | 6
    T_2   | N m   | torque of the muscles at the second joint     | 3
""")

m = Mechanism("segments", q, gravity=q.g)
pull = m.vector(m.world, q.F_ex, q.F_ey)

alpha = m.coordinate("alpha", "rad", "single segment from the horizontal")
limb = m.frame("limb", alpha)
C = m.point("C", m.O, limb, q.d)
E = m.point("E", m.O, limb, q.L)
segment = m.body("segment", limb, q.m, C, q.I)
m.pin("r", segment, m.ground, m.O)
m.torque("muscles", segment, m.ground, q.T)
m.force("pull", segment, E, pull)

# The Jacobian is the derivative of the end's place by the angle; the pull has its own moment about
# the joint.
for axis, component in zip("xy", m.position(E).components, strict=False):
    slope = component.diff(alpha)
    m.report(f"J_{axis}", "m", "end, by the angle", slope)
    m.report(f"J_{axis}dot", "m/s", "its rate", m.rate(slope))
m.report("M_pull", "N m", "moment of the pull about the joint", m.position(E).cross(pull)[2])

alpha_1 = m.coordinate("alpha_1", "rad", "first segment from the horizontal")
alpha_2 = m.coordinate("alpha_2", "rad", "second segment from the first")
first = m.frame("first", alpha_1)
second = m.frame("second", alpha_2, parent=first)
joint = m.point("joint", m.O, first, q.L_1)
C_1, C_2 = m.point("C_1", m.O, first, q.d_1), m.point("C_2", joint, second, q.d_2)
hand = m.point("hand", joint, second, q.L_2)
upper, lower = m.body("upper", first, q.m_1, C_1, q.I_1), m.body("lower", second, q.m_2, C_2, q.I_2)
m.pin("r1", upper, m.ground, m.O)
m.pin("r2", lower, upper, joint)
m.torque("muscles 1", upper, m.ground, q.T_1)
m.torque("muscles 2", lower, upper, q.T_2)
m.force("pull 2", lower, hand, pull)

SYSTEM = m.system()
