"""Two equations as sums of terms, matched term by term; two inequalities by their sign; one to
first order about an equilibrium.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import mpmath
import sympy as sp
from sympy import Expr, Rational, S

from ..evaluate import DIGITS, GUARD, TOLERANCE, NotEvaluated, Point

Points = tuple[Point, ...]
Key = tuple[str, ...]
"""Values of a monomial at some points, or its text where it has none: what monomials are told apart
by.
"""
Sum = dict[Key, tuple[Expr, Rational]]
"""Monomials with their rational coefficients; equal ones, however written, are one."""


@cache
def expand_sum(expr: Expr) -> tuple[Expr, ...]:
    """Terms of an expression multiplied out; none for zero.

    Summand by summand, for edits change but one.
    """
    if isinstance(expr, sp.Add):
        expanded_expr = sp.Add(*(term for summand in expr.args for term in expand_sum(summand)))
    else:
        expanded_expr = sp.expand(expr, trig=False)
    return tuple(t for t in sp.Add.make_args(expanded_expr) if t != 0)


@cache
def largest_term(expr: Expr, point: Point) -> mpmath.mpf:
    """Size of the largest term of an expression multiplied out."""
    return max((abs(point(term)) for term in expand_sum(expr)), default=mpmath.mpf(0))


def list_unknown(expr: Expr, points: Iterable[Point]) -> list[str]:
    """List the symbols of an expression that have no value at some of the points."""
    return sorted({str(s) for point in points for s in expr.free_symbols if s not in point})


def evaluate_at(expr: Expr, point: Point) -> mpmath.mpf | None:
    """Value of an expression at a point; None where it has no real one, as the arc sine of 2.

    Symbols must be known.
    """
    try:
        return point(expr)
    except (NotEvaluated, ZeroDivisionError, TypeError):
        if list_unknown(expr, [point]):
            raise
        return None


def format_value(expr: Expr, point: Point) -> str:
    """Return the value of an expression at a point in six digits."""
    value = evaluate_at(expr, point)
    return "no real value" if value is None else mpmath.nstr(value, 6)


def holds(residual: Expr, points: Points) -> bool:
    """Whether a residual vanishes at every point."""
    return all(_vanishes(residual, point) for point in points)


def differs_by_turns(residual: Expr, points: Points) -> bool:
    """Whether an angle [rad] is a whole number of turns at every point, not the same at all."""
    with mpmath.workdps(DIGITS + GUARD):
        turn = 2 * mpmath.pi  # to the digits in force
        values = [evaluate_at(residual, point) for point in points]
        return all(
            value is not None and abs(value - turn * mpmath.nint(value / turn)) <= TOLERANCE * turn
            for value in values
        )


TERMS_AT_MOST = 10**6
"""Terms of a summand multiplied out, at most: the largest of them is at least this share of the
summand.

What is small beside the summands is so beside the largest term too, so that nothing needs to be
multiplied out.
"""


def _vanishes(residual: Expr, point: Point) -> bool:
    remainder = evaluate_at(residual, point)
    if remainder is None:
        return False
    summands = max(abs(point(summand)) for summand in sp.Add.make_args(residual))
    if summands > 0 and abs(remainder) <= TOLERANCE * summands / TERMS_AT_MOST:
        return True
    if abs(remainder) > TOLERANCE * _bound_terms(residual, point):
        return False
    return abs(remainder) <= TOLERANCE * largest_term(residual, point)


@cache
def _bound_terms(expr: Expr, point: Point) -> mpmath.mpf:
    """Return what no term of an expression multiplied out exceeds, found without multiplying it
    out.
    """
    if isinstance(expr, sp.Add):
        return sum((_bound_terms(summand, point) for summand in expr.args), mpmath.mpf(0))
    if isinstance(expr, sp.Mul):
        return mpmath.fprod(_bound_terms(factor, point) for factor in expr.args)
    if isinstance(expr, sp.Pow) and expr.exp.is_Integer and expr.exp > 0:
        return _bound_terms(expr.base, point) ** int(expr.exp)
    return abs(point(expr))


def find_largest_size(expr: Expr, cycle: Sequence[Point]) -> mpmath.mpf | None:
    """Return the largest size of an expression over a cycle; None if it has no real value at some
    point of it.
    """
    if list_unknown(expr, cycle):
        return None
    values = [evaluate_at(expr, point) for point in cycle]
    return None if None in values else max((abs(v) for v in values if v is not None), default=None)


def to_monomials(expr: Expr, points: Points) -> Sum:
    """An expression as a sum of monomials."""
    if not isinstance(expr, sp.Add):
        return _monomials(expr, points)
    total: Sum = {}
    for summand in expr.args:
        for key, (monomial, coefficient) in _monomials(summand, points).items():
            representative, before = total.get(key, (monomial, S.Zero))
            total[key] = representative, before + coefficient
    return {key: entry for key, entry in total.items() if entry[1] != 0}


@cache
def _monomials(expr: Expr, points: Points) -> Sum:
    total: Sum = {}
    for term in expand_sum(expr):
        coefficient, monomial = term.as_coeff_Mul(rational=True)
        sign, key = _key(monomial, points)
        representative, before = total.get(key, (sign * monomial, S.Zero))
        total[key] = representative, before + sign * coefficient
    return {key: entry for key, entry in total.items() if entry[1] != 0}


@cache
def _key(monomial: Expr, points: Points) -> tuple[int, Key]:
    """Sign of a monomial at the first point, and its values with that sign taken out."""
    if any(evaluate_at(monomial, point) is None for point in points):
        return 1, (str(monomial),)
    first, *rest = (point.digits(monomial) for point in points)
    sign = -1 if first.startswith("-") else 1
    flipped = first, *rest
    return sign, flipped if sign > 0 else tuple(
        t[1:] if t.startswith("-") else f"-{t}" for t in flipped
    )


@dataclass(frozen=True)
class Match:
    """Terms that are left of two sums when equal terms are removed: of the first and of the
    second.

    ``unlike`` counts the monomials that are left of both.
    """

    printed: tuple[Expr, ...]
    derived: tuple[Expr, ...]
    unlike: int = field(default=0, compare=False)

    @property
    def size(self) -> int:
        """Return the number of monomials that differ."""
        return len(self.printed) + len(self.derived) - self.unlike

    @property
    def unmatched(self) -> int:
        """Return the distance of the second sum from the first; an unlike monomial counts half."""
        return 2 * len(self.derived) - self.unlike

    def vanishes(self, points: Points) -> bool:
        """Whether what is left is zero as a whole, though not term by term."""
        return holds(sp.Add(*self.printed, *(-term for term in self.derived)), points)


def pair_monomials(printed: Sum, derived: Sum) -> Iterable[tuple[Expr, Rational, Rational]]:
    """Every monomial of two sums with its coefficient in the first and in the second."""
    for key in {**printed, **derived}:
        monomial, _ = printed.get(key) or derived[key]
        yield monomial, _coefficient(printed, key), _coefficient(derived, key)


def _coefficient(total: Sum, key: Key) -> Rational:
    return total[key][1] if key in total else S.Zero


def match_sums(printed: Sum, derived: Sum) -> Match:
    """Strike out what both sums share, monomial by monomial.

    A printed term that is one of several like ones leaves the others as missing; one that differs
    otherwise, in sign or size, is left whole, and so is the derived one.
    """
    left: tuple[list[Expr], list[Expr]] = [], []
    unlike = 0
    for monomial, p, d in pair_monomials(printed, derived):
        if p != 0 and not ((d / p).is_Integer and d / p > 0):
            left[0].append(p * monomial)
            left[1].extend([d * monomial] if d != 0 else [])
            unlike += d != 0
        elif p != d:
            left[1].append((d - p) * monomial)
    return Match(tuple(left[0]), tuple(left[1]), unlike)


def overall_factor(printed: Sum, derived: Sum) -> Rational:
    """The factor by which more than half, and more than one, of the terms that two sums share are
    larger in the first.

    One where there is no such factor.
    """
    ratios = Counter(p / d for _, p, d in pair_monomials(printed, derived) if p != 0 and d != 0)
    ratio, count = max(ratios.items(), key=lambda item: item[1], default=(S.One, 0))
    return ratio if 1 < count > ratios.total() / 2 else S.One


def common_factor(expr: Expr) -> Expr:
    """The product of powers that every term of a sum has in common; numbers are no part of it."""
    powers: list[Mapping[Expr, Expr]] = [
        {
            base: power
            for base, power in term.as_powers_dict().items()
            if base.free_symbols and power.is_Rational
        }
        for term in expand_sum(expr)
    ]
    bases = sorted(set().union(*powers), key=sp.default_sort_key)
    lowest = {base: min(exponents.get(base, S.Zero) for exponents in powers) for base in bases}
    return sp.Mul(*(base**power for base, power in lowest.items()))


SHARES = (-0.01, 0.01, 0.5)
"""Where signs are compared along a symbol: in distances from the boundary to the point, on both
sides of it.
"""


def have_same_truth(first: Expr, second: Expr, points: Points) -> bool:
    """Return whether two residuals have the same sign around every point, and vanish together.

    Along one symbol, in which one of them is linear, the other must vanish where that one does, and
    have its sign on both sides. So a factor that is positive at all points is allowed, and so is a
    function that grows.
    """
    if not all(_signs_agree(first, second, point) for point in points):
        return False
    symbols = sorted(first.free_symbols & second.free_symbols, key=str)
    return any(
        all(_alike_along(symbol, first, second, point) for point in points) for symbol in symbols
    )


def _signs_agree(first_residual: Expr, second_residual: Expr, point: Point) -> bool:
    first, second = evaluate_at(first_residual, point), evaluate_at(second_residual, point)
    return first is not None and second is not None and mpmath.sign(first) == mpmath.sign(second)


def _alike_along(symbol: sp.Symbol, first: Expr, second: Expr, point: Point) -> bool:
    for straight, curved in ((first, second), (second, first)):
        slope = straight.diff(symbol)
        if symbol in slope.free_symbols or not evaluate_at(slope, point):
            continue
        with mpmath.workdps(DIGITS + GUARD):
            distance = point(straight) / point(slope)
            boundary, *on_both_sides = _moved(point, symbol, point(symbol) - distance, distance)
        left = evaluate_at(curved, boundary)
        if left is None or abs(left) > TOLERANCE * largest_term(curved, boundary):
            return False
        return all(
            _signs_agree(straight, curved, at)
            for at in on_both_sides
            if evaluate_at(curved, at) is not None
        )
    return False


def _moved(
    point: Point, symbol: sp.Symbol, boundary: mpmath.mpf, distance: mpmath.mpf
) -> Iterator[Point]:
    """The point with a symbol at the boundary, then on both sides of it."""
    for share in (0, *SHARES):
        yield Point(point.values() | {symbol: boundary + share * distance})


STEPS = mpmath.mpf("1e-6"), mpmath.mpf("1e-7")
"""Distances from an equilibrium: what is left of second order falls by a hundred from one to the
other.
"""
STEEPEST = mpmath.mpf("0.02")
"""Share to which a residual must fall: first order leaves a tenth, second order a hundredth."""
FLATTEST = mpmath.mpf("0.05")
"""Share to which the largest term must not fall: what has no term of first order was not
linearised.
"""


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium in words, and points near it: along each direction, those at the distances of
    `STEPS`.
    """

    name: str
    directions: tuple[tuple[Point, ...], ...]
    fixed: frozenset[sp.Symbol]
    """Quantities that are data: they do not become small."""

    def describes(self, residual: Expr, is_announced: bool) -> bool:
        """Return whether a residual is that of a linearised equation, and vanishes here to first
        order.

        It must be linear in what moves, with a term that is: an equation that is not was not
        linearised, and must hold as it stands. Where small motions are announced, products may have
        been left, but no functions of what is small.
        """
        if not _is_linearised(residual, residual.free_symbols - self.fixed, is_announced):
            return False
        return all(_falls(residual, points) for points in self.directions)


def _falls(residual: Expr, points: Sequence[Point]) -> bool:
    """Whether a residual is of second order along a direction, or zero."""
    outer, inner = (evaluate_at(residual, point) for point in points)
    if outer is None or inner is None:
        return False
    largest, smaller = (largest_term(residual, point) for point in points)
    with mpmath.workdps(DIGITS + GUARD):
        is_zero = abs(outer) <= TOLERANCE * largest
        return bool(
            smaller >= FLATTEST * largest and (is_zero or abs(inner) <= STEEPEST * abs(outer))
        )


def _is_linearised(residual: Expr, moving: Collection[sp.Symbol], is_announced: bool) -> bool:
    if not moving:
        return False
    above = sp.together(residual).as_numer_denom()[0]
    if not above.is_polynomial(*moving):
        return False
    return is_announced or sp.Poly(above, *moving).total_degree() <= 1
