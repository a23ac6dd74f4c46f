"""Wheels of mobile robots: a frame that turns about an instantaneous centre, and the velocities of
points in it.

The rear axle lies on a line through the centre; the omnidirectional robots have their middle
elsewhere. Angles of wheels are directions of velocities, speeds of wheels are components along
them.
"""

from sympy import atan, atan2, cos, sin, sqrt

from derive import Mechanism, quantities
from derive.mechanics.frames import Point, Vec
from derive.quantity import Quantity

q = quantities("""
    R_b    | m   | rear axle from the instantaneous centre          | 2.0
    b      | m   | middle of an omnidirectional robot, ahead        | 0.3
    l      | m   | wheelbase                                        | 0.6
    w      | m   | wheel track of the differential drive            | 0.5
    w_r    | m   | rear wheel track                                 | 0.4
    w_f    | m   | front wheel track, between the kingpins          | 0.45
    d_kp   | m   | contact point of a front wheel from its kingpin  | 0.05
    R      | m   | wheels from the middle of the omniwheel robot    | 0.2
    r      | m   | radius of an omniwheel                           | 0.05
    gamma  | rad | first omniwheel                                  | 0.2
    step   | rad | from an omniwheel to the next                    | 0.9
    i      | 1   | number of an omniwheel                           | 3
    l_ix   | m   | swerve module, ahead of the middle               | 0.3
    l_iy   | m   | swerve module, left of the middle                | 0.2
""")

m = Mechanism("mobile_robot", q)
theta = m.coordinate("theta", "rad", "heading")
robot = m.frame("robot", theta)
rear = m.point("rear", m.O, robot, 0, -q.R_b)
middle = m.point("middle", m.O, robot, q.b, -q.R_b)


def velocity_in_robot(point: Point) -> Vec:
    """Return the velocity of a point along the axes of the robot."""
    return m.velocity(point).resolved(robot)


def rolling(name: str, at: Point, rolls: Vec) -> Quantity:
    """Name the speed of a point of a wheel along the direction in which the wheel rolls."""
    return m.name_(name, "m/s", "speed of a wheel", velocity_in_robot(at).dot(rolls))


def steering(name: str, axis: Point) -> Quantity:
    """Name the angle of a wheel from the direction in which its steering axis moves."""
    forward, left, _ = velocity_in_robot(axis).components
    return m.name_(name, "rad", "steering angle", atan(left / forward))


ahead = m.vector(robot, 1)
v_bx = m.name_("v_bx", "m/s", "speed of the rear axle", velocity_in_robot(rear)[0])
omega_bz = m.name_("omega_bz", "rad/s", "yaw rate", m.rate(theta))

# Differential drive, and the rear axle with two wheels.
for side, sign in (("left", 1), ("right", -1)):
    rolling(f"v_{side}", m.point(f"{side} wheel", rear, robot, 0, sign * q.w / 2), ahead)
    rolling(f"v_rear_{side}", m.point(f"rear {side}", rear, robot, 0, sign * q.w_r / 2), ahead)

# One steered wheel in front, and two with their contact points outside of the kingpins.
front = m.point("front", rear, robot, q.l)
phi = steering("phi", front)
rolling("v_front", front, m.vector(robot, cos(phi), sin(phi)))
for side, sign in (("left", 1), ("right", -1)):
    kingpin = m.point(f"{side} kingpin", rear, robot, q.l, sign * q.w_f / 2)
    angle = steering(f"phi_{side}", kingpin)
    out = sign * q.d_kp
    # The contact point moves with the robot while the steering angle is constant.
    contact = m.point(f"{side} contact", kingpin, robot, -out * sin(angle), out * cos(angle))
    rolling(f"v_front_{side}", contact, m.vector(robot, cos(angle), sin(angle)))
    m.name_(
        f"R_{side}",
        "m",
        "contact point from the instantaneous centre",
        sqrt(m.position(contact).dot(m.position(contact))),
    )

# Omnidirectional robots: a wheel with rollers turns by the velocity along its rim, a swerve module
# follows its own.
v_mx = m.name_("v_mx", "m/s", "velocity of the middle, ahead", velocity_in_robot(middle)[0])
v_my = m.name_("v_my", "m/s", "velocity of the middle, to the left", velocity_in_robot(middle)[1])
at = q.gamma + (q.i - 1) * q.step
omniwheel = m.point("omniwheel", middle, robot, q.R * cos(at), q.R * sin(at))
m.name_(
    "omega_i",
    "rad/s",
    "speed of an omniwheel",
    velocity_in_robot(omniwheel).dot(m.vector(robot, sin(at), -cos(at))) / q.r,
)
module = m.point("module", middle, robot, q.l_ix, q.l_iy)
m.name_("v_ix", "m/s", "velocity of a swerve module, ahead", velocity_in_robot(module)[0])
m.name_("v_iy", "m/s", "velocity of a swerve module, to the left", velocity_in_robot(module)[1])
m.name_(
    "phi_i",
    "rad",
    "steering angle of a swerve module",
    atan2(*velocity_in_robot(module).components[1::-1]),
)
