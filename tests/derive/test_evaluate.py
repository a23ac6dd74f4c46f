"""Values at a point: to all digits, whatever was asked for first."""

import mpmath
import pytest
import sympy as sp
from mpmath import mpf

from derive.evaluate import DIGITS, Point

x = sp.Symbol("x")


def test_earlier_branch_query_keeps_precision() -> None:
    point = Point({x: sp.Rational(1, 3)})
    assert point.holds(sp.Gt(sp.sin(x), 0))
    with mpmath.workdps(DIGITS + 5):
        assert abs(point(sp.sin(x)) - mpmath.sin(mpf(1) / 3)) < mpf(10) ** -DIGITS


@pytest.mark.parametrize(("number", "value"), [(sp.Rational(1, 3), 1), (-sp.Rational(1, 3), -1)])
def test_point_uses_the_valid_branch(number: sp.Rational, value: int) -> None:
    signs = sp.Piecewise((1, sp.And(x > 0, x < 1)), (-1, sp.Or(x < 0, x > 5)))
    assert Point({x: number})(signs) == value
