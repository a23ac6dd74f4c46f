"""Conditions: two inequalities that hold and fail together, though one is the other times a positive factor."""

from __future__ import annotations

from collections.abc import Iterator

import mpmath
import sympy as sp
from sympy import Expr

from ..evaluate import DIGITS, GUARD, TOLERANCE, Point
from .terms import Points, largest_term, value

SHARES = (-0.01, 0.01, 0.5)
"""Where signs are compared along a symbol: in distances from the boundary to the point, on both sides of it."""


def have_same_truth(one: Expr, other: Expr, points: Points) -> bool:
    """Return whether two residuals have the same sign around every point, and vanish together.

    Along one symbol, in which one of them is linear, the other must vanish where that one does, and have its sign on
    both sides. So a factor that is positive at all points is allowed, and so is a function that grows.
    """
    if not all(_signs_agree(one, other, point) for point in points):
        return False
    symbols = sorted(one.free_symbols & other.free_symbols, key=str)
    return any(all(_alike_along(symbol, one, other, point) for point in points) for symbol in symbols)


def _signs_agree(one: Expr, other: Expr, point: Point) -> bool:
    first, second = value(one, point), value(other, point)
    return first is not None and second is not None and mpmath.sign(first) == mpmath.sign(second)


def _alike_along(symbol: sp.Symbol, one: Expr, other: Expr, point: Point) -> bool:
    for straight, curved in ((one, other), (other, one)):
        slope = straight.diff(symbol)
        if symbol in slope.free_symbols or not value(slope, point):
            continue
        with mpmath.workdps(DIGITS + GUARD):
            distance = point(straight) / point(slope)
            boundary, *around = _moved(point, symbol, point(symbol) - distance, distance)
        left = value(curved, boundary)
        if left is None or abs(left) > TOLERANCE * largest_term(curved, boundary):
            return False
        return all(_signs_agree(straight, curved, at) for at in around if value(curved, at) is not None)
    return False


def _moved(point: Point, symbol: sp.Symbol, boundary: mpmath.mpf, distance: mpmath.mpf) -> Iterator[Point]:
    """The point with a symbol at the boundary, then on both sides of it."""
    for share in (0, *SHARES):
        yield Point(point.values() | {symbol: boundary + share * distance})
