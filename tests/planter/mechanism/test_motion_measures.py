"""Measures of a free motion over its time: against closed forms and differences, through contacts
and on closed loops; searches on them.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from planter import errors
from planter.engine.goal import Goal
from planter.engine.machine import Machine
from planter.engine.search import SearchSpec
from planter.kernels import Array
from planter.mechanism.machines import build_free_machine
from planter.mechanism.motion_response import MotionResponse
from planter.mechanism.optimisation import (
    StatedGoal,
    compute_objective_sensitivity,
    optimise_machine,
)
from tests.planter.mechanism.state_space.statements import CRANKS, RUBBING
from tests.support import own
from tests.support.cli import answer, refusal

OSCILLATOR = r'''
from derive import Mechanism, quantities

q = quantities("""
    m_b | kg    | mass    | 0.5
    k   | N/m   | spring  | 40
    c   | N s/m | damper  | 0.8
    x_0 | m     | start   | 0.1
""")
m = Mechanism("own", q)
x = m.coordinate("x", "m", "place")
P = m.point("P", m.O, m.world, x)
block = m.body("block", m.world, q.m_b, P)
m.slide("rail", block, m.ground, P)
m.force("spring", block, P, m.vector(m.world, -q.k * x - q.c * m.rate(x), 0))
m.begin({x: q.x_0})
SYSTEM = m.system()
'''
BALL = r'''
from sympy import Piecewise
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall         | 9.81
    m_b | kg   | ball              | 0.5
    k   | N/m  | ground            | 4000
    F   | N    | push in contact   | 3
    y_0 | m    | height            | 0.2
""")
m = Mechanism("own", q, gravity=q.g)
y = m.coordinate("y", "m", "height")
P = m.point("P", m.O, m.world, 0, y)
ball = m.body("ball", m.world, q.m_b, P)
m.slide("rail", ball, m.ground, P, along=m.vector(m.world, 0, 1))
N = m.name_("N_c", "N", "force of the ground", Piecewise((0, y > 0), (q.F - q.k * y, True)))
m.force("ground", ball, P, m.vector(m.world, 0, N))
m.begin({y: q.y_0})
SYSTEM = m.system()
'''


def free_machine(text: str, moved: str) -> Machine:
    """The machine of a statement that moves freely; all values of these names may move by half."""
    machine = build_free_machine(own.file(text, "own"))
    bounds = {
        value.path: (0.5 * number / value.factor, 2.0 * number / value.factor)
        for value, number in zip(machine.values, machine.data, strict=True)
        if value.name in moved.split()
    }
    return machine.with_moved(bounds)


def build_goal(machine: Machine, text: str) -> Goal:
    stated = StatedGoal.read(machine, text)
    return Goal(stated.machine, stated.objective)


def differentiate(goal: Goal, x: Array, share: float = 2e-4) -> Array:
    """The gradient by differences of fourth order, with steps of a share of the design."""
    columns = []
    for step in np.diag(share * x):
        single, double = (goal.evaluate(x + n * step) - goal.evaluate(x - n * step) for n in (1, 2))
        columns.append((8 * single - double) / (12 * step.sum()))
    return np.array(columns)


def oscillate(m: float, k: float, c: float, x_0: float, t: Array) -> Array:
    decay, omega = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)
    return x_0 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))


def test_measures_are_those_of_the_closed_form() -> None:
    machine = free_machine(OSCILLATOR, "k c x_0")
    times = np.linspace(0.0, 2.0, 200_001)
    x = 1e3 * oscillate(0.5, 40.0, 0.8, 0.1, times)
    inside = (times >= 0.2) & (times <= 1.0)
    expected = {
        "x at 1 s": x[100_000],
        "max x over 0..2 s": 100.0,
        "min x over 0.2..1 s": x[inside].min(),
        "rms x over 0..2 s": np.sqrt(np.trapezoid(x**2, times) / 2),
        "mean x over 0.2..1 s": np.trapezoid(x[inside], times[inside]) / 0.8,
    }
    for text, value in expected.items():
        goal = build_goal(machine, f"-{text}" if text.startswith("min") else text)
        reached = goal.evaluate(machine.design)
        assert abs(reached) == pytest.approx(abs(value), rel=1e-8, abs=1e-9), text


@pytest.mark.parametrize(
    ("text", "moved", "measure"),
    [
        (OSCILLATOR, "m_b k c x_0", "-min x over 0.2..1 s + rms x over 0..2 s"),
        (BALL, "m_b k F y_0", "max N_c over 0..0.9 s"),
        (BALL, "g k F y_0", "y at 0.7 s"),
        (CRANKS, "g r w J m_b T", "a0 at 0.3 s + max kinetic over 0..0.5 s"),
        (RUBBING, "m_r M mu", "s at 0.3 s"),
    ],
    ids=["oscillator", "contact force", "after contacts", "closed loops", "friction"],
)
def test_gradients_are_those_of_differences(text: str, moved: str, measure: str) -> None:
    goal = build_goal(free_machine(text, moved), measure)
    x = goal.machine.design
    expected = differentiate(goal, x)
    assert goal.slope(x) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_second_derivatives_are_those_of_differences_of_slopes() -> None:
    machine = free_machine(OSCILLATOR, "k c x_0")
    assert machine.motion is not None
    response, x = MotionResponse(machine, ["x"]), machine.design
    phi = np.array([0.7, 2.9])
    hessians = response.curvatures(response.at(x), phi, np.ones((1, 2)))
    for column, step in enumerate(np.diag(1e-3 * x)):
        above, below = (response.slopes(response.at(x + s * step), phi)[1][0] for s in (1, -1))
        expected = (above - below) / (2 * step.sum())
        scale = np.abs(expected).max()
        assert hessians[:, 1 + column] == pytest.approx(expected, rel=1e-3, abs=1e-3 * scale)


def test_without_the_jump_at_a_contact_the_gradient_is_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The tampered case: slopes that pass the events as if nothing happened."""
    from planter.mechanism.motion_response import SensitiveMotion

    monkeypatch.setattr(SensitiveMotion, "_jump", lambda self, step, slopes: slopes)
    goal = build_goal(free_machine(BALL, "F y_0"), "y at 0.7 s")
    x = goal.machine.design
    assert np.abs(goal.slope(x) / differentiate(goal, x) - 1).max() > 1e-3


WHIRLED = RUBBING.replace("m.rate(a): 1.1", "m.rate(a): 18")
"""The rod whirls so fast that it lifts the slider from its guide to the other side."""


def test_gradient_through_a_change_of_sign_of_a_normal_force() -> None:
    """Of a state, and of an output that has the sign itself."""
    machine = free_machine(WHIRLED, "m_r mu")
    goal = build_goal(machine, "s at 0.15 s + 0.1 N_floor at 0.15 s")
    x = goal.machine.design
    expected = differentiate(goal, x, 1e-3)
    assert goal.slope(x) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
    assert goal.machine.motion is not None
    motion = goal.machine.motion.motions.find(machine.build_data(x), machine.moved)
    events = [passage for step in motion.steps for passage in step.crossed]
    assert [passage.event for passage in events][:1] == ["sign of N_floor"]
    assert [motion.signs[0, 0], motion.signs[0, motion.arcs.tolist().index(1)]] == [1.0, -1.0]


def test_signs_of_the_start_alone_give_another_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case, which the comparison of accelerations refuses."""
    from planter.mechanism.motion_response import SensitiveMotion

    monkeypatch.setattr(SensitiveMotion, "signs", property(lambda m: np.ones((1, len(m.steps)))))
    goal = build_goal(free_machine(WHIRLED, "mu"), "s at 0.15 s")
    with pytest.raises(errors.ComputationError, match=r"own: at 0\.\d+ s"):
        goal.slope(goal.machine.design)


def test_gradient_through_slow_contacts_of_an_example() -> None:
    """The rattling gears meet at speeds whose product with the tolerance of time is tiny."""
    text = (Path(__file__).parents[3] / "docs/examples/gear_rattle.py").read_text("utf-8")
    goal = build_goal(
        free_machine(text.replace('"gear_rattle"', '"own"'), "T b"), "a_2_dot at 0.004 s"
    )
    x = goal.machine.design
    expected = differentiate(goal, x)
    assert goal.slope(x) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_a_pose_in_which_constraints_change_their_rank_is_told_with_its_time() -> None:
    goal = build_goal(free_machine(CRANKS, "r T"), "a0 at 0.8 s")
    with pytest.raises(errors.ComputationError, match=r"0\.5\d+ s"):
        goal.slope(goal.machine.design)


def test_optimum_is_that_of_the_closed_form(tmp_path: Path) -> None:
    """The damping of the least mean square of a decay over a long time."""
    file = own.generated(OSCILLATOR) / "own.toml"
    text = file.read_text("utf-8") + "\n[bounds]\nc_N_s_m = [2, 16]\n"
    source = tmp_path / "own.toml"
    source.write_text(text.replace("[values]", f'folder = "{file.parent}"\n[values]', 1), "utf-8")
    result = answer("optimise", str(source), "--least", "rms x over 0..3 s", "--starts", "2")
    times = np.linspace(0.0, 3.0, 30_001)

    def rms(c: float) -> float:
        damped = oscillate(0.5, 40.0, c + 0j, 0.1, times).real  # type: ignore[arg-type]
        return float(np.sqrt(np.trapezoid(damped**2, times) / 3))

    best = minimize_scalar(rms, bounds=(2, 8.9), method="bounded", options={"xatol": 1e-6})
    assert result["design"]["c_N_s_m"] == pytest.approx(best.x, rel=1e-4)
    assert result["objective"] == pytest.approx(1e3 * best.fun, rel=1e-6)
    limit = answer(
        "optimise",
        str(source),
        *("--least", "rms x over 0..3 s", "--hold", "x at 0.5 s >= 20"),
        *("--starts", "1"),
    )
    assert limit["holds"][0]["active"]
    assert limit["holds"][0]["value"] == pytest.approx(20.0, abs=1e-4)


def test_results_are_of_the_time_that_the_sum_asks_for() -> None:
    """Spans beyond the one second that a machine moves for before anything is asked."""
    machine, text = free_machine(OSCILLATOR, "k c"), "rms x over 0..3 s + x at 2.5 s"
    goal = build_goal(machine, text)
    sensitivity = compute_objective_sensitivity(machine, least=text)
    assert sensitivity.objective == pytest.approx(goal.evaluate(machine.design), rel=1e-12)
    slopes = goal.slope(machine.design) * machine.scale
    assert list(sensitivity.gradient.values()) == pytest.approx(slopes, rel=1e-9)
    optimum = optimise_machine(machine, text, spec=SearchSpec("refined", starts=1))
    assert optimum.machine.motion is not None
    assert optimum.machine.motion.span == 3.0
    assert optimum.result.start_objective == pytest.approx(sensitivity.objective, rel=1e-12)


PROJECTILE = r'''
from sympy import cos, sin
from derive import Mechanism, quantities

q = quantities("""
    g   | m/s2 | free fall | 9.81
    m_b | kg   | stone     | 0.5
    v_0 | m/s  | speed     | 8
    b   | rad  | elevation | 0.7
""")
m = Mechanism("own", q, gravity=q.g)
x, y = m.coordinate("x", "m", "width"), m.coordinate("y", "m", "height")
stone = m.body("stone", m.world, q.m_b, m.point("P", m.O, m.world, x, y))
m.begin({m.rate(x): q.v_0 * cos(q.b), m.rate(y): q.v_0 * sin(q.b)})
SYSTEM = m.system(reported=[])
'''


def test_range_of_a_projectile_is_that_of_the_formula() -> None:
    """With its gradient; the time of flight is longer than that of a machine without other times."""
    machine = free_machine(PROJECTILE, "g v_0 b")
    goal = build_goal(machine, "x where y is 0 first over 0..2 s")
    g, v, b = (
        machine.data[[value.name for value in machine.values].index(n)] for n in ("g", "v_0", "b")
    )
    reach = v**2 * np.sin(2 * b) / g
    by_name = {"g": -reach / g, "v_0": 2 * reach / v, "b": 2 * v**2 * np.cos(2 * b) / g}
    expected = [by_name[machine.values[index].name] for index in machine.moved]
    assert goal.evaluate(goal.machine.design) == pytest.approx(1e3 * reach, rel=1e-9)
    assert goal.slope(goal.machine.design) == pytest.approx(1e3 * np.array(expected), rel=1e-8)


def test_times_of_passages_are_those_of_the_closed_form() -> None:
    machine = free_machine(OSCILLATOR, "m_b k c x_0")
    decay, omega = 0.8, np.sqrt(80 - 0.64)
    end = oscillate(0.5, 40.0, 0.8, 0.1, np.array([4.0]))[0]

    def excess(time: float) -> float:
        return float(np.abs(oscillate(0.5, 40.0, 0.8, 0.1, np.array([time]))[0] - end) - 2e-3)

    times = np.linspace(0.0, 4.0, 40_001)
    last = np.flatnonzero([excess(time) > 0 for time in times])[-1]
    expected = {
        "t where x_dot is 0 first": np.pi / omega,
        "x where x_dot is 0 m/s first": -100 * np.exp(-decay * np.pi / omega),
        "settling x within 2 mm over 0..4 s": brentq(excess, times[last], times[last + 1]),
        "t where x is 0 last over 0..1 s": (2.5 * np.pi + np.arctan(decay / omega)) / omega,
        "settling x within 0.3 m over 0..4 s": 0.0,
    }
    for text, value in expected.items():
        goal = build_goal(machine, text)
        assert goal.evaluate(machine.design) == pytest.approx(value, rel=1e-8), text


def test_time_of_an_event_is_that_of_free_fall() -> None:
    machine = free_machine(BALL, "g y_0")
    time = np.sqrt(2 * 0.2 / 9.81)
    for text in ("time of N_c", "t where y is 0 first", 'time of "N_c: y = 0" over 0..2 s'):
        goal = build_goal(machine, text)
        assert goal.evaluate(machine.design) == pytest.approx(time, rel=1e-10), text
        expected = {"g": -time / 2 / 9.81, "y_0": time / 2 / 0.2}
        slopes = [expected[machine.values[index].name] for index in machine.moved]
        assert goal.slope(machine.design) == pytest.approx(slopes, rel=1e-8), text


@pytest.mark.parametrize(
    ("text", "moved", "measure", "share"),
    [
        (OSCILLATOR, "m_b k c x_0", "x_dot where x is 10 mm last over 0..3 s", 5e-5),
        (OSCILLATOR, "m_b k c x_0", "settling x within 2 mm over 0..4 s", 5e-5),
        (BALL, "g k F y_0", "t where y is 0 last", 1e-3),
        (BALL, "g k F y_0", "y_dot where y is 50 mm last", 1e-3),
        (BALL, "g k F y_0", "settling N_c within 0.5 N", 1e-3),
        (CRANKS, "g r w J m_b T", "a1_dot where a0 is 45 deg first over 0..0.4 s", 2e-4),
        (RUBBING, "m_r M mu", "s where a is -30 deg first", 2e-4),
    ],
    ids=["last", "settling", "contact", "after contacts", "jump", "closed loops", "friction"],
)
def test_gradients_at_times_that_the_design_moves(
    text: str, moved: str, measure: str, share: float
) -> None:
    goal = build_goal(free_machine(text, moved), measure)
    x = goal.machine.design
    expected = differentiate(goal, x, share)
    assert goal.slope(x) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_gradient_at_a_fixed_time_is_another_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case: a time that stays where it is when the design moves."""
    from planter.engine.places import NodePlace

    goal = build_goal(free_machine(PROJECTILE, "g v_0"), "x where y is 0 first over 0..2 s")
    x = goal.machine.design
    expected = differentiate(goal, x)
    goal.restart()
    monkeypatch.setattr(NodePlace, "differentiate", lambda self, point: (1.0, 0 * x))
    assert np.abs(goal.slope(x) / expected - 1).max() > 0.1


def test_second_derivatives_at_a_moving_time() -> None:
    goal = build_goal(free_machine(OSCILLATOR, "k c"), "settling x within 2 mm over 0..4 s")
    x, part = goal.machine.design, goal.objective.parts[0]
    steps = np.diag(1e-4 * x)
    expected = [(goal.slope(x + s) - goal.slope(x - s)) / (2 * s.sum()) for s in steps]
    hessian = part.local(x).curvature(x, np.array([1.0]))
    assert hessian == pytest.approx(np.array(expected), rel=1e-3)


@pytest.mark.parametrize(
    ("measure", "reason"),
    [
        ("x where x_dot is 0 first over 0..0.1 s", r"from 0 s to 0\.1 s, where it is from -0\.6"),
        ("x where x is 150 mm first over 0..2 s", "does not pass 150"),
    ],
)
def test_passages_that_do_not_happen_are_told(measure: str, reason: str) -> None:
    goal = build_goal(free_machine(OSCILLATOR, "k"), measure)
    with pytest.raises(errors.ComputationError, match=reason):
        goal.evaluate(goal.machine.design)


def test_a_number_that_is_only_touched_has_no_time() -> None:
    """The apex of the flight is the number itself, which is passed where it is a little less."""
    machine = free_machine(PROJECTILE, "g v_0")
    apex = float(1e3 * (8 * np.sin(0.7)) ** 2 / 2 / 9.81)
    for share, reason in ((1 - 1e-13, "touched|does not pass"), (1.001, "does not pass")):
        goal = build_goal(machine, f"t where y is {share * apex!r} mm first")
        with pytest.raises(errors.ComputationError, match=reason):
            goal.evaluate(machine.design)
    goal = build_goal(machine, f"t where y is {0.999 * apex!r} mm first")
    assert goal.evaluate(machine.design) == pytest.approx(8 * np.sin(0.7) / 9.81, rel=0.1)


@pytest.mark.parametrize(
    ("measure", "reason"),
    [
        ("time of clash", "no single event has this name; its events are .*y = 0"),
        ("settling y within 3 s", "s is not a unit of y"),
        ("settling y within 0 mm", "wider than 0"),
        ("y where y_dot is 1 mm first", "mm is not a unit of y_dot"),
        ("y where y_dot is 1 m/s", "'first'|first or last"),
        ("y where y_dot is least over 0..1 s", "time"),
    ],
)
def test_places_that_cannot_be_are_refused(measure: str, reason: str) -> None:
    with pytest.raises(errors.InputError, match=reason):
        StatedGoal.read(free_machine(BALL, "k"), measure)


@pytest.mark.parametrize("measure", ["max x", "x at 30", "work x over 0..1 s", "max x over 2..1 s"])
def test_measures_without_their_time_are_refused(measure: str) -> None:
    with pytest.raises(errors.InputError, match="time"):
        StatedGoal.read(free_machine(OSCILLATOR, "k"), measure)


def test_times_do_not_apply_to_what_an_angle_drives() -> None:
    assert "angle" in refusal("optimise", "wang2017", "--least", "max F_Ox over 0..1 s")


def test_a_motion_has_no_other_speed() -> None:
    with pytest.raises(errors.InputError, match="no angle"):
        replace(free_machine(OSCILLATOR, "k")).with_speed(20.0)
