"""A robot on two driven wheels: a DC motor through a gear on either side, no slip, a plane rigid
body.

Each motor has its own back voltage; a wheel pushes the robot with the torque of its shaft over its
radius. The point of the robot that is half-way between its wheels is its centroid. Currents are
numbers of amperes, so that a voltage is a power.
"""

from sympy import Expr

from derive import Mechanism, quantities
from derive.mechanics.frames import Point

q = quantities("""
    m   | kg          | mass of the robot                           | 50
    J   | kg m2       | robot about its centroid                    | 6
    r_b | m           | wheel from the centroid                     | 0.35
    r   | m           | radius of a wheel                           | 0.08
    K_t | N m         | torque of a motor per current               | 0.02
    K_v | rad/s/W     | speed of a motor per voltage                | 45
    R   | W           | resistance of a motor                       | 0.11
    G   | 1           | gear of a single motor                      | 8
    G_l | 1           | gear, left                                  | 7
    G_r | 1           | gear, right                                 | 9
    V   | W           | voltage of a single motor                   | 6
    omega | rad/s     | speed of the shaft of a single motor's gear | 11
    V_l | W           | voltage, left                               | 5
    V_r | W           | voltage, right                              | 8
""")

m = Mechanism("differential_drive", q)
x, y = (
    m.coordinate("x", "m", "place of the centroid"),
    m.coordinate("y", "m", "place of the centroid"),
)
theta = m.coordinate("theta", "rad", "heading, anticlockwise")
robot = m.frame("robot", theta)
C = m.point("C", m.O, m.world, x, y)
left, right = m.point("left", C, robot, 0, q.r_b), m.point("right", C, robot, 0, -q.r_b)
robot_body = m.body("robot", robot, q.m, C, q.J)

# The wheels do not slip sideways; forward, each of their hubs moves with the speed of its side.
ahead = m.vector(robot, 1)


def speed_ahead(point: Point) -> Expr:
    """Return the speed of a point along the robot."""
    return m.velocity(point).resolved(robot)[0]


m.roll("axle", m.velocity(C).resolved(robot)[1])
v_l = m.report("v_l", "m/s", "speed of the robot at its left wheel", speed_ahead(left))
v_r = m.report("v_r", "m/s", "speed of the robot at its right wheel", speed_ahead(right))
m.report("v", "m/s", "speed of the centroid", speed_ahead(C))


def shaft_torque(gear: Expr, voltage: Expr, speed: Expr) -> Expr:
    """Return the torque of a motor behind its gear: the current is what the back voltage leaves of
    the voltage.
    """
    current = (voltage - gear * speed / q.K_v) / q.R
    return gear * q.K_t * current


m.report("tau", "N m", "torque of a single motor's gear", shaft_torque(q.G, q.V, q.omega))
m.report("F", "N", "force of a wheel on that gear", shaft_torque(q.G, q.V, q.omega) / q.r)
forces = {}
for side, gear, voltage, speed, first in (("l", q.G_l, q.V_l, v_l, 1), ("r", q.G_r, q.V_r, v_r, 3)):
    push = shaft_torque(gear, voltage, speed / q.r) / q.r
    forces[side] = m.report(f"F_{side}", "N", "force of a wheel", push)
    m.report(f"C_{first}", "N s/m", "force per speed", push.diff(speed))
    m.report(f"C_{first + 1}", "N/W", "force per voltage", push.diff(voltage))
m.force("left", robot_body, left, forces["l"] * ahead)
m.force("right", robot_body, right, forces["r"] * ahead)
SYSTEM = m.system()
