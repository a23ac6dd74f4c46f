"""A cart that is pushed and carries two point masses on rods without mass, one above the other."""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall         | 9.81
    u   | N    | force on the cart | 2
    M   | kg   | cart              | 1.2
    m_1 | kg   | lower mass        | 0.4
    m_2 | kg   | upper mass        | 0.3
    l_1 | m    | lower rod         | 0.7
    l_2 | m    | upper rod         | 0.5
""")

m = Mechanism("double_pendulum_on_cart", q, gravity=q.g)
x = m.coordinate("x", "m", "place of the cart")
theta_1 = m.coordinate("theta_1", "rad", "lower rod from the vertical, anticlockwise")
theta_2 = m.coordinate("theta_2", "rad", "upper rod from the vertical, anticlockwise")
lower, upper = m.frame("lower", theta_1), m.frame("upper", theta_2)
P = m.point("P", m.O, m.world, x)
A = m.point("A", P, lower, 0, q.l_1)
B = m.point("B", A, upper, 0, q.l_2)

cart = m.body("cart", m.world, q.M, P)
first, second = m.body("first", lower, q.m_1, A), m.body("second", upper, q.m_2, B)
m.slide("track", cart, m.ground, P)
m.pin("P", first, cart, P)
m.pin("A", second, first, A)
m.force("push", cart, P, m.vector(m.world, q.u))
m.begin({theta_1: 0.3, theta_2: -0.2})

SYSTEM = m.system()
