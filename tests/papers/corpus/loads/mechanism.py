"""Two forces in space with their moments about two points, and a ball's lowest point that dips
below a plane.
"""

from sympy import Piecewise

from derive import Mechanism, quantities

q = quantities("""
    F_1x | N   | first force, x                       | 2
    F_1y | N   | first force, y                       | 3
    F_1z | N   | first force, z                       | -1
    F_2x | N   | second force, x                      | -4
    F_2y | N   | second force, y                      | 5
    F_2z | N   | second force, z                      | 2
    a    | m   | first force's point, x               | 2
    b    | m   | second force's point, y              | 3
    far  | s2/kg | along the line of the first force  | 0.7
    dist | m   | from P to Q                          | 5
""")

m = Mechanism("loads", q, spatial=True)
x, y, z = (m.coordinate(name, "m", f"point P, {name}") for name in "xyz")

N, O = m.world, m.O  # noqa: E741
P = m.point("P", O, N, x, y, z)
Q = m.point("Q", P, N, q.dist, -q.dist, 2 * q.dist)
L_1, L_2 = m.point("L_1", O, N, q.a), m.point("L_2", O, N, 0, q.b)
L = m.point(
    "L", L_1, N, q.far * q.F_1x, q.far * q.F_1y, q.far * q.F_1z
)  # on the line of the first force
m.name_("depth", "m", "depth of P below the plane", Piecewise((-z, z < 0), (0, True)))
