"""A Watt six-bar: the rocker of a four-bar drives a second one. The first is that of Norton's example 4-1."""

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                        | 90
    g     | m/s2  | free fall                          | 9.81
    a     | mm    | crank                              | 40   | 30 45
    b     | mm    | coupler                            | 120  | 110 130
    c     | mm    | rocker                             | 80   | 75 95
    d     | mm    | distance of the first two shafts   | 100  | 95 110
    e     | mm    | second arm of the rocker           | 60
    f     | mm    | second coupler                     | 140
    h     | mm    | output arm                         | 90
    x_G   | mm    | shaft of the output, x             | 230
    m_b   | kg    | coupler, centroid in the middle    | 0.5
    J_b   | kg m2 | coupler                            | 0.0006
    T     | N m   | torque against the output          | 4
""")

m = Mechanism(
    "watt_six_bar", q, angle=q.phi, speed=q.omega, gravity=q.g, source="the example of the guide"
)
beta, gamma = m.coordinate("beta", "rad", "coupler"), m.coordinate("gamma", "rad", "rocker")
delta, chi = m.coordinate("delta", "rad", "second coupler"), m.coordinate("chi", "rad", "output")
crank, coupler, rocker = m.frame("crank", q.phi), m.frame("coupler", beta), m.frame("rocker", gamma)
second, output = m.frame("second coupler", delta), m.frame("output", chi)
A, D, G = (
    m.point("A", m.O, crank, q.a),
    m.point("D", m.O, m.world, q.d),
    m.point("G", m.O, m.world, q.x_G),
)
B, C = m.point("B", A, coupler, q.b), m.point("C", D, rocker, q.c)
E, H = m.point("E", D, rocker, 0, -q.e), m.point("H", G, output, q.h)
F = m.point("F", E, second, q.f)
m.close(B, C, start={beta: 0.4, gamma: 1.0})
m.close(F, H, start={delta: 0.3, chi: 1.2})

arm, rod = (
    m.body("crank", crank),
    m.body("coupler", coupler, q.m_b, m.point("S", A, coupler, q.b / 2), q.J_b),
)
lever, link, out = (
    m.body("rocker", rocker),
    m.body("second coupler", second),
    m.body("output", output),
)
m.pin("O", arm, m.ground, m.O)
m.pin("A", rod, arm, A)
m.pin("C", lever, rod, C)
m.pin("D", lever, m.ground, D)
m.pin("E", link, lever, E)
m.pin("H", out, link, H)
m.pin("G", out, m.ground, G)
m.torque("work", out, m.ground, -q.T)
m.motor("M_in", arm, m.ground, m.O)
SYSTEM = m.system()
