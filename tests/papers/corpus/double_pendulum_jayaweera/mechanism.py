"""A double pendulum of two point masses on massless rods, and a single one; angles are from the
upward vertical.
"""

from derive import Mechanism, quantities

q = quantities("""
    g    | m/s2 | free fall              | 9.8
    m_1  | kg   | upper mass             | 1.1
    m_2  | kg   | lower mass             | 0.9
    l_1  | m    | upper rod              | 1.2
    l_2  | m    | lower rod              | 0.8
    m    | kg   | mass of the single one | 1.3
    L    | m    | rod of the single one  | 0.7
""")

m = Mechanism("double_pendulum", q, gravity=q.g)
theta_1 = m.coordinate("theta_1", "rad", "upper rod from the vertical upwards, clockwise")
theta_2 = m.coordinate("theta_2", "rad", "lower rod from the vertical upwards, clockwise")
theta = m.coordinate("theta", "rad", "rod of the single pendulum from the vertical downwards")
first, second, single = (
    m.frame("first", -theta_1),
    m.frame("second", -theta_2),
    m.frame("single", theta),
)
A = m.point("A", m.O, first, 0, q.l_1)
B = m.point("B", A, second, 0, q.l_2)
D = m.point("D", m.O, single, 0, -q.L)

upper, lower = m.body("upper", first, q.m_1, A), m.body("lower", second, q.m_2, B)
alone = m.body("alone", single, q.m, D)
m.pin("O", upper, m.ground, m.O)
m.pin("A", lower, upper, A)
m.pin("D", alone, m.ground, m.O)
m.begin({theta_1: 2.5, theta_2: 2.0, theta: 0.4})


def energies(*masses: tuple) -> tuple:
    """Return the kinetic energy of point masses, and the potential one."""
    kinetic = sum(
        mass * sum(v**2 for v in m.velocity(point).components) / 2 for mass, point in masses
    )
    return kinetic, sum(mass * q.g * m.position(point)[1] for mass, point in masses)


T, U = energies((q.m_1, A), (q.m_2, B))
T_D, U_D = energies((q.m, D))
m.report("T_2", "J", "kinetic energy of the double pendulum", T)
m.report("U_2", "J", "potential energy of the double pendulum", U)
m.report("T_1", "J", "kinetic energy of the single pendulum", T_D)
m.report(
    "U_1",
    "J",
    "potential energy of the single pendulum, from its lowest place",
    U_D + q.m * q.g * q.L,
)

SYSTEM = m.system()
