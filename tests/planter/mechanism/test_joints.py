"""Joints of space: what each carries, the balance of momentum of all bodies, energy, and what is
refused.
"""

import numpy as np
import pytest

from derive.mechanics.statement import MechanismError
from tests.support import own

SPACE = '''
from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    g | m/s2  | free fall | 9.81
    l | m     | lengths   | 0.3
    m | kg    | bodies    | 1.2
    I | kg m2 | xx        | 0.011
    J | kg m2 | yy        | 0.017
    K | kg m2 | zz        | 0.023
    P | kg m2 | xy        | 0.002
""")
m = Mechanism("space", q, gravity=(0, 0, -q.g), spatial=True)
tensor = (q.I, q.J, q.K, q.P, 0, 0)
h, a = m.coordinate("h", "m", "height"), m.coordinate("a", "rad", "turn")
b, c = m.coordinate("b", "rad", "first of the universal joint"), m.coordinate("c", "rad", "second")
d, e = m.coordinate("d", "rad", "first of the ball"), m.coordinate("e", "rad", "second")
f, s = m.coordinate("f", "rad", "third"), m.coordinate("s", "m", "slide")
x, y, k = m.coordinate("x", "m", "puck, x"), m.coordinate("y", "m", "puck, y"), m.coordinate("k", "rad", "puck")

column = m.frame("column", a)
hung = m.frame("hung", c, Y, m.frame("cross", b, X, column))
ball = m.frame("ball", f, Z, m.frame("e", e, Y, m.frame("d", d, X)))
top = m.point("top", m.O, m.world, 0, 0, h)
one = m.body("one", column, q.m, m.point("C1", top, column, q.l), tensor)
joint = m.point("joint", top, column, 2 * q.l)
two = m.body("two", hung, q.m, m.point("C2", joint, hung, 0, 0, -q.l), tensor)
base = m.point("base", m.O, m.world, 0, 5 * q.l)
three = m.body("three", ball, q.m, m.point("C3", base, ball, q.l, 0, -q.l), tensor)
bead = m.point("bead", base, ball, s)
four = m.body("four", ball, q.m, bead, tensor)
puck = m.point("puck", m.O, m.world, x, y)
five = m.body("five", m.frame("puck", k), q.m, puck, tensor)
m.cylinder("one", one, m.ground, top, Z)
m.UNIVERSAL
m.ball("three", three, m.ground, base)
m.slide("four", four, three, bead, along=X)
m.plane("five", five, m.ground, puck, normal=Z)
m.force("push", five, m.O, m.vector(m.world, q.m * q.g / 7, q.m * q.g / 5))
rates = m.motion.rates
m.begin({c: 0.4, e: 0.3, s: q.l, rates[a]: 2, rates[b]: -1, rates[f]: 3, rates[s]: 0.2, rates[h]: 1, rates[k]: 5})
SYSTEM = m.system()
'''
UNIVERSAL = 'universal("two", two, one, joint, X, Y)'
BODIES = ("one", "two", "three", "four", "five")


def test_spatial_joints_conserve_momentum_and_do_no_work() -> None:
    run = own.dynamics(SPACE.replace("UNIVERSAL", UNIVERSAL), "space").run(
        np.linspace(0, 0.3, 7), 1e-10
    )
    assert run.undetermined == ()
    joints = {"x": ("one", "three"), "y": ("one", "three"), "z": ("three", "five")}
    outer = {"x": 1.2 * 9.81 / 7, "y": 1.2 * 9.81 / 5, "z": -5 * 1.2 * 9.81}
    for axis, names in joints.items():
        moved = sum(1.2 * run.results.get(f"a_{body}_{axis}", 0) for body in BODIES)
        total_force = sum(run.results[f"F_{name}{axis}"] for name in names) + outer[axis]
        assert total_force == pytest.approx(moved, abs=1e-9)
    power = outer["x"] * run.states[19] + outer["y"] * run.states[20]
    assert np.abs(power).max() > 0.1
    energy = run.results["kinetic"] + run.results["potential"]
    work = 1.2 * 9.81 * (run.states[8] / 7 + run.states[9] / 5)
    assert own.deviation("energy less the push's work", energy - work, energy[0]) < 1e-8


def test_joint_with_missing_reaction_is_refused() -> None:
    with pytest.raises(MechanismError, match=r"no joint carries two: moment along z"):
        exec(SPACE.replace("UNIVERSAL", 'ball("two", two, one, joint)'), {})
