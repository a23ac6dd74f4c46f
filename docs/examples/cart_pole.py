"""A cart on a rail with a pole on a pin, moved by a force that is an input: for optimal control and controllers.

planter derive docs/examples/cart_pole.py && planter linearise cart_pole.toml --at rest
"""

from sympy import pi

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall                    | 9.81
    m_c | kg    | cart                         | 1
    d   | N s/m | damping of the cart          | 0.1
    m_p | kg    | pole                         | 0.3
    c   | m     | its centroid, from the pin   | 0.5
    J   | kg m2 | its inertia, centroidal      | 0.025
    a_0 | deg   | its angle at the start       | 0
""")
m = Mechanism("cart_pole", q, gravity=q.g)
s = m.coordinate("s", "m", "cart, along the rail")
a = m.coordinate("a", "rad", "pole, from hanging down")
F = m.input("F", "N", "force on the cart", low=-12, high=12)
P = m.point("P", m.O, m.world, s)
swung = m.frame("pole", a - pi / 2)
centroid = m.point("C", P, swung, q.c)

cart = m.body("cart", m.world, q.m_c, P)
pole = m.body("pole", swung, q.m_p, centroid, q.J)
m.slide("rail", cart, m.ground, P)
m.pin("A", pole, cart, P)
m.force("push", cart, P, m.vector(m.world, F - q.d * m.rate(s)))
m.begin({a: q.a_0})
m.report("height", "m", "centroid of the pole, above the rail", m.position(centroid)[1])
SYSTEM = m.system()
