"""Joints of the force curve: where they are, how they move."""

import numpy as np
import pytest

from planter.engine.solvers.response import find_breakpoints, list_breakpoints
from planter.errors import ComputationError
from planter.numerics import roots
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toys import difference


def test_joints_of_the_machine_lie_where_closed_forms_put_them():
    machine = toys.device()
    alpha3, m31 = machine.design[2], machine.design[6]
    breakpoints = list_breakpoints(machine.force, machine.prologue(machine.design))
    angles = {(place.name, place.side): place.angle for place in breakpoints}
    assert angles["gear 3, t = 0", 1] == pytest.approx(2 * np.pi - alpha3, abs=1e-13)
    assert angles["gear 3, t = pi/m", 1] == pytest.approx(np.pi / m31 - alpha3, abs=1e-13)
    assert angles["gear 3, t = pi/m", 2] == pytest.approx(np.pi / m31 - alpha3 + np.pi, abs=1e-13)
    assert [p.angle for p in breakpoints] == sorted(p.angle for p in breakpoints)


def test_joints_are_joints():
    """Each of the machine's breakpoints of order 1 that the force feels is a jump of its slope."""
    response = toys.planting()
    at = response.prologue(response.design)
    breakpoints = find_breakpoints(response, at)
    for angle, name in zip(breakpoints.angles, breakpoints.names, strict=True):
        if name.startswith("gear 3") or name == "gear 6, t = pi/m":
            neighbours = np.array([angle - 1e-4, angle - 1e-9, angle + 1e-9, angle + 1e-4])
            jumps = np.abs(np.diff(response.curves.derivatives(at, neighbours)[1][0]))
            bend = max(jumps[[0, 2]]) / 1e-4
            assert jumps[1] > 1000 * bend * 2e-9


@pytest.mark.parametrize("response", [toys.planting(), toys.bent()], ids=["machine", "toy"])
def test_velocity_and_acceleration_agree_with_differences(response):
    width = response.upper - response.lower
    x = response.lower + 0.4 * width

    def at(y):
        return find_breakpoints(response, response.prologue(y))

    breakpoints = at(x)
    slopes = difference(lambda y: at(y).angles, x, 1e-4 * width)
    assert breakpoints.velocity * width == pytest.approx(slopes * width, abs=2e-7)
    bends = difference(lambda y: at(y).velocity, x, 1e-4 * width)
    indices = breakpoints.acceleration(np.arange(len(breakpoints.angles)))
    assert indices * width * width[:, None] == pytest.approx(
        bends * width * width[:, None], abs=2e-7
    )


def test_a_response_without_events_has_no_joints():
    toy = toys.third_harmonic()
    assert len(find_breakpoints(toy, toy.prologue(toy.design)).angles) == 0


def test_safeguarded_newton_locates_all_roots():
    def arctan(x):
        return np.arctan(x - 0.3), 1 / (1 + (x - 0.3) ** 2)

    low, high = np.array([-200.0, -1.0]), np.array([3.0, 400.0])
    ends = arctan(low)[0], arctan(high)[0]
    assert roots.find_bracketed_roots(arctan, low, high, ends) == pytest.approx(
        [0.3, 0.3], abs=1e-15
    )


def test_newton_says_where_it_failed():
    """A root of order nine is approached too slowly."""

    def flat(x):
        return (x - 0.3) ** 9, 9 * (x - 0.3) ** 8

    low, high = np.array([0.0]), np.array([1.0])
    with pytest.raises(ComputationError, match="not found"):
        roots.find_bracketed_roots(flat, low, high, (flat(low)[0], flat(high)[0]))
