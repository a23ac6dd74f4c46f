"""A cart on a horizontal track that carries two rods, one above the other, which gravity tips
over.
"""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall                                | 9.80665
    u   | N     | force on the cart                        | 2
    m_0 | kg    | cart                                     | 0.6
    m_1 | kg    | lower rod                                | 0.2
    m_2 | kg    | upper rod                                | 0.2
    L_1 | m     | lower rod                                | 0.5
    l_1 | m     | centroid of the lower rod                | 0.25
    l_2 | m     | centroid of the upper rod                | 0.25
    J_1 | kg m2 | lower rod about its centroid             | 0.004
    J_2 | kg m2 | upper rod about its centroid             | 0.004
""")

m = Mechanism("double_inverted_pendulum", q, gravity=q.g)
x = m.coordinate("x", "m", "place of the cart")
theta_1 = m.coordinate("theta_1", "rad", "lower rod from the vertical, clockwise")
theta_2 = m.coordinate("theta_2", "rad", "upper rod from the vertical, clockwise")
lower, upper = m.frame("lower", -theta_1), m.frame("upper", -theta_2)

P = m.point("P", m.O, m.world, x)
C1, E = m.point("C1", P, lower, 0, q.l_1), m.point("E", P, lower, 0, q.L_1)
C2 = m.point("C2", E, upper, 0, q.l_2)

cart = m.body("cart", m.world, q.m_0, P)
lower_rod = m.body("lower rod", lower, q.m_1, C1, q.J_1)
upper_rod = m.body("upper rod", upper, q.m_2, C2, q.J_2)
m.slide("track", cart, m.ground, P)
m.pin("P", lower_rod, cart, P)
m.pin("E", upper_rod, lower_rod, E)
m.force("push", cart, P, m.vector(m.world, q.u))
m.begin({theta_1: 0.3, theta_2: -0.5})

SYSTEM = m.system()
