"""Two equal ellipses that roll about a focus each: formulas along an angle, and an invented paper about them."""

from sympy import atan2, cos, sin, sqrt

from derive import Formulas, Paper, quantities, trial, what

q = quantities("""
    A | mm  | half the long axis                       | 21   | 15 30
    k | 1   | eccentricity                             | 0.14 | 0.05 0.5
    t | rad | driver, from its long side               | 0.7  | 0.1 3
    n | r/min | speed of the driver                    | 90
    a | m   | distance of the shafts
    f | m   | distance of the foci
    b | m   | half the short axis
    r | m   | pitch radius of the driver
    i | 1   | how fast the mate turns, for the driver
    T | rad | how far the mate has turned
    W | rad/s | speed of the mate
    s | 1   | ratio of its fastest to its slowest turning
""")
A, k, t, n, a, f, b, r, i, T, W, s = q.values()

gears = Formulas(
    "elliptic_gears",
    given=q,
    angle=t,
    speed=n,
    source="the example of the guide",
    assumptions=["no backlash"],
)
gears.defines(a, 2 * A)
gears.defines(f, 2 * k * A)
gears.defines(b, sqrt(A**2 - (f / 2) ** 2))
gears.defines(r, b**2 / (A - f / 2 * cos(t)))
gears.defines(i, r / (a - r))
gears.defines(T, t + 2 * atan2(k * sin(t), 1 - k * cos(t)))
gears.defines(W, i * n)
gears.defines(s, ((1 + k) / (1 - k)) ** 2)
gears.mesh("P", ("driver", t, r), ("mate", -T, a - r))
gears.function("shape", (A, k), what(a), what(f), what(b), what(s))
gears.function(
    "rolling", (A, k, t), what(a), what(f), what(b), what(r), what(i), what(T), gives=(r, i, T)
)
SYSTEM = gears.system()

PAPER = Paper("invented2026gears", "An invented paper on elliptic gears, with a planted error")
PAPER.defines("1", r, A * (1 - k**2) / (1 - k * cos(t)), what(r))
PAPER.defines("2", i, r / (2 * A + r), what(i))  # planted: the sign of the radius
PAPER.defines("3", s, ((1 + k) / (1 - k)) ** 2, what(s))
CASE = trial(gears, PAPER)
