"""A vehicle in the plane with one wheel on each axle; the front one is steered, and tyres push
across their planes.

A tyre's force is its stiffness, which is negative, times its slip angle. What the text calls linear
is a second model: for small angles, at a constant speed ahead.
"""

from sympy import atan2

from derive import Mechanism, quantities

q = quantities("""
    m     | kg    | mass                             | 1500
    i_z   | kg m2 | vehicle about its centroid       | 2500
    l_f   | m     | front axle, ahead of it          | 1.2
    l_r   | m     | rear axle, behind it             | 1.5
    delta | rad   | steering angle                   | 0.1
    c_f   | N     | stiffness of the front tyre      | -60000
    c_r   | N     | stiffness of the rear tyre       | -70000
""")

m = Mechanism("single_track", q)
x, y = (
    m.coordinate("x", "m", "place of the centroid"),
    m.coordinate("y", "m", "place of the centroid"),
)
psi = m.coordinate("psi", "rad", "yaw angle")
car = m.frame("car", psi)
steered = m.frame("steered", q.delta, parent=car)
C = m.point("C", m.O, m.world, x, y)
F, R = m.point("F", C, car, q.l_f), m.point("R", C, car, -q.l_r)
vehicle = m.body("vehicle", car, q.m, C, q.i_z)

slips = {}
for name, wheel, at in (("F", steered, F), ("R", car, R)):
    for axis, way in (("x", m.vector(wheel, 1)), ("y", m.vector(wheel, 0, 1))):
        for side, component in zip("uv", way.resolved(car).components, strict=False):
            m.report(
                f"e_{axis}{name}_{side}",
                "1",
                "unit vector of a wheel along the vehicle's axes",
                component,
            )
    rolling, across, _ = m.velocity(at).resolved(wheel).components
    m.report(f"V_x{name}", "m/s", "speed of a wheel in its plane", rolling)
    m.report(f"V_y{name}", "m/s", "speed of a wheel across its plane", across)
    slips[name] = m.report(f"alpha_{name}", "rad", "slip angle", atan2(across, rolling))
    for axis, component in zip("uv", m.velocity(at).resolved(car).components, strict=False):
        m.report(
            f"{axis}_{name}", "m/s", "velocity of a wheel along the axes of the vehicle", component
        )
front = m.report("f_f", "N", "force of the front tyre", q.c_f * slips["F"])
rear = m.report("f_r", "N", "force of the rear tyre", q.c_r * slips["R"])
m.force("front", vehicle, F, m.vector(steered, 0, front))
m.force("rear", vehicle, R, m.vector(car, 0, rear))

u = m.report("u", "m/s", "speed ahead", m.velocity(C).resolved(car)[0])
v = m.report("v", "m/s", "speed to the left", m.velocity(C).resolved(car)[1])
r = m.rate(psi)

# For small angles, each slip is a quotient less the steering angle, and both forces push to the
# left of the vehicle.
small_f = m.report("small_f", "rad", "front slip, small", (v + q.l_f * r) / u - q.delta)
small_r = m.report("small_r", "rad", "rear slip, small", (v - q.l_r * r) / u)
linear_v = m.report(
    "linear_v",
    "m/s2",
    "rate of the speed to the left",
    (q.c_f * small_f + q.c_r * small_r) / q.m - u * r,
)
m.report("linear_beta", "rad/s", "rate of v over u, at a constant u", linear_v / u)
m.report(
    "linear_r",
    "rad/s2",
    "rate of the yaw rate",
    (q.l_f * q.c_f * small_f - q.l_r * q.c_r * small_r) / q.i_z,
)
m.begin({m.rate(x): 12})  # at rest no slip angle has a value
SYSTEM = m.system()
