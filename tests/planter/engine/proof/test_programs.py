"""Recorded programs: C against NumPy and an interval library, conditions asked once, code that
cannot be recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from flint import arb

from planter.engine.proof.intervals import Branches, Unbounded
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space
from planter.engine.proof.programs import (
    CODES,
    Code,
    UnrecordedError,
    record_program,
)
from planter.kernels import Array
from tests.support import xp_arb

LOWER, UPPER = np.array([0.40, 0.70, -0.35, 0.2]), np.array([0.42, 0.71, -0.33, 0.2])
ANGLES = np.linspace(0.1, 6.0, 37)
NOTHING = np.empty((0, len(ANGLES)))


def smooth(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """Every function without a condition that changes within the box."""
    phi, a, b, c, d = inputs
    radius = xp.sqrt(a**2 + b * xp.cos(phi) ** 2 + 1.5)
    angle = xp.arctan2(a * xp.sin(phi) + 1.2, b + 0.1 * xp.cos(phi))
    wave = xp.exp(c * xp.sin(phi)) * xp.log(radius + d) + xp.arctan(angle * b)
    return [
        radius / (2 - a) + angle - c**-2,
        wave,
        xp.polyval([0.3, -1.0, 0.5, 2.0], a * radius) * xp.pi,
        xp.arcsin(c / 2) + xp.arccos(b / 2) + xp.tan(a / 3),
        c * 1.0,
        phi * d,
    ]


def broken(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """Conditions of each kind, some of which the box leaves open."""
    phi, a, b, c, d = inputs
    turned = phi - 2 * xp.floor((phi + a) / 2)
    inside = xp.logical_and(turned - 1 <= a, xp.logical_not(phi > 4 + b))
    bent = xp.where(xp.logical_or(inside, phi < 0.2), a * turned, b - turned**2)
    return [
        bent + xp.absolute(xp.sin(phi) - c * d),
        xp.maximum(a * phi, b + phi / 2) * xp.minimum(c, xp.cos(phi)),
        xp.sign(phi - 3 + c) * a,
    ]


def find_inputs(space: Space) -> list[Jet]:
    place = space.linear(ANGLES, np.linspace(-1, 1, 4 * len(ANGLES)).reshape(-1, 4))
    return [place, *space.parameters()]


def enclose_by_numpy(
    code: Code, space: Space, lanes: Array, script: Array
) -> tuple[Branches, Sequence[Jet]]:
    runner = record_program(code, 5)
    vars(runner)["is_compiled"] = False
    return runner.enclose(space, find_inputs(space), lanes, script)


def follow(
    enclose: Callable[[Array, Array], tuple[Branches, Sequence[Jet]]],
) -> list[tuple[Any, ...]]:
    """Return all smooth pieces as (lane, values), sorted."""
    lanes, script, pieces = np.arange(len(ANGLES)), NOTHING, []
    while len(lanes):
        branches, jets = enclose(lanes, script)
        values = [np.broadcast_to(jet.value.mid[CENTRE], len(lanes)) for jet in jets]
        pieces += [
            (int(lane), *(float(value[k]) for value in values)) for k, lane in enumerate(lanes)
        ]
        further, script = branches.further()
        lanes = lanes[further]
    return sorted(pieces)


@pytest.mark.parametrize("code", [smooth, broken])
def test_c_gives_the_balls_of_numpy(code: Code) -> None:
    space, lanes = Space(LOWER, UPPER), np.arange(len(ANGLES))
    runner = record_program(code, 5)
    _, jets = runner.enclose(space, find_inputs(space), lanes, NOTHING)
    assert runner.is_compiled, "a machine without a compiler cannot run this test"
    _, expected = enclose_by_numpy(code, space, lanes, NOTHING)
    for jet, other in zip(jets, expected, strict=True):
        ball, same = jet.rows, other.over(jet.support).rows
        scale = 1 + np.abs(same.mid) + same.rad
        assert (np.abs(ball.mid - same.mid) <= 1e-13 * scale).all()
        assert (np.abs(ball.rad - same.rad) <= 1e-11 * same.rad + 1e-15 * scale).all()


def test_functions_at_points_are_not_cut_by_the_box() -> None:
    """Roots are differentiated along lines whose values hold at single designs: Taylor forms of the
    box do not.
    """
    space, lanes = Space(LOWER, UPPER), np.arange(len(ANGLES))
    (cut, *_) = (record_program(smooth, 5)).enclose(space, find_inputs(space), lanes, NOTHING)[1]
    space.is_cutting = False
    if True:
        (free, *_) = (record_program(smooth, 5)).enclose(space, find_inputs(space), lanes, NOTHING)[
            1
        ]
        (other, *_) = enclose_by_numpy(smooth, space, lanes, NOTHING)[1]
    assert (free.value.rad[ANYWHERE] > cut.value.rad[ANYWHERE]).all()
    np.testing.assert_allclose(free.value.rad[ANYWHERE], other.value.rad[ANYWHERE], rtol=1e-11)


def test_c_follows_the_branches_of_numpy() -> None:
    space, compiled = Space(LOWER, UPPER), (record_program(broken, 5))
    pieces = follow(
        lambda lanes, script: compiled.enclose(space, find_inputs(space), lanes, script)
    )
    expected = follow(lambda lanes, script: enclose_by_numpy(broken, space, lanes, script))
    assert len(pieces) > len(ANGLES), "the box leaves some condition open"
    assert {lane for lane, *_ in pieces} == set(range(len(ANGLES)))
    rounded = [{tuple(np.round(piece, 9)) for piece in some} for some in (pieces, expected)]
    assert rounded[0] == rounded[1]


def test_c_encloses_an_interval_library() -> None:
    space = Space(LOWER, UPPER)
    inputs, rng = find_inputs(space), np.random.default_rng(4)
    _, jets = (record_program(smooth, 5)).enclose(space, inputs, np.arange(len(ANGLES)), NOTHING)
    slopes = np.linspace(-1, 1, 4 * len(ANGLES)).reshape(-1, 4)
    for _ in range(5):
        x = LOWER + rng.random(4) * (UPPER - LOWER)
        for lane in (0, 11, 30):
            phi = arb(float(ANGLES[lane]))
            for k in range(3):
                phi += arb(float(slopes[lane, k])) * (
                    arb(float(x[k])) - arb(float(space.centre[k]))
                )
            exact = smooth(xp_arb, [phi, *(arb(float(v)) for v in x)])
            for jet, value in zip(jets, exact, strict=True):
                ball = jet.value[ANYWHERE][lane if jet.lanes > 1 else 0]
                assert arb(float(ball.low)) <= value <= arb(float(ball.high))


def test_a_condition_is_asked_once() -> None:
    """Asked twice, a box in which it is open would follow a piece on which it holds and does not
    hold.
    """

    def twice(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        a, b = inputs
        return [xp.where(a - b < 0, a, b) + xp.where(a - b < 0, b, a)]

    program = record_program(twice, 2)
    assert len(program.jumps) == 1
    space = Space(np.array([0.0, 0.0]), np.array([1.0, 1.0]))
    branches, (jet,) = program.enclose(space, space.parameters(), np.arange(1), np.empty((0, 1)))
    assert len(branches.alternatives) == 1
    assert jet.value.mid[CENTRE] == pytest.approx(1.0)
    with pytest.raises(Unbounded, match="several answers"):
        program.enclose_smooth(space, space.parameters())


def test_programs_have_no_operation_that_nothing_needs() -> None:
    program = record_program(
        lambda xp, inputs: [inputs[0] + 0 * xp.sin(inputs[1]), inputs[0] + 1], 3
    )
    names = [program.operations[n].name for n in program.order]
    assert names.count("add") == 2
    assert set(names) <= set(CODES)
    unused = record_program(lambda xp, inputs: [xp.sin(inputs[0]), inputs[1] * 2][:1], 2)
    assert [unused.operations[n].name for n in unused.order] == ["input", "sin"]


def test_code_that_is_no_straight_line_is_refused() -> None:
    with pytest.raises(UnrecordedError):
        record_program(lambda _, inputs: [inputs[0] + np.ones(2)], 1)


def test_powers_that_are_not_whole_are_enclosed() -> None:
    def code(_: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        a, b, *_ = inputs
        return [(a + 1) ** 1.5, (a + b) ** -0.3, 2.0 ** (a * b), (a + 1) ** b]

    runner = record_program(code, 4)
    jets = runner.enclose_smooth(space := Space(LOWER, UPPER), space.parameters())
    rng = np.random.default_rng(3)
    for _ in range(50):
        values = code(np, [float(value) for value in rng.uniform(LOWER, UPPER)])
        for value, jet in zip(values, jets, strict=True):
            mid, rad = (
                np.ravel(side)[-1] for side in (jet.value[ANYWHERE].mid, jet.value[ANYWHERE].rad)
            )
            assert abs(value - mid) <= rad
            assert rad < 0.05


def test_power_of_what_may_be_negative_has_no_bound() -> None:
    runner = record_program(lambda _, inputs: [inputs[2] ** 0.5], 4)
    (jet,) = runner.enclose_smooth(space := Space(LOWER, UPPER), space.parameters())
    assert not np.isfinite(jet.value[ANYWHERE].rad).any()


def test_simultaneous_equations_are_solved_in_numpy() -> None:
    def solve(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        phi, a, b, c, d = inputs
        y, z = xp.solve([[2 + a, xp.sin(phi)], [b, -3.0]], [c, d])
        return [(2 + a) * y + xp.sin(phi) * z - c, y]

    program, space = record_program(solve, 5), Space(LOWER, UPPER)
    runner = program
    assert not runner.is_compiled
    rest, y = runner.enclose_smooth(space, find_inputs(space))
    assert (np.abs(rest.value.mid[CENTRE]) <= rest.value.rad[CENTRE] + 1e-15).all()
    assert np.ptp(y.value.mid[CENTRE]) > 0.01
