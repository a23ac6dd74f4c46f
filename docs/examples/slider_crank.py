"""An offset slider-crank: rod and slider with mass, gas above the slider, a return spring, friction in the guide."""

from sympy import exp, log

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                               | 300
    eps   | rad/s2 | acceleration of the crank                | 0
    g     | m/s2  | free fall, across the guide               | 9.81
    r     | mm    | crank                                     | 50     | 30 80
    l     | mm    | rod                                       | 200    | 150 260
    e     | mm    | offset of the guide                       | 10     | -20 20
    m_r   | kg    | mass of the rod                           | 0.8
    c     | mm    | centroid of the rod, from the crank pin   | 80
    J     | kg m2 | rod about its centroid                    | 0.004
    m_s   | kg    | mass of the slider                        | 1.5
    mu    | 1     | friction of the guide                     | 0.1
    k     | N/m   | stiffness of the return spring            | 900
    l_0   | mm    | length of the spring without load         | 150
    wall  | mm    | anchor of the spring, along the guide     | 400
    A     | m2    | area of the piston                        | 0.002
    p_0   | N/m2  | pressure over the outer one, at mid-stroke | 50000
    h     | mm    | height of the gas, at mid-stroke          | 120
    kappa | 1     | polytropic exponent                       | 1.3
""")

m = Mechanism(
    "slider_crank",
    q,
    angle=q.phi,
    speed=q.omega,
    acceleration=q.eps,
    gravity=q.g,
    source="the example of the guide",
)
beta, s = (
    m.coordinate("beta", "rad", "angle of the rod"),
    m.coordinate("s", "m", "place of the slider"),
)
crank, rod = m.frame("crank", q.phi), m.frame("rod", beta)
A, slot = m.point("A", m.O, crank, q.r), m.point("slot", m.O, m.world, s, q.e)
B, C = m.point("B", A, rod, q.l), m.point("C", A, rod, q.c)
anchor = m.point("anchor", m.O, m.world, q.wall, q.e)
m.close(B, slot, start={beta: 0, s: q.l + q.r})

wheel = m.body("crank", crank)
link = m.body("rod", rod, mass=q.m_r, centroid=C, inertia=q.J)
slider = m.body("slider", m.world, mass=q.m_s, centroid=slot)
m.pin("O", wheel, m.ground, m.O)
m.pin("A", link, wheel, A)
m.pin("B", slider, link, slot)
m.slide("guide", slider, m.ground, slot, friction=q.mu)
m.spring("spring", slider, m.ground, (slot, anchor), q.k, q.l_0)
gas = m.report(
    "F_gas",
    "N",
    "force of the gas on the slider",
    -q.A * q.p_0 * exp(-q.kappa * log(1 + (q.l - s) / q.h)),
)
m.force("gas", slider, slot, m.vector(m.world, gas))
m.motor("M_in", wheel, m.ground, m.O)

SYSTEM = m.system()
