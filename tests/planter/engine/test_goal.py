"""Goals on the engine: derivatives against differences, units, and measures against dense grids."""

import numpy as np
import pytest

from planter.engine.goal import Goal, evaluate_measure, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import parse_limit, parse_measure, parse_sum
from planter.engine.problem import build_problem
from planter.engine.response import MachineResponse
from planter.engine.search import SearchSpec, minimise
from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism.machines import build_machine
from planter.numerics.arrays import TURN
from tests.planter.engine.solvers.toys import check_derivatives
from tests.support import own
from tests.support.reference import evaluate


@pytest.fixture(scope="module")
def machine() -> Machine:
    moved = dict.fromkeys(("r_mm", "l_mm", "e_mm", "omega_rpm"), (0.0, 1e3))
    return build_machine(own.file("slider_crank")).with_moved(moved)


def build(machine: Machine, objective: str, *limits: str, count: int | None = None) -> Goal:
    measures = [resolve_measure(machine, measure) for measure in parse_sum(objective)]
    return Goal(
        machine, measures, [resolve_limit(machine, parse_limit(text)) for text in limits], count
    )


LEAST = (
    "range F_Ox + 3 rms M_in + 0.5 variance s + mean s + max abs M_in + s at 90 + std F_Ox + abs "
    "beta where s is least"
    " + 0.1 work P_M_in + work M_in + mean M_in while s <= 0.2 m + max F_Ox while beta >= 1 deg "
    "and s <= 230"
    " + 2 F_Ox where beta is greatest + std s while s >= 180 + jump F_Ox"
)
LIMITS = (
    "abs F_Ox <= 0.09 kN",
    "rms M_in <= 1",
    "range s <= 7 cm",
    "s at 45 >= 120",
    "abs beta where s is least <= 0.1 rad",
    "abs M_in while s <= 200 <= 900 N mm",
    "mean F_Ox while s >= 200 <= 3",
    "work P_M_in >= 1 mJ",
    "variance s <= 30 cm2",
    "jump F_By <= 0.2 N",
)


@pytest.mark.parametrize("count", [None, 24])
def test_derivatives_are_those_of_differences(machine: Machine, count: int | None) -> None:
    """Of the sum's rows and smooth terms, and of the rows of all limits, with random weights."""
    goal, x = build(machine, LEAST, *LIMITS, count=count), machine.design
    local, limits = goal.objective.local(x), MeasureLimits(goal).at(x)
    rng, width = np.random.default_rng(3), np.maximum(np.abs(x), 1e-2)
    weights = np.append(0.7, rng.random(len(local.groups)))
    check_derivatives(local, x, weights, width, 1e-6)
    check_derivatives(limits, x, rng.random(limits.count), width, 1e-6)


def test_limits_have_one_value_each_and_rows_near_a_design(machine: Machine) -> None:
    """The worst row of a limit is its value; without a pair of peak and valley the range would be
    another.
    """
    goal, x = (
        build(machine, "mean s", "range F_Ox <= 3", "max s >= 200", "mean F_Ox <= 1"),
        machine.design,
    )
    limits = MeasureLimits(goal)
    rows = limits.at(x)
    values = rows.values(x)
    worst = [values[rows.owner == k].max() for k in range(3)]
    np.testing.assert_allclose(worst, limits.values(x), rtol=1e-12)
    assert (rows.owner == 0).sum() > 1
    assert (rows.owner == 1).sum() == 1
    measured = [evaluate_measure(machine, limit.measure) for limit in goal.limits]
    np.testing.assert_allclose(limits.values(x) * limits.steps, measured, rtol=1e-12)


def test_units_are_converted_to_those_of_results(machine: Machine) -> None:
    goal = build(machine, "max s", *LIMITS)
    numbers = [limit.number for limit in goal.limits]
    np.testing.assert_allclose(
        numbers, [90, 1, 70, 120, np.degrees(0.1), 0.9, 3, 1e-3, 3000, 0.2], rtol=1e-14
    )
    assert str(goal.limits[0]) == "abs F_Ox <= 90 N"
    assert str(goal.limits[5]) == "abs M_in while s <= 200 <= 0.9 N m"


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("F_Oxx <= 3", "did you mean F_Ox"),
        ("F_Ox <= 3 mm", "mm is not a unit of F_Ox"),
        ("work s <= 3", "a power"),
        ("s while beta <= 3 mm <= 4", "mm is not a unit of beta"),
        ("variance s <= 3 mm", "mm is not a unit"),
        ("jump F_Ox <= 3 mm", "mm is not a unit"),
    ],
)
def test_names_and_units_of_other_kinds_are_refused(machine: Machine, text: str, part: str) -> None:
    with pytest.raises(InputError, match=part):
        resolve_limit(machine, parse_limit(text))


def test_size_without_a_measure_over_a_cycle_is_refused(machine: Machine) -> None:
    with pytest.raises(InputError, match="mean abs F_Ox: over a cycle mean takes no abs"):
        resolve_measure(machine, parse_measure("mean abs F_Ox", "quantity"))


def test_jump_limit_holds_at_dead_centres() -> None:
    """Friction reverses where crank and rod are in line: the force beside these angles, by the
    closed form of both.
    """
    machine = build_machine(own.file("slider_crank")).with_moved(
        {"r_mm": (30.0, 70.0), "e_mm": (5.0, 15.0)}
    )
    rod = float(machine.data[machine.find_index("l_mm")])

    def jump(x: Array) -> float:
        r, e = x
        dead = np.array([np.arcsin(e / (rod + r)), np.pi - np.arcsin(-e / (rod - r))])
        before, after = (
            evaluate(machine.with_data(machine.build_data(x)), "F_Ox", dead + s)
            for s in (-1e-7, 1e-7)
        )
        return float(np.abs(after - before).max())

    measures = [resolve_measure(machine, measure) for measure in parse_sum("-mean s")]
    limit = resolve_limit(machine, parse_limit("jump F_Ox <= 3 N"))
    optimum = minimise(build_problem(machine, measures, [limit], 36), SearchSpec(36, "ipopt", 2))
    assert jump(optimum.x) == pytest.approx(3, abs=1e-5)
    goal = Goal(machine, measures, (), 36)
    designs = [np.array([r, e]) * 1e-3 for r in (30, 40, 55, 70) for e in (5, 8, 11, 15)]
    allowed = [goal.evaluate(x) for x in designs if jump(x) <= 3]
    assert 0 < len(allowed) < len(designs)
    assert goal.evaluate(optimum.x) <= min(allowed) + 1e-9


def test_never_true_condition_gives_empty_measure(machine: Machine) -> None:
    goal = build(machine, "max s", "abs M_in while s <= 1 <= 3", "M_in while s >= 1 <= 1e6")
    assert goal.evaluate_limit(machine.design, goal.limits[0]) is None
    assert goal.evaluate_limit(machine.design, goal.limits[1]) is not None


def test_parts_of_a_cycle_are_those_of_a_dense_grid(machine: Machine) -> None:
    """Mean, extremes and work over the parts on which conditions hold, one of which spans the end
    of the turn.
    """
    response, phi = (
        MachineResponse(machine, ["s", "F_Ox", "M_in"]),
        TURN * (np.arange(400_000) + 0.5) / 400_000,
    )
    s, force, torque = response.values(response.at(machine.design), phi)
    inside = s >= 0.18
    expected = {
        "mean s while s >= 180": 1e3 * s[inside].mean(),
        "min s while s >= 180": 180.0,
        "max F_Ox while s >= 180": force[inside].max(),
        "rms F_Ox while s >= 180 and F_Ox >= 0": np.sqrt(
            (force[inside & (force >= 0)] ** 2).mean()
        ),
    }
    for text, value in expected.items():
        goal = build(machine, f"-{text}" if text.startswith("min") else text)
        assert abs(goal.evaluate(machine.design)) == pytest.approx(abs(value), rel=2e-5), text
    work = build(machine, "work M_in while s >= 180").evaluate(machine.design)
    assert work == pytest.approx(
        TURN * (torque * inside).mean(), rel=1e-4
    )  # the grid misses both ends by a step


def test_least_value_counts_as_it_is_and_is_made_greater() -> None:
    """The sum is that of the samples, whatever a search does; its optimum has no greater least
    value beside it.
    """
    machine = build_machine(own.file("cam_follower")).with_moved({"values.k_N_m": (1000.0, 2500.0)})
    measures = [
        resolve_measure(machine, measure) for measure in parse_sum("std M_in - 0.5 min N_cam")
    ]
    goal = Goal(machine, measures, (), 40)
    model, phi = MachineResponse(machine, ["M_in", "N_cam"]), 2 * np.pi * np.arange(40) / 40

    def evaluate(x: Array) -> float:
        torque, force = model.values(model.at(x), phi)
        return float(torque.std() - 0.5 * force.min())

    for stiffness in (1200.0, 2000.0):
        assert goal.evaluate(np.array([stiffness])) == pytest.approx(
            evaluate(np.array([stiffness])), rel=1e-12
        )
    optimum = minimise(build_problem(machine, measures, (), 40), SearchSpec(40, "ipopt", 2))
    best = min(evaluate(np.array([k])) for k in np.linspace(1000, 2500, 31))
    assert evaluate(optimum.x) <= best + 1e-9
