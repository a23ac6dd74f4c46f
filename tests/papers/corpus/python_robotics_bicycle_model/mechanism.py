"""A vehicle with a steered front wheel: a frame that turns about a centre on the line of its rear
axle.
"""

from sympy import atan

from derive import Mechanism, quantities

q = quantities("""
    R | m | rear axle from the instantaneous centre | 8
    L | m | wheelbase                               | 2.5
""")

m = Mechanism("vehicle", q)
phi = m.coordinate("phi", "rad", "yaw angle")
car = m.frame("car", phi)
rear = m.point("rear", m.O, car, 0, -q.R)
front = m.point("front", rear, car, q.L)

velocity = m.velocity(rear).resolved(car)
direction = m.velocity(front).resolved(car)
m.name_("v", "m/s", "speed of the rear axle", velocity[0])
m.name_(
    "a",
    "m/s2",
    "acceleration of the rear axle, ahead",
    m.motion.derivative(m.velocity(rear)).resolved(car)[0],
)
m.name_(
    "delta",
    "rad",
    "steering angle, along the velocity of the front axle",
    atan(direction[1] / direction[0]),
)
