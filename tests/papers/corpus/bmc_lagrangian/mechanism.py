"""Five systems that do not touch: a block on a spring, a pendulum, a hanging block that is driven,
a bob, a plate.

The block slides on a level track; the pendulum is a mass on a rod; the hanging block has a spring,
a damper and a force that swings in time; the bob is a mass that a force along its line to the
origin holds, here a spring; the plate swings about a pin that is not its centroid.
"""

from sympy import Expr, cos

from derive import Mechanism, quantities
from derive.mechanics.frames import Point

q = quantities("""
    g     | m/s2  | free fall                                 | 10
    m     | kg    | mass of the block, the pendulum, the bob  | 1.3
    k     | N/m   | springs of the blocks                     | 40
    l_0   | m     | their lengths without load                | 0.3
    d     | m     | rod of the pendulum                       | 0.7
    b     | N s/m | damper of the hanging block               | 2
    F_0   | N     | size of the force on the hanging block    | 5
    w     | rad/s | its angular frequency                     | 3
    k_r   | N/m   | spring of the bob                         | 90
    r_0   | m     | its length without load                   | 0.6
    I     | kg m2 | plate about its pin                       | 0.9
    c     | m     | centroid of the plate from its pin        | 0.4
""")

m = Mechanism("lagrangian", q, gravity=q.g)


def kinetic_energy(at: Point) -> Expr:
    """Return the kinetic energy of a mass at a point."""
    return q.m * sum(component**2 for component in m.velocity(at).components) / 2


# The block on its track.
x = m.coordinate("x", "m", "place of the block")
block_at = m.point("block_at", m.O, m.world, x)
block = m.body("block", m.world, q.m, block_at)
m.slide("track", block, m.ground, block_at)
m.force("spring of the block", block, block_at, m.vector(m.world, -q.k * (x - q.l_0)))
m.report(
    "L_block",
    "N m",
    "Lagrangian of the block",
    kinetic_energy(block_at) - q.k * (x - q.l_0) ** 2 / 2,
)

# The pendulum.
theta = m.coordinate("theta", "rad", "pendulum from the vertical, anticlockwise")
rod = m.frame("rod", theta)
P = m.point("P", m.O, rod, 0, -q.d)
mass = m.body("mass", rod, q.m, P)
m.pin("rod", mass, m.ground, m.O)
m.report("T_rod", "N m", "kinetic energy of the pendulum", kinetic_energy(P))
m.report("V_rod", "N m", "potential energy of the pendulum", q.m * q.g * m.position(P)[1])
pull = m.motion.derivative(m.velocity(P)).resolved(rod)[1] + q.g * cos(theta)
m.report("F_rod", "N", "force of the rod on the mass, outward", -q.m * pull)

# The hanging block.
y = m.coordinate("y", "m", "height of the hanging block")
hanging_at = m.point("hanging_at", m.O, m.world, 0, y)
hanging = m.body("hanging", m.world, q.m, hanging_at)
m.slide("rail", hanging, m.ground, hanging_at, along=(0, 1, 0))
push = q.F_0 * cos(q.w * m.time) - q.b * m.rate(y) - q.k * (y - q.l_0)
m.force("push", hanging, hanging_at, m.vector(m.world, 0, push))
m.report("T_hanging", "N m", "kinetic energy of the hanging block", kinetic_energy(hanging_at))
m.report("V_hanging", "N m", "potential energy of it", q.m * q.g * y + q.k * (y - q.l_0) ** 2 / 2)

# The bob.
r, psi = (
    m.coordinate("r", "m", "distance of the bob"),
    m.coordinate("psi", "rad", "bob from the vertical"),
)
line = m.frame("line", psi)
Q = m.point("Q", m.O, line, 0, -r)
bob = m.body("bob", m.world, q.m, Q)
m.force("spring of the bob", bob, Q, m.vector(line, 0, q.k_r * (r - q.r_0)))
V_r = m.report("V_r", "N m", "energy of the bob's spring", q.k_r * (r - q.r_0) ** 2 / 2)
m.report("T_bob", "N m", "kinetic energy of the bob", kinetic_energy(Q))
m.report("V_bob", "N m", "potential energy of the bob", q.m * q.g * m.position(Q)[1] + V_r)

# The plate.
gamma = m.coordinate("gamma", "rad", "plate from the vertical")
hung = m.frame("hung", gamma)
S = m.point("S", m.O, hung, 0, -q.c)
plate = m.body("plate", hung, q.m, S, q.I - q.m * q.c**2)
m.pin("plate", plate, m.ground, m.O)
m.report("T_plate", "N m", "kinetic energy of the plate", q.I * m.rate(gamma) ** 2 / 2)
m.report("V_plate", "N m", "potential energy of the plate", q.m * q.g * m.position(S)[1])

m.begin({r: q.r_0})  # no motion follows from a bob at the origin
SYSTEM = m.system()
