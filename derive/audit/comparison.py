"""A printed and a derived equation on the same footing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..equations import Equation, Relation
from ..evaluate import DIGITS, GUARD, TOLERANCE, Point
from ..quantity import Quantity
from .bounds import have_same_truth
from .edits import Edit, edits
from .terms import (
    Gap,
    Match,
    Points,
    content,
    gap,
    largest_term,
    matched,
    monomials,
    overall_factor,
    remainder_vanishes,
    value,
)

FLIPPED: dict[Relation, Relation] = {"=": "=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}


@dataclass(frozen=True)
class Comparison:
    """A printed and a derived residual on the same footing: same sign of what both solve for, same points.

    ``scales`` says whether a constant factor on the whole says nothing: it does where ``residual = 0`` defines no
    symbol, for that has the same solutions as any multiple of it, and where it does, the factor is what is printed.
    ``turns`` says whether a whole turn says nothing: it does where the symbol is a direction. ``bounds`` says whether
    the residuals are those of a condition, of which the signs are all that is said.
    """

    printed: Expr
    derived: Expr
    points: Points
    scales: bool = False
    turns: bool = False
    bounds: bool = False

    @property
    def equal(self) -> bool:
        """Whether both have the same value at every point, to 50 digits of the largest term."""
        return all(self.equal_at(point) for point in self.points)

    def equal_at(self, point: Point) -> bool:
        given, meant = value(self.printed, point), point(self.derived)
        if given is None:
            return False
        with mpmath.workdps(DIGITS + GUARD):
            gap = given - meant
            if self.turns:
                gap -= 2 * mpmath.pi * mpmath.nint(gap / (2 * mpmath.pi))
            return bool(abs(gap) <= TOLERANCE * max(largest_term(self.derived, point), abs(given)))

    @property
    def proportional(self) -> bool:
        """Whether one is a constant multiple of the other, of the same sign, though neither is zero at any point."""
        first: mpf | None = None
        with mpmath.workdps(DIGITS + GUARD):
            for point in self.points:
                given, meant = value(self.printed, point), point(self.derived)
                if given is None or abs(meant) <= TOLERANCE * largest_term(self.derived, point) or given / meant <= 0:
                    return False
                first = first or given / meant
                if abs(given / meant - first) > TOLERANCE * first:
                    return False
        return True

    @property
    def same(self) -> bool:
        """Whether both say the same."""
        if self.equal or (self.scales and self.proportional):
            return True
        return self.bounds and have_same_truth(self.printed, self.derived, self.points)

    @property
    def distance(self) -> tuple[int, int]:
        """How far apart they are: by the printed terms that are not derived, then by those that are not printed."""
        if self.same:
            return 0, 0
        left = self.match()
        return 1 + len(left.printed), len(left.derived)

    def struck(self) -> Match:
        """What is left when equal terms are struck out."""
        return matched(monomials(self.printed, self.points), monomials(self.derived, self.points))

    @property
    def gap(self) -> Gap:
        """How many terms have no like."""
        return gap(monomials(self.printed, self.points), monomials(self.derived, self.points))

    def match(self) -> Match:
        """What is left, nothing if it vanishes as a whole."""
        found = self.struck()
        return Match((), ()) if remainder_vanishes(found, self.points) else found

    def edited(self, result: Expr) -> Comparison:
        return replace(self, printed=result)

    def scaled(self, factor: Expr) -> Comparison:
        return replace(self, derived=factor * self.derived)

    def edits(self, words: list[Quantity]) -> list[Edit]:
        present = sorted(self.derived.free_symbols, key=str)
        return list(edits(self.printed, words, whole=not self.scales, present=present))


def list_orientations(printed: Equation) -> list[Equation]:
    """A printed equation; of a condition also the same with its sides exchanged."""
    if printed.relation == "=":
        return [printed]
    return [printed, replace(printed, residual=-printed.residual, relation=FLIPPED[printed.relation])]


def aligned(printed: Equation, derived: Equation, points: Points, is_direction: bool = False) -> Comparison:
    """Both sides on one footing: what they define a symbol as, else residuals with the factor that leaves less."""
    best = min(_footings(printed, derived, points, is_direction), key=lambda c: c.distance)
    if best.same or not best.scales:
        return best
    factor = overall_factor(monomials(best.printed, points), monomials(best.derived, points))
    return min(best, best.scaled(abs(factor)), key=lambda c: c.distance)


def say_the_same(printed: Equation, derived: Equation, points: Points, is_direction: bool = False) -> bool:
    """Whether both say the same at all points: equations, or conditions of which either side may stand first."""
    return any(
        comparison.same
        for side in list_orientations(printed)
        if side.relation == derived.relation
        for comparison in _footings(side, derived, points, is_direction)
    )


def _footings(printed: Equation, derived: Equation, points: Points, is_direction: bool) -> list[Comparison]:
    """Both sides by what they define a symbol as, else as residuals with either sign and a lost factor put back."""
    symbol = printed.defines
    if symbol is not None and derived.defines == symbol:
        said, meant = (solved(side, symbol) for side in (printed, derived))
        return [Comparison(said, meant, points, turns=is_direction)]
    wholes = [printed.residual, *(_undivided(printed, derived) if symbol is None else ())]
    bounds = printed.relation != "="
    starts = [Comparison(whole, derived.residual, points, scales=symbol is None, bounds=bounds) for whole in wholes]
    return [start.scaled(sign) for start in starts for sign in ((1,) if bounds else (1, -1))]


def solved(side: Equation, symbol: Quantity) -> Expr:
    """What an equation says that a symbol is, both sides with the same number on them or not."""
    slope = side.residual.diff(symbol)
    plain = not slope.is_number or slope in (0, 1)
    return symbol - (side.residual if plain else sp.expand_mul(side.residual / slope))


def _undivided(printed: Equation, derived: Equation) -> tuple[Expr, ...]:
    """A homogeneous equation with the factor put back by which the print may have divided it, if any."""
    if printed.relation != "=" or printed.residual == 0:
        return ()
    factor = content(derived.residual) / content(printed.residual)
    powers = factor.as_powers_dict()
    if factor.is_number or not all(power.is_number and power > 0 for base, power in powers.items() if base != 1):
        return ()
    return (sp.expand(factor * printed.residual, trig=False),)


def facing(printed: Equation, derived: Equation, points: Points) -> Equation:
    """The derived equation with the sign that leaves less against the printed one."""
    if printed.legibility == "lost" or derived.relation != "=" or derived.defines is not None:
        return derived
    return replace(derived, residual=aligned(printed, derived, points).derived)
