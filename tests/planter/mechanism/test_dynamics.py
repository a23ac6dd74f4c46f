"""Free motion: the pendulum in closed form, the same stated by loops, what is redundant, rest and
small motions.
"""

from pathlib import Path

import jsonschema
import mpmath
import numpy as np
import pytest
import scipy.integrate

from derive.__main__ import main as derive
from planter.engine.machine import load_driven_machine
from planter.errors import ComputationError, InputError
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import load
from planter.mechanism.motion import compute_motion, eigenvalues, equilibrium
from tests.support import own
from tests.support.cli import answer
from tests.support.schemas import load_schema

HEAD = '''
from sympy import Rational, cos, sin
from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall | 9.81
    l | mm    | length    | 400
    m | kg    | rod       | 1.5
""")
m = Mechanism("NAME", q, gravity=q.g)
'''
ANGLE = (
    HEAD
    + """
a = m.coordinate("a", "rad", "angle from the horizontal")
rod = m.frame("rod", a)
body = m.body("rod", rod, q.m, m.point("C", m.O, rod, q.l / 2), q.m * q.l**2 / 12)
m.pin("O", body, m.ground, m.O)
m.begin({a: Rational(-1, 2)})
SYSTEM = m.system()
"""
)
LOOP = (
    HEAD
    + """
a = m.coordinate("a", "rad", "angle from the horizontal")
x, y = m.coordinate("x", "m", "centroid, x"), m.coordinate("y", "m", "centroid, y")
rod, C = m.frame("rod", a), m.point("C", m.O, m.world, x, y)
end = m.point("end", C, rod, -q.l / 2)
body = m.body("rod", rod, q.m, C, q.m * q.l**2 / 12)
m.pin("O", body, m.ground, end)
start = {a: Rational(-1, 2), x: q.l * cos(Rational(1, 2)) / 2, y: -q.l * sin(Rational(1, 2)) / 2}
m.close(end, m.O, start=start)
MORE
SYSTEM = m.system(reported=["kinetic", "potential"])
"""
)
DISC = '''
from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall          | 9.81
    r | mm    | radius             | 100
    m | kg    | disc               | 2
    k | N/m   | spring at the hub  | 50
    d | N s/m | damper at the hub  | 0
    w | m     | anchor of spring   | 3
    l | m     | spring at rest     | 1
""")
m = Mechanism("disc", q, gravity=q.g)
x, a = m.coordinate("x", "m", "hub"), m.coordinate("a", "rad", "turn of the disc")
hub, wall = m.point("hub", m.O, m.world, x, q.r), m.point("wall", m.O, m.world, q.w, q.r)
disc = m.body("disc", m.frame("disc", a), q.m, hub, q.m * q.r**2 / 2)
m.roll("x", m.rate(x) + q.r * m.rate(a))
m.spring("spring", disc, m.ground, (hub, wall), q.k, q.l, damping=q.d)
m.begin({x: 1})
SYSTEM = m.system(reported=["kinetic", "potential", "F_spring"])
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("own")
    twice = "m.constrain('again', x - q.l * cos(a) / 2, start={})"
    texts = {
        "swing": ANGLE,
        "held": LOOP.replace("MORE", ""),
        "twice": LOOP.replace("MORE", twice),
        "disc": DISC,
    }
    texts["off"] = LOOP.replace("MORE", "m.begin({x: q.l / 8 + q.l * cos(Rational(1, 2)) / 2})")
    for name, text in texts.items():
        (place / f"{name}.py").write_text(text.replace("NAME", name), encoding="utf-8")
        assert derive([str(place / f"{name}.py")]) == 0
    return place / "generated"


def dynamics(folder: Path, name: str, **values: float) -> Dynamics:
    return Dynamics(load(folder / f"{name}.toml", values))


def test_a_pendulum_swings_as_elliptic_functions_say(folder: Path) -> None:
    """Release at rest: sin(theta/2) = k sn(K - w t, k^2), w^2 = 3 g / (2 l) (Whittaker, Analytical
    dynamics, 44).
    """
    times = np.linspace(0, 3, 31)
    angles = dynamics(folder, "swing").run(times, 1e-12).states[0] + np.pi / 2
    top, rate = np.pi / 2 - 0.5, mpmath.sqrt(mpmath.mpf(3) * 9.81 / 0.8)
    k = mpmath.sin(top / 2)
    quarter = mpmath.ellipk(k**2)
    exact = [
        float(2 * mpmath.asin(k * mpmath.ellipfun("sn", quarter - rate * t, m=k**2))) for t in times
    ]
    assert np.abs(angles - exact).max() < 1e-10


def test_the_same_by_a_loop_and_with_constraints_twice(folder: Path) -> None:
    times = np.linspace(0, 2, 21)
    plain = dynamics(folder, "swing").run(times, 1e-11).states[0]
    for name, redundant in (("held", 0), ("twice", 1)):
        free_motion = dynamics(folder, name)
        run = free_motion.run(times, 1e-11)
        assert run.states[0] == pytest.approx(plain, abs=1e-8)
        assert free_motion.redundant(run.states[:, 0]) == redundant
        total = run.results["kinetic"] + run.results["potential"]
        assert np.ptp(total) < 1e-8


def test_constraint_drift_is_detected(folder: Path) -> None:
    """Without projection the drift is far above what a projected motion shows."""
    free_motion = dynamics(folder, "held")

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        return np.concatenate([state[3:], free_motion.accelerations(time, state)[0]])

    free = scipy.integrate.solve_ivp(rates, (0, 40), free_motion.start(), rtol=1e-4, atol=1e-6)
    gap = free_motion.equations(0.0, free.y[:, -1]).gaps
    residuals = free_motion.equations(
        0.0, free_motion.run(np.array([0.0, 40.0]), 1e-4).states[:, -1]
    ).gaps
    assert np.abs(residuals).max() < 1e-11
    assert np.abs(gap).max() > 1e-6


def test_rest_and_small_motions_are_those_of_the_textbook(folder: Path) -> None:
    rate = np.sqrt(3 * 9.81 / 0.8)
    for name, count in (("swing", 1), ("held", 3)):
        free_motion = dynamics(folder, name)
        rest = equilibrium(
            free_motion, free_motion.project(0.0, np.concatenate([[-1.4], np.zeros(2 * count - 1)]))
        )
        assert np.sin(rest[0]) == pytest.approx(-1, abs=1e-12)
        assert np.sort(eigenvalues(free_motion, rest).imag) == pytest.approx(
            [-rate, rate], rel=1e-9
        )


def test_rolling_disc_has_effective_mass_of_1_5(folder: Path) -> None:
    """A spring on the hub of a disc that rolls: w^2 = k / (3 m / 2), and a damper takes the
    energy.
    """
    times = np.linspace(0, 2, 41)
    run = dynamics(folder, "disc").run(times, 1e-11)
    assert run.states[0] == pytest.approx(2 - np.cos(np.sqrt(50 / 3) * times), abs=1e-8)
    assert run.states[1] == pytest.approx(-(run.states[0] - 1) / 0.1, abs=1e-7)
    damped = dynamics(folder, "disc", d_N_s_m=4.0).run(times, 1e-10)
    total = damped.results["kinetic"] + damped.results["potential"]
    assert np.all(np.diff(total) < 0)


def test_command_prints_and_writes(folder: Path, tmp_path: Path) -> None:
    result = answer(
        "move",
        str(folder / "held.toml"),
        "--until",
        "0.5",
        "--rest",
        "--out",
        str(tmp_path / "run"),
    )
    jsonschema.validate(result, load_schema("move"))
    assert result["energy"]["most_J"] - result["energy"]["least_J"] < 1e-6
    assert result["redundant_constraints"] == 0
    assert len(result["eigenvalues_per_s"]) == 2
    assert {"values.csv", "report.html"} <= {path.name for path in (tmp_path / "run").iterdir()}


def test_changed_start_is_reported(folder: Path) -> None:
    """Half as long again, the rod's centroid cannot start where the statement says; the angle moves
    with it.
    """
    stated = np.array([-0.5, 0.2 * np.cos(0.5), -0.2 * np.sin(0.5)])
    begun = dynamics(folder, "held")
    assert begun.find_changes(begun.start()) == []
    result = compute_motion(begun, 0.01, 3, 1e-9).result
    assert result.changed_start == []
    moved = dynamics(folder, "off")
    with pytest.warns(RuntimeWarning, match="x is 0.1834.* instead of 0.2255.*hold="):
        used = moved.start()
    assert moved.stated[:3] == pytest.approx([-0.5, 0.05 + stated[1], stated[2]])
    changes = compute_motion(moved, 0.01, 3, 1e-9).result.changed_start
    assert [change.quantity for change in changes] == ["a_deg", "x_mm", "y_mm"]
    assert [change.used for change in changes] == pytest.approx(
        [np.degrees(used[0]), 1e3 * used[1], 1e3 * used[2]]
    )
    assert changes[1].stated == pytest.approx(1e3 * (0.05 + stated[1]))
    assert 1e3 * 0.2 * np.cos(np.radians(changes[0].used)) == pytest.approx(changes[1].used)


@pytest.mark.parametrize("stiff", [False, True])
def test_endless_motion_is_given_up(
    folder: Path, stiff: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("planter.mechanism.dynamics.CHECK_INTERVAL", 500)
    rod = dynamics(folder, "swing", g_m_s2=1e15)
    with pytest.raises(ComputationError, match="evaluations"):
        rod.run(np.array([0.0, 1.0]), stiff=stiff)


def test_each_command_sends_to_the_other(folder: Path) -> None:
    with pytest.raises(InputError, match="no angle drives swing; run `planter simulate`"):
        load_driven_machine(str(folder / "swing.toml"))


def test_short_motion_locates_an_event_late_in_time():
    rattle = own.dynamics("gear_rattle")
    event = next(
        event for event in rattle.run(np.linspace(0, 0.03, 61)).events if event.time > 0.02
    )
    times = event.time + np.array([-1e-7, 1e-7])
    state = rattle.run(np.array([0, times[0]])).states[:, -1]
    (located,) = rattle.run(times, state=state).events
    assert located.time == pytest.approx(event.time, rel=1e-12)
