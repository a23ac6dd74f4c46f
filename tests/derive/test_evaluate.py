"""Values at a point: to all digits, whatever was asked for first."""

import mpmath
import pytest
import sympy as sp
from mpmath import mpf

from derive.evaluate import DIGITS, Point

x = sp.Symbol("x")


def test_a_branch_that_was_asked_for_first_takes_no_digit_from_a_value() -> None:
    point = Point({x: sp.Rational(1, 3)})
    assert point.holds(sp.Gt(sp.sin(x), 0))
    with mpmath.workdps(DIGITS + 5):
        assert abs(point(sp.sin(x)) - mpmath.sin(mpf(1) / 3)) < mpf(10) ** -DIGITS


@pytest.mark.parametrize(("number", "value"), [(sp.Rational(1, 3), 1), (-sp.Rational(1, 3), -1)])
def test_a_point_takes_the_branch_that_holds_there(number: sp.Rational, value: int) -> None:
    signs = sp.Piecewise((1, sp.And(x > 0, x < 1)), (-1, sp.Or(x < 0, x > 5)))
    assert Point({x: number})(signs) == value
