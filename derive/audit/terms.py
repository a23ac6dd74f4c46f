"""Two equations as sums of terms, matched term by term."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import mpmath
import sympy as sp
from sympy import Expr, Rational, S

from ..evaluate import DIGITS, GUARD, TOLERANCE, NotEvaluated, Point


@cache
def expanded(expr: Expr) -> tuple[Expr, ...]:
    """Terms of an expression multiplied out; none for zero. Summand by summand, for edits change but one."""
    if isinstance(expr, sp.Add):
        whole = sp.Add(*(term for summand in expr.args for term in expanded(summand)))
    else:
        whole = sp.expand(expr, trig=False)
    return tuple(t for t in sp.Add.make_args(whole) if t != 0)


@cache
def largest_term(expr: Expr, point: Point) -> mpmath.mpf:
    """Size of the largest term of an expression multiplied out."""
    return max((abs(point(term)) for term in expanded(expr)), default=mpmath.mpf(0))


def value(expr: Expr, point: Point) -> mpmath.mpf | None:
    """Value of an expression at a point; None where it has no real one, as the arc sine of 2. Symbols must be known."""
    try:
        return point(expr)
    except (NotEvaluated, ZeroDivisionError, TypeError):
        if not all(symbol in point for symbol in expr.free_symbols):
            raise
        return None


@dataclass(frozen=True)
class Match:
    """What is left of two sums when equal terms are struck out: of the first and of the second."""

    printed: tuple[Expr, ...]
    derived: tuple[Expr, ...]

    @property
    def equal(self) -> bool:
        return not self.printed and not self.derived


Sums = list[tuple[Expr, Rational, Rational]]
"""Monomials, each with its coefficient in the first and in the second of two sums."""


def collected(printed: Iterable[Expr], derived: Iterable[Expr], points: list[Point]) -> Sums:
    """The monomials of two sums up to a rational coefficient; equal ones, however written, are one."""
    sums: dict[tuple[str, ...], tuple[Expr, Rational, Rational]] = {}
    for side, terms in ((0, printed), (1, derived)):
        for term in terms:
            coefficient, monomial = term.as_coeff_Mul(rational=True)
            sign, key = _key(monomial, points)
            first, *both = sums.get(key, (sign * monomial, S.Zero, S.Zero))
            both[side] += sign * coefficient
            sums[key] = (first, both[0], both[1])
    return list(sums.values())


def matched(printed: Iterable[Expr], derived: Iterable[Expr], points: list[Point]) -> Match:
    """Strike out what both sums share, monomial by monomial.

    A printed term that is one of several like ones leaves the others as missing; one that differs otherwise, in sign or
    size, is left whole, and so is the derived one.
    """
    left: tuple[list[Expr], list[Expr]] = [], []
    for monomial, p, d in collected(printed, derived, points):
        if p != 0 and not ((d / p).is_Integer and d / p > 0):
            left[0].append(p * monomial)
            left[1].extend([d * monomial] if d != 0 else [])
        elif p != d:
            left[1].append((d - p) * monomial)
    return Match(tuple(left[0]), tuple(left[1]))


def overall_factor(printed: Iterable[Expr], derived: Iterable[Expr], points: list[Point]) -> Rational:
    """The factor by which more than half, and more than one, of the terms that two sums share are larger in the first.

    One where there is no such factor.
    """
    ratios = Counter(p / d for _, p, d in collected(printed, derived, points) if p != 0 and d != 0)
    ratio, count = max(ratios.items(), key=lambda found: found[1], default=(S.One, 0))
    return ratio if 1 < count > ratios.total() / 2 else S.One


def _key(monomial: Expr, points: list[Point]) -> tuple[int, tuple[str, ...]]:
    """Sign of a monomial at the first point, and its values with that sign taken out, to compare by."""
    if any(value(monomial, point) is None for point in points):
        return 1, (str(monomial),)
    first, *others = (point.digits(monomial) for point in points)
    sign = -1 if first.startswith("-") else 1
    flipped = first, *others
    return sign, flipped if sign > 0 else tuple(t[1:] if t.startswith("-") else f"-{t}" for t in flipped)


def remainder_vanishes(match: Match, points: list[Point]) -> bool:
    """Whether what is left is zero as a whole, though not term by term."""
    for point in points:
        if any(value(t, point) is None for t in match.printed):
            return False
        with mpmath.workdps(DIGITS + GUARD):
            values = [point(t) for t in match.printed] + [-point(t) for t in match.derived]
            size = max((abs(v) for v in values), default=mpmath.mpf(0))
            if abs(mpmath.fsum(values)) > TOLERANCE * size:
                return False
    return True
