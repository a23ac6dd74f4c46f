"""Simultaneous equations over boxes: solutions with derivatives, domains without a root."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from planter.engine.proof import roots
from planter.engine.proof.intervals import Ball
from planter.engine.proof.jets import ANYWHERE, Space
from planter.engine.proof.roots import (
    BallEquations,
    has_rootless_lane,
    solve_linear_jets,
)
from planter.kernels import Array, Integers

LOWER, UPPER = np.array([0.2, 0.4]), np.array([0.3, 0.55])
SHIFT = np.array([0.0, 1.0, 4.0])


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
