"""Starts of free motion: what is set holds, the rest follows; what contradicts is told, or named to
hold.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from derive import Mechanism, quantities
from derive.mechanics.statement import MechanismError
from planter.errors import InputError
from planter.mechanism.ensemble import EnsembleSpec, compute_ensemble
from planter.mechanism.motion import compute_motion, validate_free_motion
from tests.support import own

DISC = '''
from derive import Mechanism, quantities

q = quantities("""
    r | mm | radius | 80
    m | kg | disc   | 3
    k | N m | spring, per radian | 0
""")
m = Mechanism("disc", q)
x, a = m.coordinate("x", "m", "hub"), m.coordinate("a", "rad", "turn of the disc")
hub = m.point("hub", m.O, m.world, x, q.r)
disc = m.body("disc", m.frame("disc", a), q.m, hub, q.m * q.r**2 / 2)
m.roll("rim", m.rate(x) + q.r * m.rate(a))
m.torque("spring", disc, m.ground, -q.k * a)
m.begin(START)
SYSTEM = m.system()
'''
WHEEL = '''
from derive import Mechanism, X, Y, Z, quantities

q = quantities("""
    R | m     | radius                 | 0.3
    m | kg    | wheel                  | 2
    I | kg m2 | inertia, across        | 0.06
    J | kg m2 | inertia, about the axle | 0.12
    g | m/s2  | free fall              | 9.81
""")
m = Mechanism("wheel", q, gravity=(0, 0, -q.g), spatial=True)
x, y, z = (m.coordinate(axis, "m", f"centre, {axis}") for axis in "xyz")
yaw, lean, roll = (m.coordinate(angle, "rad", angle) for angle in ("yaw", "lean", "roll"))
upright = m.frame("upright", lean, X, m.frame("heading", yaw))
centre = m.point("centre", m.O, m.world, x, y, z)
disc = m.body("disc", m.frame("disc", roll, Y, upright), q.m, centre, (q.I, q.J, q.I))
m.wheel("W", disc, centre, q.R, axle=Y, up=Z)
m.begin(START)
SYSTEM = m.system()
'''
BOTH = "{m.rate(x): 1, m.rate(a): 5}"


def begin(start: str, text: str = DISC) -> str:
    return text.replace("START", start)


def test_set_rates_hold_and_the_others_follow_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        alone = own.dynamics(begin("{m.rate(x): 1}"), "disc").start()
        turning = own.dynamics(begin("{m.rate(a): 5}"), "disc").start()
    assert alone == pytest.approx([0, 0, 1, -1 / 0.08])
    assert turning == pytest.approx([0, 0, -5 * 0.08, 5])


@pytest.mark.parametrize(("entry", "used"), [("m.rate(x)", [1, -12.5]), ("m.rate(a)", [-0.4, 5])])
def test_named_rates_hold_against_contradicting_ones(entry: str, used: list[float]) -> None:
    dynamics = own.dynamics(begin(f"{BOTH}, hold=[{entry}]"), "disc")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert dynamics.start()[2:] == pytest.approx(used)
        assert dynamics.run(np.array([0.0, 0.1])).states[2:, -1] == pytest.approx(used)
    (change,) = compute_motion(dynamics, 0.1, 3, 1e-9).result.changed_start
    assert change.stated == pytest.approx(5 if "x" in entry else 1)
    assert change.used == pytest.approx(used[entry == "m.rate(x)"])


def test_contradicting_start_without_hold_is_told_everywhere() -> None:
    """The nearest start keeps the momentum against the rim: (m v r - J w) / (J + m r2) = (v/r -
    w/2) / 1.5.
    """
    dynamics = own.dynamics(begin(BOTH), "disc")
    turning = -(1 / 0.08 - 5 / 2) / 1.5
    with pytest.warns(
        RuntimeWarning, match=r"x_dot is 0.533.* instead of 1, a_dot is -6.666.*hold="
    ):
        start = dynamics.start()
    assert start[2:] == pytest.approx([-turning * 0.08, turning])
    with pytest.warns(RuntimeWarning, match="hold="):
        dynamics.run(np.array([0.0, 0.1]))
    result = compute_motion(dynamics, 0.1, 3, 1e-9).result
    assert [change.quantity for change in result.changed_start] == ["x_dot_m_s", "a_dot_rad_s"]
    warnings_ = validate_free_motion(own.file(begin(BOTH), "disc")).warnings
    assert [warning.name for warning in warnings_] == ["x_dot", "a_dot"]
    spec = EnsembleSpec(runs=2, perturbation=1e-3)
    ensemble = compute_ensemble(own.file(begin(BOTH), "disc", k_Nm=3.0), 0.1, 21, spec).result
    assert ensemble.changed_start == result.changed_start


def test_values_that_cannot_hold_together_are_refused() -> None:
    dynamics = own.dynamics(begin(f"{BOTH}, hold=[m.rate(x), m.rate(a)]"), "disc")
    with pytest.raises(InputError, match=r"slip_rim.*holds x_dot, a_dot"):
        dynamics.start()


@pytest.mark.parametrize("entry", ["m.rate(roll)", "m.rate(x)"])
def test_wheel_that_leans_and_turns_rolls_at_the_rate_that_holds(entry: str) -> None:
    """The contact is at rest: along the heading, v + R roll' + R yaw' sin(lean) = 0 with these
    axes.
    """
    rates = (
        "{z: q.R * 0.9553364891256060, lean: 0.3, m.rate(yaw): 0.7, m.rate(x): 2, m.rate(roll): 4}"
    )
    dynamics = own.dynamics(begin(f"{rates}, hold=[lean, m.rate(yaw), {entry}]", WHEEL), "wheel")
    start = dict(zip(dynamics.names, dynamics.start(), strict=True))
    expected = {"m.rate(roll)": ("roll_dot", 4), "m.rate(x)": ("x_dot", 2)}[entry]
    assert start[expected[0]] == expected[1]
    assert (start["lean"], start["yaw_dot"]) == (0.3, 0.7)
    assert start["z"] == pytest.approx(0.3 * np.cos(0.3))
    assert dynamics.equations(0.0, dynamics.start()).speeds == pytest.approx(0, abs=1e-12)
    assert start["x_dot"] == pytest.approx(0.3 * (start["roll_dot"] + 0.7 * np.sin(0.3)), abs=1e-9)


def test_hold_names_coordinates_and_rates_only() -> None:
    m = Mechanism("disc", quantities("r | m | radius | 0.1"))
    x = m.coordinate("x", "m", "hub")
    with pytest.raises(MechanismError, match=r"hold = r: .*x, x_dot"):
        m.begin({x: 1}, hold=[m.given.r])
