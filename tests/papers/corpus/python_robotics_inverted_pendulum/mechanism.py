"""A cart that is pushed and carries a point mass on a rod; its motion is also linearised about the
upright rod.
"""

import sympy as sp

from derive import Mechanism, quantities

q = quantities("""
    g | m/s2 | free fall          | 9.8
    M | kg   | cart               | 1.0
    m | kg   | mass on the rod    | 0.3
    l | m    | rod                | 2.0
    u | N    | force on the cart  | 1.5
""")

m = Mechanism("cart_pendulum", q, gravity=q.g)
x = m.coordinate("x", "m", "place of the cart")
theta = m.coordinate("theta", "rad", "rod from the vertical, anticlockwise")
rod = m.frame("rod", theta)
P = m.point("P", m.O, m.world, x)
B = m.point("B", P, rod, 0, q.l)
cart, bob = m.body("cart", m.world, q.M, P), m.body("bob", rod, q.m, B)
m.slide("track", cart, m.ground, P)
m.pin("P", bob, cart, P)
m.force("push", cart, P, m.vector(m.world, q.u))
m.begin({theta: 0.3})

# Linearised about the upright rod at rest without force.
states = (x, m.rate(x), theta, m.rate(theta))
upright = dict.fromkeys((*states, q.u), 0)
derivatives = (m.rate(x), m.accelerations()[0], m.rate(theta), m.accelerations()[1])
state_matrix = sp.Matrix(4, 4, lambda i, j: sp.diff(derivatives[i], states[j]).subs(upright))
input_matrix = sp.Matrix(4, 1, lambda i, _: sp.diff(derivatives[i], q.u).subs(upright))
linear = state_matrix * sp.Matrix(states) + input_matrix * q.u
m.report("x_ddot_near", "m/s2", "acceleration of the cart, linearised", linear[1])
m.report("theta_ddot_near", "rad/s2", "acceleration of the rod, linearised", linear[3])
m.report("A_23", "m/s2", "entry of the state matrix", state_matrix[1, 2])
m.report("A_43", "1/s2", "entry of the state matrix", state_matrix[3, 2])
m.report("B_2", "1/kg", "entry of the input matrix", input_matrix[1])
m.report("B_4", "1/kg/m", "entry of the input matrix", input_matrix[3])

SYSTEM = m.system()
