"""A four-bar linkage with a torque on its first bar: a chain of two bars, and a third bar that
closes the loop.
"""

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall                        | 9.81
    u_1 | N m   | torque on the first bar          | 0.5
    s_1 | m     | centroid of the first bar        | 0.5
    s_2 | m     | centroid of the second bar       | 0.75
    s_3 | m     | centroid of the third bar        | 0.75
    m_1 | kg    | first bar                        | 1.0
    m_2 | kg    | second bar                       | 1.5
    m_3 | kg    | third bar                        | 1.2
    J_1 | kg m2 | first bar about its centroid     | 0.083
    J_2 | kg m2 | second bar about its centroid    | 0.5
    J_3 | kg m2 | third bar about its centroid     | 0.4
    l_1 | m     | first bar                        | 0.8
    l_2 | m     | second bar                       | 1.5
    l_3 | m     | third bar                        | 1.5
    l_4 | m     | distance of the bearings         | 2.0
""")

m = Mechanism("four_bar", q, gravity=q.g)
x_3 = m.coordinate("x_3", "rad", "first bar")
x_1 = m.coordinate("x_1", "rad", "second bar from the first one")
x_2 = m.coordinate("x_2", "rad", "third bar")
first = m.frame("first", x_3)
second, third = m.frame("second", x_1, parent=first), m.frame("third", x_2)
A, C1 = m.point("A", m.O, first, q.l_1), m.point("C1", m.O, first, q.s_1)
B, C2 = m.point("B", A, second, q.l_2), m.point("C2", A, second, q.s_2)
D = m.point("D", m.O, m.world, q.l_4)
B_3, C3 = m.point("B_3", D, third, q.l_3), m.point("C3", D, third, q.s_3)
m.close(B, B_3, start={x_1: -0.9, x_2: 1.6})

bars = [
    m.body(name, frame, mass, centroid, inertia)
    for name, frame, mass, centroid, inertia in (
        ("first bar", first, q.m_1, C1, q.J_1),
        ("second bar", second, q.m_2, C2, q.J_2),
        ("third bar", third, q.m_3, C3, q.J_3),
    )
]
m.pin("O", bars[0], m.ground, m.O)
m.pin("A", bars[1], bars[0], A)
m.pin("B", bars[1], bars[2], B)
m.pin("D", bars[2], m.ground, D)
m.torque("drive", bars[0], m.ground, q.u_1)
m.begin({x_3: 1.0})

SYSTEM = m.system()
