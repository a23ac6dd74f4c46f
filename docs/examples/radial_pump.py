"""A radial pump: three cylinders around one crank pin, each with its own piston and load, stated in a loop."""

import sympy as sp

from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed                 | 600
    r     | mm    | crank                       | 20  | 10 30
    l     | mm    | connecting rods             | 90  | 70 120
    m_1   | kg    | first piston                | 0.6
    m_2   | kg    | second piston               | 0.6
    m_3   | kg    | third piston, a larger one  | 0.9
    F_1   | N     | first piston, delivering    | 400
    F_2   | N     | second piston, delivering   | 400
    F_3   | N     | third piston, delivering    | 600
""")

m = Mechanism("radial_pump", q, angle=q.phi, speed=q.omega, source="the example of the guide")
crank = m.frame("crank", q.phi)
A = m.point("A", m.O, crank, q.r)
wheel = m.body("crank", crank)
m.pin("O", wheel, m.ground, m.O)

for k in (1, 2, 3):
    line = m.frame(f"line{k}", 2 * sp.pi * (k - 1) / 3)
    x, y = m.position(A, line)[:2]
    beta = m.coordinate(f"beta{k}", "rad", f"rod {k} from its cylinder", equals=-sp.asin(y / q.l))
    s = m.coordinate(f"s{k}", "m", f"place of piston {k}", equals=x + q.l * sp.cos(beta))
    B = m.point(f"B{k}", m.O, line, s)
    rod, piston = (
        m.body(f"rod{k}", m.frame(f"rod{k}", beta, parent=line)),
        m.body(f"piston{k}", line, q[f"m_{k}"], B),
    )
    m.pin(f"A{k}", rod, wheel, A)
    m.pin(f"B{k}", piston, rod, B)
    barrel = m.body(f"barrel{k}", line)
    m.weld(f"W{k}", barrel, m.ground, m.O)
    m.slide(f"guide{k}", piston, barrel, B, origin=m.O)
    load = sp.Piecewise((-q[f"F_{k}"], m.rate(s) > 0), (0, True))
    m.force(f"load{k}", piston, B, m.vector(line, load))
m.motor("M_in", wheel, m.ground, m.O)
SYSTEM = m.system()
