"""A crank that spins down, its rod's pin loose in the slider, which rubs on its guide: a free motion with impacts.

The pin pushes on its bush by the law of Hunt and Crossley (J. Appl. Mech. 42, 1975).
"""

from sympy import Rational

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2    | free fall                       | 9.81
    r   | m       | crank                           | 0.05
    l   | m       | rod                             | 0.15
    m_c | kg      | crank with flywheel             | 5
    I_c | kg m2   | its moment of inertia           | 0.02
    m_r | kg      | rod                             | 0.4
    I_r | kg m2   | rod, about its centroid         | 9e-4
    m_s | kg      | slider                          | 0.8
    mu  | 1       | friction of the guide           | 0.1
    v_c | m/s     | speed below which friction creeps | 0.002
    c   | m       | radial clearance of the pin     | 2e-4
    K   | N/m1.5  | stiffness of pin and bush       | 4e9
    D   | s/m     | its damping                     | 0.8
    w_0 | rad/s   | crank speed at the start        | 40
""")
m = Mechanism("pin_clearance", q, gravity=q.g)
phi, psi = m.coordinate("phi", "rad", "crank angle"), m.coordinate("psi", "rad", "rod angle")
s = m.coordinate("s", "m", "slider's place")
m.begin({phi: 0, m.rate(phi): q.w_0, psi: 0, m.rate(psi): -q.w_0 * q.r / q.l, s: q.r + q.l - q.c})

crank, rod = m.frame("crank", phi), m.frame("rod", psi)
A = m.point("A", m.O, crank, q.r)
B = m.point("B", A, rod, q.l)
S = m.point("S", m.O, m.world, s)
cranking, coupling = (
    m.body("crank", crank, q.m_c, m.O, q.I_c),
    m.body("rod", rod, q.m_r, m.point("C", A, rod, q.l / 2), q.I_r),
)
slider = m.body("slider", m.world, q.m_s, S)
m.pin("O", cranking, m.ground, m.O)
m.pin("A", coupling, cranking, A)
m.slide("guide", slider, m.ground, S, friction=q.mu, creep=q.v_c)
m.compliant_contact(
    "pin",
    coupling,
    slider,
    B,
    S,
    lambda depth, rate: q.K * depth ** Rational(3, 2) * (1 + q.D * rate),
    radius=-q.c,
)
SYSTEM = m.system()
