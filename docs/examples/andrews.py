"""Andrews' squeezing mechanism: seven bars, three loops, a spring; a motor turns the crank faster and faster.

W. Schiehlen (ed.), "Multibody Systems Handbook", Springer 1990; data and names as E. Hairer, G. Wanner, "Solving
Ordinary Differential Equations II", 2nd ed., Springer 1996, section VII.7, have them.
"""

from sympy import Float

from derive import Mechanism, quantities

q = quantities("""
    m1  | kg    | crank                                  | 0.04325
    m2  | kg    | first rod                              | 0.00365
    m3  | kg    | rocker with the spring                 | 0.02373
    m4  | kg    | rod of the upper rocker                | 0.00706
    m5  | kg    | upper rocker                           | 0.07050
    m6  | kg    | rod of the lower rocker                | 0.00706
    m7  | kg    | lower rocker                           | 0.05498
    i1  | kg m2 | crank                                  | 2.194e-6
    i2  | kg m2 | first rod                              | 4.410e-7
    i3  | kg m2 | rocker with the spring                 | 5.255e-6
    i4  | kg m2 | rod of the upper rocker                | 5.667e-7
    i5  | kg m2 | upper rocker                           | 1.169e-5
    i6  | kg m2 | rod of the lower rocker                | 5.667e-7
    i7  | kg m2 | lower rocker                           | 1.912e-5
    xa  | m     | A, hinge of both rockers               | -0.06934
    ya  | m     | A                                      | -0.00227
    xb  | m     | B, hinge of the rocker with the spring | -0.03635
    yb  | m     | B                                      | 0.03273
    xc  | m     | C, end of the spring                   | 0.014
    yc  | m     | C                                      | 0.072
    c0  | N/m   | stiffness of the spring                | 4530
    l0  | m     | length of the spring without load      | 0.07785
    mom | N m   | torque of the motor                    | 0.033
    rr  | m     | crank                                  | 0.007
    ra  | m     | centroid of the crank                  | 0.00092
    d   | m     | first rod                              | 0.028
    da  | m     | its centroid                           | 0.0115
    ss  | m     | rocker with the spring, E              | 0.035
    sa  | m     | its centroid, along                    | 0.01874
    sb  | m     | its centroid, across                   | 0.01043
    sc  | m     | place of the spring, along             | 0.018
    sd  | m     | place of the spring, across            | 0.02
    e   | m     | rod of the upper rocker                | 0.02
    ea  | m     | its centroid, from E                   | 0.01421
    zt  | m     | upper rocker                           | 0.04
    ta  | m     | its centroid, along                    | 0.02308
    tb  | m     | its centroid, across                   | 0.00916
    zf  | m     | rod of the lower rocker                | 0.02
    fa  | m     | its centroid, from E                   | 0.01421
    u   | m     | lower rocker                           | 0.04
    ua  | m     | its centroid, along                    | 0.01228
    ub  | m     | its centroid, across                   | 0.00449
""")

m = Mechanism("andrews", q, source="Hairer and Wanner 1996, section VII.7")
beta, Theta, gamma, Phi, delta, Omega, epsilon = (
    m.coordinate(name, "rad", f"angle {name}")
    for name in ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
)
k1, k3, k5, k7 = (
    m.frame("K1", beta),
    m.frame("K3", gamma),
    m.frame("K5", delta),
    m.frame("K7", epsilon),
)
k2, k4, k6 = (
    m.frame("K2", Theta, parent=k1),
    m.frame("K4", Phi, parent=k5),
    m.frame("K6", Omega, parent=k7),
)
A, B, C = (
    m.point(n, m.O, m.world, x, y)
    for n, x, y in (("A", q.xa, q.ya), ("B", q.xb, q.yb), ("C", q.xc, q.yc))
)
F, G, H = m.point("F", m.O, k1, q.rr), m.point("G", A, k5, q.zt), m.point("H", A, k7, 0, -q.u)
E, E3 = m.point("E", F, k2, -q.d), m.point("E3", B, k3, 0, -q.ss)
E4, E6 = m.point("E4", G, k4, 0, -q.e), m.point("E6", H, k6, q.zf)
start = {
    beta: "-0.0617138900142764496358948458001",
    gamma: "0.455279819163070380255912382449",
    Phi: "0.222668390165885884674473185609",
    delta: "0.487364979543842550225598953530",
    Omega: "-0.222668390165885884674473185609",
    epsilon: "1.23054744454982119249735015568",
}
for end in (E3, E4, E6):
    m.close(end, E, start={angle: Float(at) for angle, at in start.items()})

K1 = m.body("K1", k1, q.m1, m.point("C1", m.O, k1, q.ra), q.i1)
K2 = m.body("K2", k2, q.m2, m.point("C2", F, k2, -q.da), q.i2)
K3 = m.body("K3", k3, q.m3, m.point("C3", B, k3, q.sb, -q.sa), q.i3)
K4 = m.body("K4", k4, q.m4, m.point("C4", E4, k4, 0, q.ea), q.i4)
K5 = m.body("K5", k5, q.m5, m.point("C5", A, k5, q.ta, q.tb), q.i5)
K6 = m.body("K6", k6, q.m6, m.point("C6", E6, k6, -q.fa), q.i6)
K7 = m.body("K7", k7, q.m7, m.point("C7", A, k7, -q.ub, -q.ua), q.i7)
for name, on, by, at in (
    ("O", K1, m.ground, m.O),
    ("F", K2, K1, F),
    ("B", K3, m.ground, B),
    ("A5", K5, m.ground, A),
    ("A7", K7, m.ground, A),
    ("G", K4, K5, G),
    ("H", K6, K7, H),
    ("E3", K3, K2, E),
    ("E4", K4, K2, E),
    ("E6", K6, K2, E),
):
    m.pin(name, on, by, at)
m.spring("spring", K3, m.ground, (m.point("D", B, k3, q.sd, -q.sc), C), q.c0, q.l0)
m.torque("motor", K1, m.ground, q.mom)

SYSTEM = m.system()
