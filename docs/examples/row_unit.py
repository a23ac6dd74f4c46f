"""A row unit of a planter that drops onto the soil: an arm with a strut that stiffens, a compliant tyre.

The soil pushes by the law of Hunt and Crossley, K d^(3/2) (1 + D d_dot), and holds back what slides on it; the strut's
pull grows with the cube of its stretch, and its damper with the square of the speed.
"""

from sympy import Abs, Rational

from derive import Mechanism, quantities

q = quantities("""
    g     | m/s2  | free fall                       | 9.81
    l     | mm    | arm, from its pin to the wheel  | 600   | 500 700
    h     | mm    | pin, over the soil              | 350   | 300 400
    m_u   | kg    | unit, at the wheel              | 45    | 30 60
    J     | kg m2 | unit                            | 1.5
    y_s   | mm    | anchor of the strut, over the pin | 250
    l_0   | mm    | strut without load              | 480
    c     | mm    | strut on the arm, from the pin  | 350
    k_3   | N/m3  | stiffening of the strut         | 200000
    d_2   | N s2/m2 | damper of the strut           | 300
    K     | N/m1.5 | soil and tyre                  | 400000
    D     | s/m   | their losses                    | 0.4
    mu    | 1     | friction on the soil            | 0.4
    v_c   | m/s   | creep of the friction           | 0.01
    s_0   | deg   | arm at the start                | -20
""")

m = Mechanism("row_unit", q, gravity=q.g, source="the example of the guide")
theta = m.coordinate("theta", "rad", "arm")
m.begin({theta: q.s_0})
arm = m.frame("arm", theta)
wheel = m.point("wheel", m.O, arm, q.l)
unit = m.body("unit", arm, q.m_u, wheel, q.J)
m.pin("O", unit, m.ground, m.O)
ends = m.point("S", m.O, arm, q.c), m.point("anchor", m.O, m.world, 0, q.y_s)
m.strut(
    "strut",
    unit,
    m.ground,
    ends,
    lambda s, rate: q.k_3 * (s - q.l_0) ** 3 + q.d_2 * rate * Abs(rate),
)
soil = m.point("soil", m.O, m.world, 0, -q.h)
m.compliant_contact(
    "soil",
    unit,
    m.ground,
    wheel,
    soil,
    lambda depth, rate: q.K * depth ** Rational(3, 2) * (1 + q.D * rate),
    friction=q.mu,
    creep=q.v_c,
)
m.report("y_wheel", "m", "wheel's height over the pin", m.position(wheel)[1])
SYSTEM = m.system()
