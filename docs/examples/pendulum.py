"""A free pendulum: a rod on a hinge, which a damper slows, released from an angle."""

from derive import Mechanism, quantities

# name | unit | meaning | value
q = quantities("""
    g     | m/s2  | free fall                             | 9.81
    l     | mm    | centroid of the rod, from the hinge   | 250
    m     | kg    | rod                                   | 0.8
    J     | kg m2 | rod, about its centroid               | 0.017
    k     | N m s | damping of the hinge                  | 0.005
    start | deg   | angle from the vertical at the start  | 60
""")

# Nothing drives it: without `angle=` the coordinates are degrees of freedom.
m = Mechanism("pendulum", q, gravity=q.g, source="the example of the guide")
alpha = m.coordinate("alpha", "rad", "angle from the vertical")
rod = m.frame("rod", alpha)
C = m.point("C", m.O, rod, 0, -q.l)

bob = m.body("rod", rod, q.m, C, q.J)
m.pin("O", bob, m.ground, m.O)
M_d = m.report("M_d", "N m", "torque of the damper", -q.k * m.rate(alpha))
m.torque("damper", bob, m.ground, M_d)

m.begin({alpha: q.start})
SYSTEM = m.system()
