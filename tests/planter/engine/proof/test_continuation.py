"""Roots followed from one assembly: by planter and by the checker, through a whole cycle, up to dead
points, and never into another assembly.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from planter.engine.proof import check_proof, continuation
from planter.engine.proof.check_proof import append_jacobian, evaluate_plainly
from planter.engine.proof.continuation import AssemblyStart
from planter.engine.proof.enclosures import ResponseProgram, ResponseRecorder, RootBranch
from planter.engine.proof.intervals import Unbounded
from planter.engine.proof.jets import ANYWHERE, Space
from planter.engine.proof.programs import record_program
from planter.kernels import Array
from tests.planter.engine.proof.toys import enclose_samples

LOWER, UPPER = np.array([0.3]), np.array([0.35])


def swing(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """The angle q of a rod on a crank of the length x: sin q = x sin phi; the Jacobian is wrong,
    and not taken.
    """
    q, phi, x = inputs
    return [xp.sin(q) - x * xp.sin(phi), 1e9]


def spin(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """q = e^(i phi / 2) as a square root: after a turn it is another."""
    a, b, phi, x = inputs
    return [a**2 - b**2 - x * xp.cos(phi), 2 * a * b - x * xp.sin(phi)]


def build_response(code: Any, count: int) -> ResponseProgram:
    """Return the cosine of a root as a response of one parameter."""
    recorder = ResponseRecorder(1)
    roots = recorder.call(code, [recorder.phi, 0], [np.pi] * count)
    recorder.call(lambda xp, q: [xp.cos(q[0])], roots)
    return ResponseProgram(1, tuple(recorder.stages), (Fraction(0),), Fraction(1), True)


SWING = build_response(swing, 1)
STARTS = {"near": 0.0, "far": np.pi}


def follow(response: ResponseProgram, lower: Array, upper: Array, *roots: float) -> RootBranch:
    return AssemblyStart(LOWER, [list(roots)]).follow(response, lower, upper)


def follow_apart(response: ResponseProgram, lower: Array, upper: Array, *roots: float) -> list[Any]:
    """Return the balls of the independent checker, None where roots were not followed to."""
    document = AssemblyStart(LOWER, [list(roots)]).to_document()
    programs = check_proof.Response(response.to_document())
    branch = check_proof.FollowedRoots(programs, document, lower.tolist(), upper.tolist())
    balls: list[Any] = branch.parts[0]
    return balls


@pytest.mark.parametrize("name", STARTS)
def test_roots_of_the_assembly_that_is_meant_are_enclosed(name: str) -> None:
    start = STARTS[name]
    branch = follow(SWING, LOWER, UPPER, start)
    balls = follow_apart(SWING, LOWER, UPPER, start)
    assert branch.is_whole
    assert all(balls)
    for x in (0.3, 0.33, 0.35):
        for phi in np.linspace(0, 2 * np.pi, 25, endpoint=False):
            angle = np.arcsin(x * np.sin(phi))
            root, other = (angle, np.pi - angle) if start == 0 else (np.pi - angle, angle)
            part = branch.find_near(0, np.array([phi]))[0, 0]
            k = int(phi / (2 * np.pi) * len(balls))
            radius = branch.radii[0][0, k]
            assert abs(root - part) <= radius < abs(other - part)
            (point,), (radius_apart,) = balls[k]
            assert abs(root - point) <= float(radius_apart) < abs(other - point)
    (jet,) = enclose_samples(SWING, Space(LOWER, UPPER), 12, AssemblyStart(LOWER, [[start]]))
    sign = 1 if start == 0 else -1
    assert (sign * jet.value.mid[ANYWHERE] > 0.8).all()


def test_dead_points_end_the_way_from_both_sides() -> None:
    """A crank as long as the rod is in line with it at 90 and 270 deg."""
    lower, upper = np.array([0.98]), np.array([1.02])
    branch = follow(SWING, lower, upper, 0.0)
    is_reached = ~np.isnan(branch.radii[0][0])
    angles = (np.arange(len(is_reached)) + 0.5) / len(is_reached) * 2 * np.pi
    assert not is_reached[np.abs(np.cos(angles)) < 0.2].any()
    assert not is_reached[np.cos(angles) < 0].any(), "beyond dead points no assembly is is_reached"
    assert is_reached[np.cos(angles) > 0.5].all(), "before and after the cycle's begin it is"
    ours = [ball is not None for ball in follow_apart(SWING, lower, upper, 0.0)]
    assert np.array_equal(ours, is_reached)


def test_roots_that_do_not_return_after_a_period_are_not_meant() -> None:
    response = build_response(spin, 2)
    root = float(np.sqrt(LOWER[0]))
    assert np.isnan(follow(response, LOWER, UPPER, root, 0.0).radii[0]).all()
    assert not any(follow_apart(response, LOWER, UPPER, root, 0.0))


def test_starts_that_are_no_roots_lead_nowhere() -> None:
    assert np.isnan(follow(SWING, LOWER, UPPER, 0.05).radii[0]).all()
    assert not any(follow_apart(SWING, LOWER, UPPER, 0.05))


def test_roots_of_the_other_assembly_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers near the other roots, wherever they come from, have no bound."""
    branch = follow(SWING, LOWER, UPPER, 0.0)
    space = Space(LOWER, UPPER)
    phi = space.lift(np.array([0.3, 2.0]))
    assert SWING.enclose(space, phi, [branch])[0].is_bounded.all()
    monkeypatch.setattr(RootBranch, "find_near", lambda *_: np.full((1, 2), np.pi))
    with pytest.raises(Unbounded, match="not those that are meant"):
        SWING.enclose(space, phi, [branch])


def test_neighbours_with_other_roots_are_not_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the numbers change to the other assembly on the way, it ends there."""
    honest = continuation.follow_plainly

    def change(stages: Any, starts: Any, points: Any) -> list[Any]:
        way = honest(stages, starts, points)
        half = len(way) // 2
        return [*way[:half], *([[np.pi - roots[0][0]]] for roots in way[half:])]

    for module in (continuation, check_proof):
        monkeypatch.setattr(module, "follow_plainly", change)
    is_reached = ~np.isnan(follow(SWING, LOWER, UPPER, 0.0).radii[0][0])
    assert is_reached[:20].all()
    assert not is_reached.all()
    assert not all(follow_apart(SWING, LOWER, UPPER, 0.0))


def smooth(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """Every operation that a residual may have."""
    a, b, c = inputs
    first = xp.sqrt(a) * xp.exp(b * c) + xp.log(a + 2) / (1 + b**3) - xp.arctan(a * b)
    second = xp.arctan2(a, b + 2) + xp.sin(a - c) * xp.cos(b) + xp.polyval([0.3, -1.0, 2.0], a * b)
    return [first, second, xp.absolute(b - a) * xp.floor(a + 0.25) + c]


def test_derivatives_of_programs_are_those_of_differences() -> None:
    program = record_program(smooth, 3)
    steps, outputs = append_jacobian(program.operations, program.outputs, 2)
    x, step = np.array([0.8, 0.3, -0.4]), 1e-6
    rows = evaluate_plainly(steps, outputs, x.tolist())
    assert rows[:3] == evaluate_plainly(program.operations, program.outputs, x.tolist())
    for place in range(2):
        shift = step * np.eye(3)[place]
        above, below = (
            np.array(evaluate_plainly(program.operations, program.outputs, (x + way).tolist()))
            for way in (shift, -shift)
        )
        assert rows[3 + place :: 2] == pytest.approx((above - below) / (2 * step), abs=1e-8)
