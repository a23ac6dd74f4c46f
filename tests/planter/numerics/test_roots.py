"""Newton's method in brackets."""

import numpy as np
import pytest

from planter.kernels import Array
from planter.numerics.roots import newton


def cubic(x: Array) -> tuple[Array, Array]:
    return x**3 - 8, 3 * x**2


def test_each_root_is_found_in_its_own_bracket() -> None:
    low, high = np.array([0.0, 1.9, 2.0]), np.array([3.0, 50.0, 2.5])
    found = newton(cubic, low, high, (cubic(low)[0], cubic(high)[0]))
    assert found == pytest.approx([2.0, 2.0, 2.0], rel=1e-15)


def test_zero_all_along_a_bracket_is_a_root_at_its_start() -> None:
    low, high = np.array([1.0, 0.0]), np.array([2.0, 3.0])

    def rates(x: Array) -> tuple[Array, Array]:
        return np.array([0.0, x[1] - 1]), np.array([0.0, 1.0])

    with np.errstate(all="raise"):
        assert newton(rates, low, high, (np.array([0.0, -1.0]), np.array([0.0, 2.0]))) == pytest.approx([1.0, 1.0])
