"""A double pendulum of two point masses on massless rods; angles are from the vertical
downwards.
"""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall  | 9.8
    m_1 | kg   | upper mass | 1.2
    m_2 | kg   | lower mass | 0.8
    l_1 | m    | upper rod  | 1.1
    l_2 | m    | lower rod  | 0.7
""")

m = Mechanism("double_pendulum", q, gravity=q.g)
theta_1 = m.coordinate("theta_1", "rad", "upper rod from the vertical, anticlockwise")
theta_2 = m.coordinate("theta_2", "rad", "lower rod from the vertical, anticlockwise")
first, second = m.frame("first", theta_1), m.frame("second", theta_2)
A = m.point("A", m.O, first, 0, -q.l_1)
B = m.point("B", A, second, 0, -q.l_2)
upper, lower = m.body("upper", first, q.m_1, A), m.body("lower", second, q.m_2, B)
m.pin("O", upper, m.ground, m.O)
m.pin("A", lower, upper, A)
m.begin({theta_1: 0.7, theta_2: -0.4})

# Momenta are the derivatives of the kinetic energy to the rates.
kinetic = sum(
    mass * sum(v**2 for v in m.velocity(at).components) / 2 for mass, at in ((q.m_1, A), (q.m_2, B))
)
m.report("p_1", "N m s", "momentum of the upper angle", kinetic.diff(m.rate(theta_1)))
m.report("p_2", "N m s", "momentum of the lower angle", kinetic.diff(m.rate(theta_2)))

SYSTEM = m.system()
