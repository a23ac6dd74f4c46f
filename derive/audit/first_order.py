"""Rows that were linearised: they hold to first order about an equilibrium, and are judged as
such.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..evaluate import DIGITS, GUARD, TOLERANCE, Point
from .terms import evaluate_at, largest_term

STEPS = mpf("1e-6"), mpf("1e-7")
"""Distances from an equilibrium: what is left of second order falls by a hundred from one to the
other.
"""
STEEPEST = mpf("0.02")
"""Share to which a residual must fall: first order leaves a tenth, second order a hundredth."""
FLATTEST = mpf("0.05")
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
