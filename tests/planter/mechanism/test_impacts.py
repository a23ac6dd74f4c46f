"""Rigid impacts of free motions: closed forms, laws of conservation, and gradients through them."""

import numpy as np
import pytest

from derive import Mechanism, quantities
from derive.mechanics.statement import MechanismError
from derive.quantity import DimensionError
from planter import errors
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.motion_response import SensitiveMotion
from tests.planter.mechanism.state_space.statements import CRANKS
from tests.planter.mechanism.test_motion_measures import build_goal, differentiate, free_machine
from tests.support import own
from tests.support.cli import refusal

BOUNCE = r"""
from derive import Mechanism, quantities

q = quantities('''
    g   | m/s2 | free fall | 9.81
    m_b | kg   | ball      | 0.5
    h   | m    | height    | 0.4
    e   | 1    | rebound   | 0.8
''')
m = Mechanism("own", q, gravity=q.g)
y = m.coordinate("y", "m", "height")
P = m.point("P", m.O, m.world, 0, y)
ball = m.body("ball", m.world, q.m_b, P)
m.slide("rail", ball, m.ground, P, along=m.vector(m.world, 0, 1))
m.impact("floor", y, q.e)
m.begin({y: q.h})
SYSTEM = m.system(reported=[])
"""
DOUBLE = r"""
from sympy import sin
from derive import Mechanism, quantities

q = quantities('''
    g | m/s2  | free fall          | 9.81
    l | m     | rods               | 0.4
    m | kg    | of each rod        | 1
    J | kg m2 | about its centroid | 0.01
    w | m     | distance of the wall | 0.1
    v | m/s   | amplitude of the wall's speed | 0.3
    n | rad/s | its frequency      | 5
    e | 1     | restitution        | 0.6
''')
m = Mechanism("own", q, gravity=q.g)
end, before, angle = m.O, m.ground, 0
for i in range(2):
    angle = angle + m.coordinate(f"q{i}", "rad", f"relative angle {i}")
    frame = m.frame(f"rod{i}", angle)
    rod = m.body(f"b{i}", frame, q.m, m.point(f"C{i}", end, frame, q.l / 2), q.J)
    m.pin(f"A{i}", rod, before, end)
    end, before = m.point(f"P{i}", end, frame, q.l), rod
m.impact("wall", m.position(end)[0] + q.w + q.v / q.n * sin(q.n * m.time), q.e)
SYSTEM = m.system(reported=["kinetic", "potential"])
"""
"""Two rods that fall from the horizontal against a wall that swings."""

STOPPED = CRANKS.replace(
    "SYSTEM =", 'm.impact("stop", q.r * (angles[0] - q.s), q.e)\nSYSTEM ='
).replace(
    "    T   |", "    s   | rad   | stop | 0.8\n    e   | 1     | restitution | 0.7\n    T   |"
)
"""Three cranks, one of whose constraints is redundant, with an end stop."""


def test_heights_after_bounces_are_those_of_the_formula() -> None:
    """h e^(2n), with its derivatives in h and e and none in the free fall."""
    machine = free_machine(BOUNCE, "g h e")
    first = np.sqrt(2 * 0.4 / 9.81)
    for n in (1, 4):
        time = first * (1 + 2 * sum(0.8**k for k in range(1, n)) + 1.9 * 0.8**n)
        goal = build_goal(machine, f"y where y_dot is 0 last over 0..{time:.4f} s")
        height = 1e3 * 0.4 * 0.8 ** (2 * n)
        assert goal.evaluate(machine.design) == pytest.approx(height, rel=1e-9)
        names = [machine.values[index].name for index in machine.moved]
        expected = {"g": 0.0, "h": height / 0.4, "e": 2 * n * height / 0.8}
        slopes = [expected[name] for name in names]
        assert goal.slope(machine.design) == pytest.approx(slopes, rel=1e-8, abs=1e-6)


def test_energy_and_momentum_at_an_impact() -> None:
    """The rate of the gap turns round, constraints hold, and the energy falls by (1 - e^2) of what
    the impulse works on.
    """
    for text, share in ((STOPPED, 0.7), (DOUBLE, 0.6)):
        dynamics = Dynamics(own.file(text, "own"))
        until = 0.6
        run = dynamics.run(np.linspace(0.0, until, 4), 1e-11)
        passage = run.events[0]
        before = dynamics.run(np.array([0.0, passage.time]), 1e-11).states[:, -1]
        before = (
            before
            if dynamics._find_opening(passage.time, before, passage.event)[0] < 0
            else (dynamics.run(np.array([0.0, passage.time - 1e-9]), 1e-11).states[:, -1])
        )
        after = dynamics.rebound(passage.time, before, passage.event)
        opening, row, e = dynamics._find_opening(passage.time, before, passage.event)
        assert e == share
        assert dynamics._find_opening(passage.time, after, passage.event)[0] == pytest.approx(
            -e * opening, rel=1e-10
        )
        now, jump = dynamics.equations(passage.time, before), (after - before)[dynamics.size :]
        assert np.abs(now.slopes @ jump).max(initial=0.0) < 1e-9
        # the impulse does no work on motions that leave the gap and the constraints alone
        null = np.linalg.svd(np.vstack([now.slopes, row]))[2]
        rank = np.linalg.matrix_rank(np.vstack([now.slopes, row]), 1e-9)
        assert np.abs(null[rank:] @ now.inertia @ jump).max(initial=0.0) < 1e-9


def test_energy_is_kept_by_a_full_restitution() -> None:
    text = DOUBLE.replace("restitution        | 0.6", "restitution | 1").replace("| 0.3", "| 0")
    run = Dynamics(own.file(text, "own")).run(np.linspace(0.0, 1.0, 101), 1e-11)
    energy = run.results["kinetic"] + run.results["potential"]
    assert len(run.events) > 1
    assert np.ptp(energy) < 1e-8
    lossy = Dynamics(own.file(DOUBLE.replace("| 0.3", "| 0"), "own")).run(run.times, 1e-11)
    energy = lossy.results["kinetic"] + lossy.results["potential"]
    assert np.ptp(energy) > 0.1


@pytest.mark.parametrize(
    ("text", "moved", "measure"),
    [
        (BOUNCE, "g h e", "y at 1.2 s"),
        (BOUNCE, "g h e", "max kinetic over 0.3..1.2 s + rms y over 0..1.2 s"),
        (DOUBLE, "l m w v n e", "q0 at 0.7 s"),
        (DOUBLE, "l m w v n e", "t where q0_dot is 0 last over 0..0.7 s"),
        (STOPPED, "r J m_b s e T", "a1 at 0.4 s"),
    ],
    ids=["ball", "sums", "moving wall", "time", "closed loops"],
)
def test_gradients_through_impacts(text: str, moved: str, measure: str) -> None:
    goal = build_goal(free_machine(text, moved), measure)
    x = goal.machine.design
    expected = differentiate(goal, x)
    assert goal.slope(x) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_a_gradient_without_the_reset_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case: rates jump, but their derivatives do not."""
    goal = build_goal(free_machine(BOUNCE, "g h e"), "y at 1.2 s")
    x = goal.machine.design
    expected = differentiate(goal, x)
    goal.restart()
    goal.machine.motion.motions._motions.clear()  # type: ignore[union-attr]
    reset = SensitiveMotion._reset
    monkeypatch.setattr(
        SensitiveMotion,
        "_reset",
        lambda *inputs: (reset(*inputs)[0], np.eye(2, 1 + 2 + len(inputs[0].d), 1)),
    )
    assert np.abs(goal.slope(x) - expected).max() > 0.1 * np.abs(expected).max()


def test_bounces_without_end_are_told_with_their_time() -> None:
    """Impacts accumulate at t (1 + e) / (1 - e), t being the time of the fall."""
    dynamics = Dynamics(own.file(BOUNCE.replace("| 0.8", "| 0.5"), "own"))
    end = np.sqrt(2 * 0.4 / 9.81) * 3
    run = dynamics.run(np.linspace(0.0, 0.99 * end, 3))
    assert len(run.events) > 5
    with pytest.raises(errors.ComputationError, match="floor stays closed") as error:
        dynamics.run(np.linspace(0.0, 3.0, 4))
    time = float(str(error.value).split("at ")[1].split(" s")[0])
    assert time == pytest.approx(end, rel=1e-3)


def test_impacts_are_no_part_of_exports(tmp_path) -> None:  # type: ignore[no-untyped-def]
    file = own.generated(BOUNCE) / "own.toml"
    assert "impact of floor" in refusal("export", "c", str(file), "--out", str(tmp_path / "c"))


def test_impacts_that_cannot_be_stated_are_refused() -> None:
    q = quantities("r | m | r | 1\na | rad | angle | 0\nw | rad/s | speed | 3")
    m = Mechanism("own", q)
    x = m.coordinate("x", "m", "x")
    m.impact("floor", x, 0.5)
    with pytest.raises(MechanismError, match="floor"):
        m.impact("floor", x, 0.5)
    with pytest.raises(MechanismError, match="x_dot"):
        m.impact("wall", x + q.r * m.rate(x), 0.5)
    with pytest.raises(DimensionError):
        m.impact("wall", x**2, 0.5)
    driven = Mechanism("own", q, angle=q.a, speed=q.w)
    with pytest.raises(MechanismError, match="free motion"):
        driven.impact("wall", q.r, 0.5)
