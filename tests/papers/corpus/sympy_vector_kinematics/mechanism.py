"""Frames in a chain, a body that carries a moving point, a disc in the plane, a double pendulum, a
bead on a ring.

Each of the text's drawings is a part of its own; a name of the text means what it is in the drawing
beside it.
"""

from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    l | m | length of a rod                 | 0.7
    R | m | radius of the disc, of the ring | 0.4
""")

m = Mechanism("vector_kinematics", q, spatial=True)
N = m.world

# Three turns, one after the other: about x, backwards about z, about y; the first body rests.
q_1, q_2, q_3 = (m.coordinate(f"q_{i}", "rad", "turn of the chain") for i in (1, 2, 3))
resting = m.frame("resting", 0)
once = m.frame("once", q_1, X, resting)
twice = m.frame("twice", -q_2, Z, once)
thrice = m.frame("thrice", q_3, Y, twice)

# A body that turns and moves in space: S and F are fixed in it, P moves through it.
yaw, pitch, roll = (
    m.coordinate(name, "rad", "turn of the body") for name in ("yaw", "pitch", "roll")
)
B = m.frame("B", roll, X, m.frame("pitched", pitch, Y, m.frame("yawed", yaw)))
s_x, s_y, s_z = (m.coordinate(f"s_{axis}", "m", "place of S") for axis in "xyz")
p_x, p_y = (
    m.coordinate("p_x", "m", "P from S, in the body"),
    m.coordinate("p_y", "m", "P from S, in the body"),
)
S = m.point("S", m.O, N, s_x, s_y, s_z)
F = m.point("F", S, B, q.l, q.R, q.l + q.R)
P = m.point("P", S, B, p_x, p_y, q.R)

for axis, component in zip("xyz", m.motion.spin(B).resolved(B).components, strict=True):
    m.name_(f"w_{axis}", "rad/s", "angular velocity of the body, along its own axis", component)

# A point in the plane.
q_x, q_y = (
    m.coordinate("q_x", "m", "place of a point"),
    m.coordinate("q_y", "m", "place of a point"),
)
free = m.point("free", m.O, N, q_x, q_y)

# A disc that moves and turns in the plane, with a point of its rim.
disc_x, disc_y = (
    m.coordinate("disc_x", "m", "centre of the disc"),
    m.coordinate("disc_y", "m", "centre of the disc"),
)
disc = m.frame("disc", m.coordinate("turn", "rad", "turn of the disc"))
centre = m.point("centre", m.O, N, disc_x, disc_y)
rim = m.point("rim", centre, disc, q.R)

# Two rods, one behind the other; both angles are from the world.
first = m.frame("first", m.coordinate("first_angle", "rad", "first rod"))
second = m.frame("second", m.coordinate("second_angle", "rad", "second rod"))
elbow = m.point("elbow", m.O, first, q.l)
tip = m.point("tip", elbow, second, q.l)

# A rod that turns about x carries a ring at its end, on which a bead runs.
rod = m.frame("rod", m.coordinate("swing", "rad", "turn of the rod"), X)
hub = m.point("hub", m.O, rod, 0, 0, -q.l)
bead = m.point(
    "bead", hub, m.frame("ring", m.coordinate("bead_angle", "rad", "bead on the ring"), Z, rod), q.R
)
