"""A loading bridge: a cart that is pushed, and a point mass that hangs on a rope without mass."""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall         | 9.81
    M   | kg   | cart              | 1.0
    m   | kg   | load              | 0.25
    l   | m    | rope              | 1.0
    f   | N    | force on the cart | 2
""")

m = Mechanism("loading_bridge", q, gravity=q.g)
x_M = m.coordinate("x_M", "m", "place of the cart")
phi = m.coordinate("phi", "rad", "rope from the vertical, anticlockwise")
rope = m.frame("rope", phi)
P = m.point("P", m.O, m.world, x_M)
B = m.point("B", P, rope, 0, -q.l)
cart, load = m.body("cart", m.world, q.M, P), m.body("load", rope, q.m, B)
m.slide("bridge", cart, m.ground, P)
m.pin("P", load, cart, P)
m.force("push", cart, P, m.vector(m.world, q.f))
m.begin({phi: 0.3})

SYSTEM = m.system()
