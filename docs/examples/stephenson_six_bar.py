"""A Stephenson six-bar (III): a point of a four-bar's coupler drives a rocker by a second coupler."""

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                        | 90
    g     | m/s2  | free fall                          | 9.81
    a     | mm    | crank                              | 40   | 30 45
    b     | mm    | coupler                            | 120  | 110 130
    c     | mm    | rocker                             | 80   | 75 95
    d     | mm    | distance of the first two shafts   | 100  | 95 110
    p     | mm    | point of the coupler, along        | 75   | 60 100
    n     | mm    | point of the coupler, across       | 60   | 40 80
    f     | mm    | second coupler                     | 150  | 140 170
    h     | mm    | output arm                         | 120  | 110 140
    x_G   | mm    | shaft of the output, x             | 210
    y_G   | mm    | shaft of the output, y             | 40
    m_b   | kg    | coupler, centroid in its point     | 0.5
    J_b   | kg m2 | coupler                            | 0.0006
    T     | N m   | torque against the output          | 4
""")

m = Mechanism(
    "stephenson_six_bar",
    q,
    angle=q.phi,
    speed=q.omega,
    gravity=q.g,
    source="the example of the guide",
)
beta, gamma = m.coordinate("beta", "rad", "coupler"), m.coordinate("gamma", "rad", "rocker")
delta, chi = m.coordinate("delta", "rad", "second coupler"), m.coordinate("chi", "rad", "output")
crank, coupler, rocker = m.frame("crank", q.phi), m.frame("coupler", beta), m.frame("rocker", gamma)
second, output = m.frame("second coupler", delta), m.frame("output", chi)
A, D = m.point("A", m.O, crank, q.a), m.point("D", m.O, m.world, q.d)
G = m.point("G", m.O, m.world, q.x_G, q.y_G)
B, C = m.point("B", A, coupler, q.b), m.point("C", D, rocker, q.c)
E, H = m.point("E", A, coupler, q.p, q.n), m.point("H", G, output, q.h)
F = m.point("F", E, second, q.f)
m.close(B, C, start={beta: 0.4, gamma: 1.0})
m.close(F, H, start={delta: 0.5, chi: 1.2})

arm, rod = m.body("crank", crank), m.body("coupler", coupler, q.m_b, E, q.J_b)
lever, link, out = (
    m.body("rocker", rocker),
    m.body("second coupler", second),
    m.body("output", output),
)
m.pin("O", arm, m.ground, m.O)
m.pin("A", rod, arm, A)
m.pin("C", lever, rod, C)
m.pin("D", lever, m.ground, D)
m.pin("E", link, rod, E)
m.pin("H", out, link, H)
m.pin("G", out, m.ground, G)
m.torque("work", out, m.ground, -q.T)
m.motor("M_in", arm, m.ground, m.O)
SYSTEM = m.system()
