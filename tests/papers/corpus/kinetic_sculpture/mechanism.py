"""A kinetic sculpture: a support turns about the vertical, a plate about its arm, and a pigeon
walks the plate.
"""

from derive import Mechanism, X, quantities

q = quantities("""
    h | m | height of the support         | 5
    d | m | support to the axis of plates | 0.5
    w | m | along the plate               | 1
    c | m | axis to the plate's edge      | 0.6
    l | m | length of the plate           | 2
""")

m = Mechanism("kinetic_sculpture", q, spatial=True)
alpha, beta = (
    m.coordinate("alpha", "rad", "turn of the support"),
    m.coordinate("beta", "rad", "turn of the plate"),
)
walk = m.coordinate("walk", "m", "way of the pigeon along the edge")

N = m.world
A = m.frame("A", alpha)
B = m.frame("B", beta, X, A)
O = m.O  # noqa: E741
P = m.point("P", O, N, 0, 0, q.h)
S = m.point("S", P, A, -q.d)
Q = m.point("Q", S, B, -q.w, 0, -q.c - q.l / 2)
R = m.point("R", Q, B, walk, 0, q.l)
B_c = m.point("B_c", S, B, -q.w / 2, 0, -q.c)
