"""Simultaneous equations over boxes: solutions with derivatives, domains without a root."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from planter.engine.proof import roots
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import ANYWHERE, Jet, Space
from planter.engine.proof.roots import (
    BallEquations,
    enclose_roots,
    has_rootless_lane,
    solve_linear_jets,
)
from planter.kernels import Array, Integers

LOWER, UPPER = np.array([0.2, 0.4]), np.array([0.3, 0.55])
SHIFT = np.array([0.0, 1.0, 4.0])
CUBIC_LOWER, CUBIC_WIDTH = np.array([0.1, 0.9, -0.04]), np.array([0.125, 0.1, 0.035])


def solve_exactly(x: Array, shift: float) -> tuple[Array, Array, Array]:
    """Return y, y' and y'' of A y = b with A = [[2 + x0, x1], [x0 x1, 3 + shift]] and b = [x1^2,
    1].
    """
    a, b = np.array([[2 + x[0], x[1]], [x[0] * x[1], 3 + shift]]), np.array([x[1] ** 2, 1])
    first_a = np.array([[[1, 0], [x[1], 0]], [[0, 1], [x[0], 0]]])
    second_a = {(1, 0): np.array([[0, 0], [1, 0]])}
    first_b, second_b = np.array([[0, 0], [2 * x[1], 0]]), {(1, 1): np.array([2.0, 0])}
    inverse = np.linalg.inv(a)
    y = inverse @ b
    first = np.array([inverse @ (first_b[i] - first_a[i] @ y) for i in range(2)])
    second = [
        inverse
        @ (
            second_b.get((i, j), np.zeros(2))
            - second_a.get((i, j), np.zeros((2, 2))) @ y
            - first_a[i] @ first[j]
            - first_a[j] @ first[i]
        )
        for i, j in zip(*np.tril_indices(2), strict=True)
    ]
    return y, first, np.array(second)


def count_misses() -> int:
    """Return how many values and derivatives of exact solutions are outside their enclosures."""
    space = Space(LOWER, UPPER)
    x, shift = space.parameters(), space.constant(Ball.exact(SHIFT))
    matrix = [[x[0] + 2, x[1]], [x[0] * x[1], shift + 3]]
    solution = solve_linear_jets(space, matrix, [x[1] ** 2, 1])
    rng, misses = np.random.default_rng(1), 0
    for _ in range(30):
        x0 = LOWER + rng.random(2) * (UPPER - LOWER)
        for lane, number in enumerate(SHIFT):
            for k, jet in enumerate(solution):
                balls = jet.value[ANYWHERE], jet.gradient[ANYWHERE], jet.hessian
                for ball, exact in zip(balls, solve_exactly(x0, number), strict=True):
                    value, room = exact[..., k], 1e-13
                    inside = (ball.low[..., lane] - room <= value) & (
                        value <= ball.high[..., lane] + room
                    )
                    misses += int((~inside).sum())
    assert max(float(jet.value.rad[ANYWHERE].max()) for jet in solution) < 0.1
    return misses


def test_solutions_are_enclosed_with_two_derivatives() -> None:
    assert count_misses() == 0


def test_solution_without_mixed_terms_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(roots, "sum_products", lambda first, *_: first[0] * first[1])
    assert count_misses() > 0


def test_a_singular_lane_alone_has_no_solution() -> None:
    space = Space(LOWER, UPPER)
    x, shift = space.parameters()[0], space.constant(Ball.exact([1.0, -0.25]))
    (y,) = solve_linear_jets(space, [[x + shift]], [1])
    assert y.is_bounded.tolist() == [True, False]


def meet(distances: Array) -> tuple[int, BallEquations]:
    """Return lanes, and the equations of a circle of radius 1 about 0 and a line x = distance, in
    cosine and length.
    """

    def equations(
        q: Sequence[Ball], lanes: Integers
    ) -> tuple[Sequence[Ball], Sequence[Sequence[Ball]]]:
        angle, height = q
        ball = Ball.exact(np.ones(1))
        return [angle.cos() - Ball.exact(distances[lanes]), angle.sin() - height], [
            [-angle.sin(), ball * Ball.exact(np.zeros(1))],
            [angle.cos(), -ball],
        ]

    return len(distances), equations


@pytest.mark.parametrize(
    ("distances", "is_rootless"), [((0.2, 0.9, -0.99), False), ((0.2, 1.01, 0.9), True)]
)
def test_lanes_without_a_root_are_seen(distances: tuple[float, ...], is_rootless: bool) -> None:
    lanes, equations = meet(np.array(distances))
    upper = np.array([np.pi, 1e3])
    assert has_rootless_lane(equations, -upper, upper, lanes) == is_rootless


def test_domain_next_to_root_is_rootless() -> None:
    lanes, equations = meet(np.array([0.5]))
    upper = np.array([1.0, 1e3])
    assert has_rootless_lane(equations, -upper, upper, lanes)
    assert not has_rootless_lane(equations, -upper, 1.1 * upper, lanes)


def test_root_is_enclosed_with_derivatives() -> None:
    """a^3 + x0 a = x1: derivatives by those of the implicit function."""
    upper = CUBIC_LOWER + CUBIC_WIDTH
    space = Space(CUBIC_LOWER, upper)
    x = space.parameters()

    def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
        return [a[0] ** 3 + x[0] * a[0] - x[1]], [[3 * a[0] ** 2 + x[0]]]

    (root,) = enclose_roots(space, np.array([[0.8]]), residual).jets
    rng = np.random.default_rng(6)
    for _ in range(100):
        p = CUBIC_LOWER + rng.random(3) * CUBIC_WIDTH
        a = float(np.roots([1, 0, p[0], -p[1]])[-1].real)
        slope = 3 * a * a + p[0]
        first = np.array([-a / slope, 1 / slope])
        second = -6 * a / slope * np.outer(first, first)
        second[0, :] -= first / slope
        second[:, 0] -= first / slope
        assert contains(root.value[ANYWHERE], a)
        assert contains(root.gradient[ANYWHERE][:, 0], first)
        assert contains(root.hessian[:, 0], second[np.tril_indices(2)])
    assert root.value.rad[0, 0] < 1e-14


def contains(ball: Ball, value: Array | float) -> bool:
    return bool(((ball.low <= value) & (value <= ball.high)).all())


def test_roots_of_two_equations_are_enclosed_in_every_lane() -> None:
    """(a cos b, a sin b) = (x0 + lane, x1): polar coordinates."""
    lower, upper = np.array([1.0, 0.5]), np.array([1.1, 0.6])
    space, lanes = Space(lower, upper), np.array([0.0, 1.0])
    x, shift = space.parameters(), space.constant(Ball.exact(lanes))

    def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
        radius, angle = a
        cos, sin = angle.call("cos"), angle.call("sin")
        return [radius * cos - x[0] - shift, radius * sin - x[1]], [
            [cos, -radius * sin],
            [sin, radius * cos],
        ]

    roots, rng = (
        enclose_roots(space, np.array([[1.2, 2.1], [0.5, 0.3]]), residual).jets,
        np.random.default_rng(3),
    )
    for _ in range(50):
        px, py = (lower + rng.random(2) * (upper - lower))[:, None] + np.array([lanes, 0 * lanes])
        r2, r = px**2 + py**2, np.hypot(px, py)
        exact = [
            (r, (px / r, py / r), (py**2 / r**3, -px * py / r**3, px**2 / r**3)),
            (
                np.arctan2(py, px),
                (-py / r2, px / r2),
                (2 * px * py / r2**2, (py**2 - px**2) / r2**2, -2 * px * py / r2**2),
            ),
        ]
        for jet, (value, first, second) in zip(roots, exact, strict=True):
            assert contains(jet.value[ANYWHERE], value)
            assert contains(jet.gradient[ANYWHERE], np.array(first))
            assert contains(jet.hessian, np.array(second))
    assert max(jet.value.rad[0].max() for jet in roots) < 1e-13


def test_uncertain_root_is_refused() -> None:
    space = Space(np.array([-1.0]), np.array([1.0]))
    (x,) = space.parameters()
    with pytest.raises(Unbounded):
        enclose_roots(space, np.array([[0.5]]), lambda a: ([a[0] ** 2 - x], [[2 * a[0]]]))
