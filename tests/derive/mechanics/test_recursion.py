"""Accelerations by articulated inertias: those at which the virtual power of all loads vanishes."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import own

HEAD = r'''
from sympy import cos, sin
from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    g | m/s2  | free fall | 9.81
    l | m     | rods      | 0.4
    h | m     | offset    | 0.1
    m | kg    | masses    | 1.3
    A | kg m2 | about x   | 0.02
    B | kg m2 | about y   | 0.03
    J | kg m2 | about z   | 0.01
    k | N m s | damping   | 0.2
    w | rad/s | of pivots | 3
""")
m = Mechanism("own", q, gravity=(q.h * q.w**2, -q.g, 0), spatial=SPATIAL)


def turn(name):
    return m.coordinate(name, "rad", name)


def move(name):
    return m.coordinate(name, "m", name)


def rod(name, frame, at, moment=q.J):
    return m.body(name, frame, q.m, m.point(f"C_{name}", at, frame, q.l / 2, q.h), moment)


SPACE = (q.A, q.B, q.J, 0, q.J / 5, 0)
'''
TREES = {
    "absolute angles": """
first, second = m.frame("first", turn("a")), m.frame("second", turn("b"))
E = m.point("E", m.O, first, q.l)
inner, outer = rod("inner", first, m.O), rod("outer", second, E)
m.torque("damper", outer, inner, -q.k * (m.rate(m.loops.coordinates[1].value)))
""",
    "pendulums that share a pivot on carts": """
P = m.point("P", m.O, m.world, move("s"))
Q = m.point("Q", P, m.world, 0, move("t"))
m.body("cart", m.world, q.m, P), m.body("lift", m.world, q.m, Q)
for name in ("a", "b"):
    rod(name, m.frame(f"rod_{name}", turn(name)), Q)
""",
    "a pivot that moves in time, a light crank, a weld": """
pivot = m.point("P", m.O, m.world, q.h * sin(q.w * m.time))
crank = m.frame("crank", turn("a"))
light = m.body("light", crank)
m.pin("P", light, m.ground, pivot)
E = m.point("E", pivot, crank, q.l)
m.force("push", light, E, m.vector(m.world, q.m * q.g))
lower = m.frame("lower", turn("b"), parent=crank)
rod("rod", lower, E), rod("bob", lower, m.point("F", E, lower, q.l))
""",
    "a free body with joints of several coordinates": """
base = m.point("P", m.O, m.world, move("x"), move("y"), move("z"))
frame = m.frame("c", turn("c"), X, m.frame("b", turn("b"), Y, m.frame("a", turn("a"), Z)))
body = m.body("body", frame, q.m, base, SPACE)
cross = m.frame("e", turn("e"), Y, m.frame("d", turn("d"), X, frame))
arm = rod("arm", cross, base, SPACE)
tip = m.point("T", base, cross, q.l, move("s"), q.h)
slider = m.body("slider", cross, q.m, tip, SPACE)
last = m.frame("f", turn("f"), (0, 0, -1), cross)
end = rod("end", last, tip, SPACE)
m.torque("damper", end, slider, m.vector(cross, 0, 0, -q.k * m.rate(m.loops.coordinates[-1].value)))
""",
}
OTHERS = {
    "gears": """
a = turn("a")
inner = m.frame("inner", a)
rod("sun", inner, m.O)
arm = m.point("E", m.O, m.frame("arm", turn("b")), q.l)
rod("planet", m.frame("planet", -2 * a), arm)
""",
    "a pivot by two angles": """
a, b = turn("a"), turn("b")
rod("first", m.frame("first", a), m.O)
at = m.point("E", m.O, m.world, q.l * cos(a) + q.h * cos(b), q.l * sin(a) + q.h * sin(b))
rod("second", m.frame("second", b), at)
""",
}


def derive(text: str, spatial: bool) -> str:
    head = HEAD.replace("SPATIAL", str(spatial))
    return f'{head}{text}\nSYSTEM = m.system(reported=["kinetic", "potential"])\n'


@pytest.mark.parametrize("name", [*TREES, *OTHERS])
def test_virtual_power_vanishes_at_accelerations(name: str) -> None:
    is_tree = name in TREES
    text = derive((TREES | OTHERS)[name], name == "a free body with joints of several coordinates")
    dynamics = own.dynamics(text, "own")
    formulas, rng = dynamics.formulas, np.random.default_rng(3)
    assert ("accelerations" in formulas.sidecar["functions"]) == is_tree
    for _ in range(5):
        time, state = rng.uniform(0, 1), rng.uniform(-1, 1, 2 * dynamics.size)
        accelerations = dynamics.accelerations(time, state)[0]
        now = {"time": time, "data": dynamics.data, "state": state}
        left, rest = (
            np.array(list(formulas.at("residual", **now, accelerations=values).values()))
            for values in (accelerations, np.zeros(dynamics.size))
        )
        assert np.abs(left).max() < 1e-12 * np.abs(rest).max()


def test_energy_of_free_body_is_constant() -> None:
    """Residual and energies follow from the same steps, but not in the same way."""
    text = TREES["a free body with joints of several coordinates"].replace("-q.k *", "0 *")
    dynamics = own.dynamics(derive(text, True), "own")
    state = np.random.default_rng(4).uniform(-1, 1, 2 * dynamics.size)
    run = dynamics.run(np.linspace(0, 0.5, 3), 1e-11, state)
    energy = run.results["kinetic"] + run.results["potential"]
    assert np.ptp(energy) < 1e-9 * np.abs(energy).max()
