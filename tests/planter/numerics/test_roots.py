"""Newton's method in brackets, and on many small systems."""

from __future__ import annotations

from itertools import cycle

import numpy as np
import pytest

from planter.kernels import Array
from planter.numerics import roots
from planter.numerics.roots import find_bracketed_roots


def cubic(x: Array) -> tuple[Array, Array]:
    return x**3 - 8, 3 * x**2


def test_roots_lie_in_their_brackets() -> None:
    low, high = np.array([0.0, 1.9, 2.0]), np.array([3.0, 50.0, 2.5])
    result = find_bracketed_roots(cubic, low, high, (cubic(low)[0], cubic(high)[0]))
    assert result == pytest.approx([2.0, 2.0, 2.0], rel=1e-15)


def test_zero_function_has_root_at_bracket_start() -> None:
    low, high = np.array([1.0, 0.0]), np.array([2.0, 3.0])

    def rates(x: Array) -> tuple[Array, Array]:
        return np.array([0.0, x[1] - 1]), np.array([0.0, 1.0])

    with np.errstate(all="raise"):
        assert find_bracketed_roots(
            rates, low, high, (np.array([0.0, -1.0]), np.array([0.0, 2.0]))
        ) == pytest.approx([1.0, 1.0])


def circles(level: Array) -> roots.SystemOfEquations:
    """Where a circle of radius 1 meets the line y = level."""

    def system(at: Array) -> tuple[Array, Array]:
        x, y = at
        slopes = np.array([[2 * x, 2 * y], [np.zeros_like(x), np.ones_like(x)]])
        return np.array([x**2 + y**2 - 1, y - level]), slopes

    return system


def test_systems_are_solved_to_rounding() -> None:
    level = np.linspace(-0.99, 0.99, 30)
    result = roots.solve_systems(circles(level), np.ones((2, 30)), np.ones(2))
    np.testing.assert_allclose(result, [np.sqrt(1 - level**2), level], atol=1e-14)


def test_first_unsolved_system_is_named() -> None:
    level = np.array([0.1, 1.5, 2.0])
    with pytest.raises(roots.UnsolvedSystemError) as caught:
        roots.solve_systems(circles(level), np.ones((2, 3)), np.ones(2))
    assert caught.value.index == 1


def test_small_residual_counts_as_solved() -> None:
    """Rounding of 1e-17 is a step of a hundredth where the slope is 1e-15."""
    rounding = cycle((1e-17, -1e-17))

    def flat(at: Array) -> tuple[Array, Array]:
        return 1e-15 * (at - 1) + next(rounding), np.full((1, 1, 1), 1e-15)

    start = np.full((1, 1), 5.0)
    result = roots.solve_systems(flat, start, np.ones(1), rounding=3e-17)
    assert abs(result[0, 0] - 1) < 0.05
    with pytest.raises(roots.UnsolvedSystemError):
        roots.solve_systems(flat, start, np.ones(1))
