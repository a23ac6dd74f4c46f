"""A printed and a derived equation in the same form: their edits, their missing terms, independent
errors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..equations import Equation, Relation
from ..evaluate import DIGITS, GUARD, TOLERANCE, Point
from ..quantity import Quantity, of_unit
from .edits import SCREEN, Edit, EditProposal, propose_edits, screen_edits
from .terms import (
    Match,
    Points,
    common_factor,
    evaluate_at,
    have_same_truth,
    largest_term,
    match_sums,
    overall_factor,
    pair_monomials,
    to_monomials,
)

FLIPPED: dict[Relation, Relation] = {"=": "=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}


@dataclass(frozen=True)
class Comparison:
    """A printed and a derived residual on the same footing: same sign of what both solve for, same
    points.

    ``scales`` says whether a constant factor on the whole says nothing: it does where
    ``residual = 0`` defines no symbol, for that has the same solutions as any multiple of it, and
    where it does, the factor is what is printed. ``turns`` says whether a whole turn says nothing:
    it does where the symbol is a direction. ``bounds`` says whether the residuals are those of a
    condition, of which the signs are all that is said.
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
        return all(self.is_equal_at(point) for point in self.points)

    def is_equal_at(self, point: Point) -> bool:
        """Return whether both sides have equal values at a point; a printed side without a value is
        unequal.
        """
        printed_value, derived_value = evaluate_at(self.printed, point), point(self.derived)
        if printed_value is None:
            return False
        with mpmath.workdps(DIGITS + GUARD):
            gap = printed_value - derived_value
            if self.turns:
                gap -= 2 * mpmath.pi * mpmath.nint(gap / (2 * mpmath.pi))
            return bool(
                abs(gap) <= TOLERANCE * max(largest_term(self.derived, point), abs(printed_value))
            )

    @property
    def proportional(self) -> bool:
        """Whether one is a constant multiple of the other, of the same sign, though neither is zero
        at any point.
        """
        first: mpf | None = None
        with mpmath.workdps(DIGITS + GUARD):
            for point in self.points:
                printed_value, derived_value = evaluate_at(self.printed, point), point(self.derived)
                if (
                    printed_value is None
                    or abs(derived_value) <= TOLERANCE * largest_term(self.derived, point)
                    or printed_value / derived_value <= 0
                ):
                    return False
                first = first or printed_value / derived_value
                if abs(printed_value / derived_value - first) > TOLERANCE * first:
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
        """Return the number of printed terms that are not derived, and of derived terms that are
        not printed.
        """
        if self.same:
            return 0, 0
        left = self.match()
        return 1 + len(left.printed), len(left.derived)

    def struck(self) -> Match:
        """Return the terms left on both sides once equal terms are removed."""
        return match_sums(
            to_monomials(self.printed, self.points), to_monomials(self.derived, self.points)
        )

    def match(self) -> Match:
        """Return the terms left on both sides, or none if they vanish in total."""
        match = self.struck()
        return Match((), ()) if match.vanishes(self.points) else match

    def edited(self, result: Expr) -> Comparison:
        """Return a copy whose printed side is ``result``."""
        return replace(self, printed=result)

    def scaled(self, factor: Expr) -> Comparison:
        """Return a copy whose derived side is multiplied by ``factor``."""
        return replace(self, derived=factor * self.derived)

    def edits(self, words: list[Quantity]) -> list[Edit]:
        """Return the edits of the printed side with symbols among ``words``."""
        return [proposal.apply(self.printed) for proposal in self._propose(words)]

    def repairs(self, words: list[Quantity]) -> list[Edit]:
        """Return the edits of the printed side, with symbols among ``words``, after which both
        sides say the same.
        """
        edits = (proposal.apply(self.printed) for proposal in self._screen(self._propose(words)))
        return [edit for edit in edits if self._is_repair(edit)]

    def _propose(self, words: list[Quantity]) -> Iterator[EditProposal]:
        present = sorted(self.derived.free_symbols, key=str)
        return propose_edits(self.printed, words, overall=not self.scales, present=present)

    def _is_repair(self, edit: Edit) -> bool:
        try:
            return self.edited(edit.result).same
        except (ZeroDivisionError, ValueError):
            return False

    def _screen(self, proposals: Iterator[EditProposal]) -> Iterator[EditProposal]:
        """Return the edits after which both sides may say the same, as floating point tells; all
        of a condition.
        """
        if self.bounds:
            return proposals
        derived = np.array([float(point(self.derived)) for point in self.points])
        terms = np.array([float(largest_term(self.derived, point)) for point in self.points])

        def may_be_same(values: Any, sizes: Any) -> bool:
            gap, ratio = values - derived, values / derived
            if self.turns:
                gap -= 2 * np.pi * np.round(gap / (2 * np.pi))
            is_equal = np.all(np.abs(gap) <= SCREEN * np.maximum(sizes, terms))
            rounding = SCREEN * sizes / np.abs(derived)
            is_multiple = np.all(np.abs(ratio - ratio[0]) <= np.maximum(rounding, rounding[0]))
            return bool(is_equal or (self.scales and is_multiple))

        return screen_edits(self.printed, proposals, self.points, may_be_same)


def list_orientations(printed: Equation) -> list[Equation]:
    """A printed equation; of a condition also the same with its sides exchanged."""
    if printed.relation == "=":
        return [printed]
    return [
        printed,
        replace(printed, residual=-printed.residual, relation=FLIPPED[printed.relation]),
    ]


def align_sides(
    printed: Equation, derived: Equation, points: Points, is_direction: bool = False
) -> Comparison:
    """Both sides on one footing: what they define a symbol as, else residuals with the factor that
    leaves less.
    """
    best = min(_footings(printed, derived, points, is_direction), key=lambda c: c.distance)
    if best.same or not best.scales:
        return best
    factor = overall_factor(to_monomials(best.printed, points), to_monomials(best.derived, points))
    return min(best, best.scaled(abs(factor)), key=lambda c: c.distance)


def are_equivalent(
    printed: Equation, derived: Equation, points: Points, is_direction: bool = False
) -> bool:
    """Whether both say the same at all points: equations, or conditions of which either side may
    stand first.
    """
    return any(
        comparison.same
        for side in list_orientations(printed)
        if side.relation == derived.relation
        for comparison in _footings(side, derived, points, is_direction)
    )


def _footings(
    printed: Equation, derived: Equation, points: Points, is_direction: bool
) -> list[Comparison]:
    """Both sides by what they define a symbol as, else as residuals with either sign and a lost
    factor put back.
    """
    symbol = printed.defines
    if symbol is not None and derived.defines == symbol:
        printed_side, derived_side = (
            solve_for(side.residual, symbol) for side in (printed, derived)
        )
        return [Comparison(printed_side, derived_side, points, turns=is_direction)]
    residuals = [printed.residual, *(_undivided(printed, derived) if symbol is None else ())]
    bounds = printed.relation != "="
    starts = [
        Comparison(residual, derived.residual, points, scales=symbol is None, bounds=bounds)
        for residual in residuals
    ]
    return [start.scaled(sign) for start in starts for sign in ((1,) if bounds else (1, -1))]


def solve_for(residual: Expr, symbol: Quantity | None) -> Expr:
    """Return the expression that an equation gives for a symbol, whether or not both sides have a
    common factor; the residual for none.
    """
    if symbol is None:
        return residual
    slope = residual.diff(symbol)
    plain = not slope.is_number or slope in (0, 1)
    return symbol - (residual if plain else sp.expand_mul(residual / slope))


def _undivided(printed: Equation, derived: Equation) -> tuple[Expr, ...]:
    """A homogeneous equation with the factor put back by which the print may have divided it, if
    any.
    """
    if printed.relation != "=" or printed.residual == 0:
        return ()
    factor = common_factor(derived.residual) / common_factor(printed.residual)
    powers = factor.as_powers_dict()
    if factor.is_number or not all(
        power.is_number and power > 0 for base, power in powers.items() if base != 1
    ):
        return ()
    return (sp.expand(factor * printed.residual, trig=False),)


def align_derived(printed: Equation, derived: Equation, points: Points) -> Equation:
    """The derived equation with the sign that leaves less against the printed one."""
    if printed.legibility == "lost" or derived.relation != "=" or derived.defines is not None:
        return derived
    return replace(derived, residual=align_sides(printed, derived, points).derived)


MOST_TERMS = 150
"""Derived terms of which pairs are tried."""


def find_missing_terms(at: Comparison, words: Iterable[Quantity]) -> tuple[Expr, ...]:
    """One summand or two terms of the derivation, or a quantity, that the print lacks and nothing
    else; else none.
    """
    if any(evaluate_at(at.printed, point) is None for point in at.points):
        return ()
    sides = (
        (at, at.scaled(-1)) if at.scales else (at,)
    )  # of either sign: the terms have the sign of the print
    return next((terms for side in sides if (terms := _terms(side, [*words]))), ())


def _terms(at: Comparison, words: list[Quantity]) -> tuple[Expr, ...]:
    with mpmath.workdps(DIGITS + GUARD):
        gaps = [point(at.derived) - point(at.printed) for point in at.points]
    sizes = [TOLERANCE * largest_term(at.derived, point) for point in at.points]
    return next((some for some in _candidates(at, words) if _is(at, some, gaps, sizes)), ())


def _candidates(at: Comparison, words: list[Quantity]) -> Iterator[tuple[Expr, ...]]:
    """Terms of the derivation one by one, as its summands, and in pairs, then quantities of what
    the print defines.
    """
    terms = [
        coefficient * monomial
        for monomial, coefficient in to_monomials(at.derived, at.points).values()
    ]
    yield from ((term,) for term in dict.fromkeys((*terms, *sp.Add.make_args(at.derived))))
    if len(terms) <= MOST_TERMS:
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


MOST_EDITS = 8
"""Edits after which a print is another formula, not the same with slips."""
SIMPLE = 12
"""Largest numerator and denominator of a factor that a print may have lost, or of its square."""


Explained = tuple[Comparison, tuple[Edit, ...]]
"""A comparison after edits of which each left fewer terms without their like."""


def explain_by_edits(start: Comparison, first: list[Edit], words: list[Quantity]) -> Explained:
    """The print after all edits that explain terms.

    What is taken away explains nothing of a print that lacks something besides: such edits count
    only where the two sides then say the same.
    """
    replacements = [edit for edit in first if not edit.removes]
    changed, edits = _followed(start, replacements, words, removing=False)
    if changed.same or not changed.struck().printed:
        return changed, edits
    shorter, further = _followed(changed, changed.edits(words), words, removing=True)
    return (shorter, (*edits, *further)) if shorter.same else (changed, edits)


def _followed(
    start: Comparison, first: list[Edit], words: list[Quantity], removing: bool
) -> Explained:
    """Again and again the edit that leaves least, while there is one that leaves less than nothing
    done.
    """
    current, edits, candidates = start, list[Edit](), first
    while len(edits) < MOST_EDITS:
        scaled = _scaled(current, current.struck())
        better = _best(current, [*candidates, *_grouped(current), *scaled], removing)
        if better is None:
            break
        current = current.edited(better.result)
        edits.append(better)
        if current.same:
            break
        candidates = [edit for edit in current.edits(words) if removing or not edit.removes]
    return current, tuple(edits)


def _best(at: Comparison, candidates: list[Edit], removing: bool) -> Edit | None:
    """The edit that leaves fewest terms without their like, fewer than before, and finds more of
    what is derived.
    """
    real = [point for point in at.points if evaluate_at(at.printed, point) is not None]
    before = at.struck()
    ranked: list[tuple[int, int, int, str, Edit]] = []
    for edit in candidates:
        after = at.edited(edit.result).struck()
        if _helps(after, before, removing):
            ranked.append((after.size, after.unmatched, len(edit.swaps), edit.text, edit))
    for *_, edit in sorted(ranked, key=lambda entry: entry[:4]):
        if all(evaluate_at(edit.result, point) is not None for point in real):
            return edit
    return None


def _helps(after: Match, before: Match, removing: bool) -> bool:
    if after.size >= before.size and after.unmatched >= before.unmatched:
        return False
    return len(after.printed) <= len(before.printed) and (
        removing or after.unmatched < before.unmatched
    )


def _grouped(at: Comparison) -> Iterator[Edit]:
    """Summands that all differ by one sign or factor from what is derived: that of a bracket around
    them.
    """
    if not isinstance(at.printed, sp.Add):
        return
    derived_sum = to_monomials(at.derived, at.points)
    groups: dict[sp.Rational, list[Expr]] = {}
    for term in at.printed.args:
        ratios = {
            d / p if p != 0 else None
            for _, p, d in pair_monomials(to_monomials(term, at.points), derived_sum)
            if p != 0
        }
        if len(ratios) == 1 and (ratio := ratios.pop()) not in (None, 0, 1):
            groups.setdefault(ratio, []).append(term)
    for ratio, group in groups.items():
        if len(group) > 1:
            changed = sp.Add(*(ratio * term if term in group else term for term in at.printed.args))
            name = "sign of the group" if ratio == -1 else f"factor {ratio} on the group"
            yield Edit((f"{name} ", sp.Add(*group)), changed)


def _scaled(at: Comparison, left: Match) -> Iterator[Edit]:
    """A printed term that is a derived one but for a simple factor, a root or pi among them."""
    for printed in left.printed:
        for derived in left.derived:
            factor = _simple_ratio(at, derived, printed)
            if factor is not None and factor != 1:
                words = (
                    ("sign of ", printed) if factor == -1 else ("factor ", factor, " on ", printed)
                )
                yield Edit(words, at.printed + (factor - 1) * printed)


def _simple_ratio(at: Comparison, above: Expr, below: Expr) -> Expr | None:
    """A number that one expression is of another at every point, if it is a simple one."""
    values = [(evaluate_at(above, point), evaluate_at(below, point)) for point in at.points]
    with mpmath.workdps(DIGITS):
        if any(a is None or not b for a, b in values):
            return None
        ratios = [a / b for a, b in values if a is not None]
        if any(abs(ratio - ratios[0]) > TOLERANCE * abs(ratio) for ratio in ratios):
            return None
        return _simple(ratios[0])


def _simple(ratio: mpf) -> Expr | None:
    """A number as a fraction of small whole numbers, or the root of one, times pi or not."""
    for power in (0, 1, -1):
        square = (ratio / mpmath.pi**power) ** 2
        fraction = Fraction(str(mpmath.nstr(square, 20))).limit_denominator(SIMPLE**2)
        root = sp.sqrt(sp.Rational(fraction.numerator, fraction.denominator))
        exact = abs(square - mpf(fraction.numerator) / fraction.denominator) <= TOLERANCE * square
        if exact and 0 < max(sp.numer(root).evalf(), sp.denom(root).evalf()) <= SIMPLE:
            return sp.sign(int(mpmath.sign(ratio))) * root * sp.pi**power
    return None
