"""Small systems of equations, many at once: solved to rounding, or the first that is not is named."""

from __future__ import annotations

from itertools import cycle

import numpy as np
import pytest

from planter.kernels import Array
from planter.numerics import simultaneous


def circles(level: Array) -> simultaneous.System:
    """Where a circle of radius 1 meets the line y = level."""

    def system(at: Array) -> tuple[Array, Array]:
        x, y = at
        slopes = np.array([[2 * x, 2 * y], [np.zeros_like(x), np.ones_like(x)]])
        return np.array([x**2 + y**2 - 1, y - level]), slopes

    return system


def test_systems_are_solved_to_rounding() -> None:
    level = np.linspace(-0.99, 0.99, 30)
    found = simultaneous.newton(circles(level), np.ones((2, 30)), np.ones(2))
    np.testing.assert_allclose(found, [np.sqrt(1 - level**2), level], atol=1e-14)


def test_the_first_that_has_no_solution_is_named() -> None:
    level = np.array([0.1, 1.5, 2.0])
    with pytest.raises(simultaneous.NotFoundError, match=r"the 2\. of a number") as caught:
        simultaneous.newton(circles(level), np.ones((2, 3)), np.ones(2))
    assert caught.value.index == 1


def test_what_vanishes_to_rounding_is_solved_however_badly_it_determines_its_unknowns() -> None:
    """Rounding of 1e-17 is a step of a hundredth where the slope is 1e-15."""
    rounding = cycle((1e-17, -1e-17))

    def flat(at: Array) -> tuple[Array, Array]:
        return 1e-15 * (at - 1) + next(rounding), np.full((1, 1, 1), 1e-15)

    start = np.full((1, 1), 5.0)
    found = simultaneous.newton(flat, start, np.ones(1), rounding=3e-17)
    assert abs(found[0, 0] - 1) < 0.05
    with pytest.raises(simultaneous.NotFoundError):
        simultaneous.newton(flat, start, np.ones(1))
