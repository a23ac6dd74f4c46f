"""A crank-rocker: a crank turns, and a coupler swings a rocker to and fro against a load.

The shortest link, the crank, turns in full since a + b <= c + d (Grashof).
"""

from derive import Mechanism, quantities

# name | unit | meaning | value | bounds, where a search may change the value
q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                      | 60
    g     | m/s2  | free fall                        | 9.81
    a     | mm    | crank                            | 40   | 30 45
    b     | mm    | coupler                          | 120  | 110 130
    c     | mm    | rocker                           | 80   | 75 95
    d     | mm    | distance of the shafts           | 110  | 105 120
    m_b   | kg    | coupler, centroid in the middle  | 0.5
    J_b   | kg m2 | coupler                          | 0.0006
    m_c   | kg    | rocker, centroid in the middle   | 0.4
    J_c   | kg m2 | rocker                           | 0.0003
    T     | N m   | torque of the load on the rocker | 3
""")

m = Mechanism(
    "crank_rocker", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)

# Angles that the loop determines; frames turn by them, points are fixed in frames.
beta = m.coordinate("beta", "rad", "coupler")
gamma = m.coordinate("gamma", "rad", "rocker")
crank = m.frame("crank", q.phi)
coupler = m.frame("coupler", beta)
rocker = m.frame("rocker", gamma)
A = m.point("A", m.O, crank, q.a)
B = m.point("B", A, coupler, q.b)
D = m.point("D", m.O, m.world, q.d)
C = m.point("C", D, rocker, q.c)
m.close(B, C, start={beta: 0.7, gamma: 1.6})

# Bodies without a mass have none.
wheel = m.body("crank", crank)
rod = m.body("coupler", coupler, q.m_b, m.point("S", A, coupler, q.b / 2), q.J_b)
lever = m.body("rocker", rocker, q.m_c, m.point("R", D, rocker, q.c / 2), q.J_c)

# Joints and forces; a joint acts on its first body, and its reverse on the second.
m.pin("O", wheel, m.ground, m.O)
m.pin("A", rod, wheel, A)
m.pin("B", lever, rod, B)
m.pin("D", lever, m.ground, D)
m.torque("load", lever, m.ground, -q.T)
m.motor("M_in", wheel, m.ground, m.O)

SYSTEM = m.system()
