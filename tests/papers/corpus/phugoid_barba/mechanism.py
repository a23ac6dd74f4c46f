"""A glider without drag in a vertical plane: a mass, its weight, and a lift across its way that
grows as speed squared.

The trim speed is that at which the lift bears the weight. Depth is from the level at which the
glider would come to rest, for it keeps its energy. The radius of its way is the speed over the rate
at which the way turns.
"""

from sympy import atan2, sqrt

from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2  | free fall              | 9.81
    m   | kg    | mass                   | 3
    rho | kg/m3 | density of the air     | 1.2
    S   | m2    | area of the wings      | 0.5
    C_L | 1     | coefficient of lift    | 0.8
""")

m = Mechanism("phugoid", q, gravity=q.g)
x, y = m.coordinate("x", "m", "place, ahead"), m.coordinate("y", "m", "height")
P = m.point("P", m.O, m.world, x, y)
glider = m.body("glider", m.world, q.m, P)

square = m.rate(x) ** 2 + m.rate(y) ** 2
climb = atan2(m.rate(y), m.rate(x))
way = m.frame("way", climb)
lift = q.C_L * q.S * q.rho * square / 2
m.force("lift", glider, P, m.vector(way, 0, lift))
m.report("L", "N", "lift", lift)
m.report("W", "N", "weight", q.m * q.g)
for axis, part in zip(
    "tn", m.vector(m.world, 0, -q.m * q.g).resolved(way).components, strict=False
):
    m.report(f"W_{axis}", "N", "weight along the way and across it", part)
m.report("v", "m/s", "speed", sqrt(square))
m.report("v_t", "m/s", "trim speed", sqrt(2 * q.m * q.g / (q.C_L * q.S * q.rho)))
m.report("theta", "rad", "angle of climb", climb)
m.report("radius", "m", "radius of the way", sqrt(square) / m.motion.rate(climb))
m.report("depth", "m", "depth below the level of rest", square / 2 / q.g)
m.report("z_t", "m", "depth at the trim speed", q.m / (q.C_L * q.S * q.rho))
m.begin({m.rate(x): 6, m.rate(y): 2})  # at rest no way has a direction
SYSTEM = m.system()
