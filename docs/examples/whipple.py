"""The Whipple bicycle: two frames that a tilted steering axis joins, two thin wheels that roll without slip.

Names and data of the benchmark bicycle: J. P. Meijaard, J. M. Papadopoulos, A. Ruina, A. L. Schwab, "Linearized
dynamics equations for the balance and steer of a bicycle", Proc. R. Soc. A 463 (2007) 1955-1982, table 1: x forward,
y to the right, z down.
"""

from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    g    | m/s2  | free fall, along z                | 9.81
    v    | m/s   | speed                             | 5
    w    | m     | wheel base                        | 1.02
    c    | m     | trail                             | 0.08
    lam  | deg   | tilt of the steering axis         | 18
    rR   | m     | rear wheel                        | 0.3
    mR   | kg    | rear wheel                        | 2
    IRxx | kg m2 | rear wheel, across the axle       | 0.0603
    IRyy | kg m2 | rear wheel, about the axle        | 0.12
    xB   | m     | rear body and frame, forward      | 0.3
    zB   | m     | rear body and frame, down         | -0.9
    mB   | kg    | rear body and frame               | 85
    IBxx | kg m2 | rear body and frame               | 9.2
    IByy | kg m2 | rear body and frame               | 11
    IBzz | kg m2 | rear body and frame               | 2.8
    IBxz | kg m2 | rear body and frame               | 2.4
    xH   | m     | handlebar and fork, forward       | 0.9
    zH   | m     | handlebar and fork, down          | -0.7
    mH   | kg    | handlebar and fork                | 4
    IHxx | kg m2 | handlebar and fork                | 0.05892
    IHyy | kg m2 | handlebar and fork                | 0.06
    IHzz | kg m2 | handlebar and fork                | 0.00708
    IHxz | kg m2 | handlebar and fork                | -0.00756
    rF   | m     | front wheel                       | 0.35
    mF   | kg    | front wheel                       | 3
    IFxx | kg m2 | front wheel, across the axle      | 0.1405
    IFyy | kg m2 | front wheel, about the axle       | 0.28
""")

m = Mechanism("whipple", q, gravity=(0, 0, q.g), spatial=True, source="Meijaard et al. 2007")
x, y, z = (m.coordinate(n, "m", f"rear hub, {n}") for n in "xyz")
yaw, lean, pitch = (
    m.coordinate(n, "rad", f"{n} of the rear frame") for n in ("yaw", "lean", "pitch")
)
steer = m.coordinate("steer", "rad", "steer, of the fork against the frame")
rear_spin, front_spin = (
    m.coordinate("rear_spin", "rad", "rear wheel"),
    m.coordinate("front_spin", "rad", "front wheel"),
)

upright = m.frame("lean", lean, X, m.frame("yaw", yaw))
frame = m.frame("frame", pitch, Y, upright)
head = m.frame("head", steer, Z, m.frame("tilt", q.lam, Y, frame))
fork = m.frame("fork", -q.lam, Y, head)
R = m.point("R", m.O, m.world, x, y, z)
S = m.point("S", R, frame, q.w + q.c, 0, q.rR)  # where the steering axis meets the ground
F = m.point("F", S, fork, -q.c, 0, -q.rF)

rear = m.body("rear wheel", m.frame("rear", rear_spin, Y, frame), q.mR, R, (q.IRxx, q.IRyy, q.IRxx))
body = m.body(
    "rear frame",
    frame,
    q.mB,
    m.point("B", R, frame, q.xB, 0, q.zB + q.rR),
    (q.IBxx, q.IByy, q.IBzz, 0, q.IBxz, 0),
)
bars = m.body(
    "fork",
    fork,
    q.mH,
    m.point("H", S, fork, q.xH - q.w - q.c, 0, q.zH),
    (q.IHxx, q.IHyy, q.IHzz, 0, q.IHxz, 0),
)
front = m.body(
    "front wheel", m.frame("front", front_spin, Y, fork), q.mF, F, (q.IFxx, q.IFyy, q.IFxx)
)
m.wheel("rear", rear, R, q.rR, axle=Y, up=(0, 0, -1))
m.wheel("front", front, F, q.rF, axle=Y, up=(0, 0, -1))

rates = m.motion.rates
m.begin({z: -q.rR, rates[x]: q.v, rates[rear_spin]: -q.v / q.rR, rates[front_spin]: -q.v / q.rF})
SYSTEM = m.system(reported=["kinetic", "potential"])
