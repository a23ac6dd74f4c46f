"""The whole difference of two sides, if it is a term or two: told by values, however differently both are written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations

import mpmath
from mpmath import mpf
from sympy import Expr

from ..dimensions import of_unit
from ..evaluate import DIGITS, GUARD, TOLERANCE
from ..quantity import Quantity
from .comparison import Comparison
from .terms import largest_term, monomials, value

MOST = 150
"""Derived terms of which pairs are tried."""


def lacking(at: Comparison, words: Iterable[Quantity]) -> tuple[Expr, ...]:
    """One or two derived terms, or a quantity, that the print lacks and nothing else; none if it is not so."""
    if any(value(at.printed, point) is None for point in at.points):
        return ()
    for side in (at, at.scaled(-1)) if at.scales else (at,):
        found = _terms(side, [*words])
        if found:
            return found if side is at else tuple(-term for term in found)
    return ()


def _terms(at: Comparison, words: list[Quantity]) -> tuple[Expr, ...]:
    with mpmath.workdps(DIGITS + GUARD):
        gaps = [point(at.derived) - point(at.printed) for point in at.points]
    sizes = [TOLERANCE * largest_term(at.derived, point) for point in at.points]
    return next((some for some in _candidates(at, words) if _is(at, some, gaps, sizes)), ())


def _candidates(at: Comparison, words: list[Quantity]) -> Iterator[tuple[Expr, ...]]:
    """Terms of the derivation one by one and in pairs, then quantities of what the print defines."""
    terms = [coefficient * monomial for monomial, coefficient in monomials(at.derived, at.points).values()]
    yield from ((term,) for term in terms)
    if len(terms) <= MOST:
        yield from combinations(terms, 2)
    if not at.scales:
        units = {of_unit(s.unit) for s in at.printed.free_symbols if isinstance(s, Quantity)}
        fitting = [word for word in words if of_unit(word.unit) in units]
        yield from ((sign * word,) for word in fitting for sign in (1, -1))


def _is(at: Comparison, terms: tuple[Expr, ...], gaps: list[mpf], sizes: list[mpf]) -> bool:
    """Whether terms add up to a gap at every point."""
    with mpmath.workdps(DIGITS + GUARD):
        return all(
            abs(gap - mpmath.fsum(point(term) for term in terms)) <= size
            for point, gap, size in zip(at.points, gaps, sizes, strict=True)
        )
