"""A toggle press: a crank straightens two equal links by a rod; a ram below them bears the force of the work.

One function states it at a steady speed, and released on a motor with a flywheel, whose torque T may be an input.
"""

from derive import Mechanism, Release, ReleasedMechanism, Y, quantities

q = quantities("""
    phi   | rad   | crank angle, from phi_0
    omega | r/min | crank speed                 | 60
    g     | m/s2  | free fall                   | 9.81
    r     | mm    | crank                       | 50   | 35 60
    l     | mm    | rod                         | 300  | 290 330
    t     | mm    | each toggle link            | 250  | 230 270
    x_O   | mm    | crankshaft, from the ram's line | -340
    y_O   | mm    | crankshaft, below the fixed joint | -230
    m_s   | kg    | ram                         | 12
    F_w   | N     | force of the work           | 5000
    phi_0 | deg   | crank at the start          | 0
    J_f   | kg m2 | flywheel of the released press | 0.1
    T     | N m   | torque of its motor         | 0
""")


def state(m):
    """State the press for a mechanism that an angle drives, or for one that is released."""
    beta = m.coordinate("beta", "rad", "rod")
    upper, lower = (
        m.coordinate("upper", "rad", "upper link, from the fixed joint"),
        m.coordinate("lower", "rad", "lower link"),
    )
    s = m.coordinate("s", "m", "ram, below the fixed joint")
    crank, rod = m.frame("crank", q.phi + q.phi_0), m.frame("rod", beta)
    first, second = m.frame("upper link", upper), m.frame("lower link", lower)
    D = m.O
    Q = m.point("Q", m.O, m.world, q.x_O, q.y_O)
    A, K = m.point("A", Q, crank, q.r), m.point("K", D, first, q.t)
    B, C = m.point("B", A, rod, q.l), m.point("C", K, second, q.t)
    ram = m.point("ram", m.O, m.world, 0, -s)
    m.close(B, K, start={beta: 0, upper: -1.7})
    m.close(C, ram, start={lower: -1.4, s: 2 * q.t})

    wheel, bar = m.body("crank", crank), m.body("rod", rod)
    top, bottom = m.body("upper link", first), m.body("lower link", second)
    slide = m.body("ram", m.world, q.m_s, ram)
    m.pin("Q", wheel, m.ground, Q)
    m.pin("A", bar, wheel, A)
    m.pin("K", top, m.ground, D)
    m.pin("B", bar, top, K)
    m.pin("L", bottom, top, K)
    m.pin("C", slide, bottom, ram)
    m.slide("guide", slide, m.ground, ram, along=Y)
    m.force("work", slide, ram, m.vector(m.world, 0, q.F_w))
    m.motor("M_in", wheel, m.ground, Q)
    return m


SOURCE = "the example of the guide"
IDEAL = Mechanism("toggle_press", q, angle=q.phi, speed=q.omega, gravity=q.g, source=SOURCE)
RELEASED = ReleasedMechanism(
    "released_toggle_press",
    q,
    Release(motor=lambda speed: q.T, flywheel=q.J_f),
    angle=q.phi,
    speed=q.omega,
    gravity=q.g,
    source=SOURCE,
)
SYSTEMS = (lambda: state(IDEAL).system(), lambda: state(RELEASED).system())
