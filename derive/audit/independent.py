"""Edits that each explain terms of their own: found one after the other, however many a print needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..evaluate import DIGITS, TOLERANCE
from ..quantity import Quantity
from .comparison import Comparison
from .edits import Edit
from .terms import Gap, Match, monomials, shared, value

MOST = 8
"""Edits after which a print is another formula, not the same with slips."""
SIMPLE = 12
"""Largest numerator and denominator of a factor that a print may have lost, or of its square."""


@dataclass(frozen=True)
class Explained:
    """A comparison after edits of which each left fewer terms without their like."""

    comparison: Comparison
    edits: tuple[Edit, ...] = ()


def explained(start: Comparison, first: list[Edit], words: list[Quantity]) -> Explained:
    """The print after all edits that explain terms.

    What is taken away explains nothing of a print that lacks something besides: such edits count only where the two
    sides then say the same.
    """
    kept = _followed(start, [edit for edit in first if not edit.removes], words, removing=False)
    if kept.comparison.same or not kept.comparison.struck().printed:
        return kept
    shorter = _followed(kept.comparison, kept.comparison.edits(words), words, removing=True)
    if shorter.comparison.same:
        return Explained(shorter.comparison, (*kept.edits, *shorter.edits))
    return kept


def _followed(start: Comparison, first: list[Edit], words: list[Quantity], removing: bool) -> Explained:
    """Again and again the edit that leaves least, while there is one that leaves less than nothing done."""
    found, tried = Explained(start), first
    while len(found.edits) < MOST:
        scaled = _scaled(found.comparison, found.comparison.struck())
        better = _best(found.comparison, [*tried, *_grouped(found.comparison), *scaled], removing)
        if better is None:
            break
        found = Explained(found.comparison.edited(better.result), (*found.edits, better))
        if found.comparison.same:
            break
        tried = [edit for edit in found.comparison.edits(words) if removing or not edit.removes]
    return found


def _best(at: Comparison, tried: list[Edit], removing: bool) -> Edit | None:
    """The edit that leaves fewest terms without their like, fewer than before, and finds more of what is derived."""
    real = [point for point in at.points if value(at.printed, point) is not None]
    before = at.gap
    better = [(after, edit) for edit in tried if _helps(after := at.edited(edit.result).gap, before, removing)]
    for _, edit in sorted(better, key=_rank):
        if all(value(edit.result, point) is not None for point in real):
            return edit
    return None


def _rank(found: tuple[Gap, Edit]) -> tuple[int, int, int, str]:
    """What edits are preferred by: what they leave, then how few symbols they exchange."""
    after, edit = found
    return after.size, after.unmatched, len(edit.swaps), edit.what


def _helps(after: Gap, before: Gap, removing: bool) -> bool:
    if after.size >= before.size and after.unmatched >= before.unmatched:
        return False
    return after.unexplained <= before.unexplained and (removing or after.unmatched < before.unmatched)


def _grouped(at: Comparison) -> Iterator[Edit]:
    """Summands that all differ by one sign or factor from what is derived: that of a bracket around them."""
    if not isinstance(at.printed, sp.Add):
        return
    meant = monomials(at.derived, at.points)
    groups: dict[sp.Rational, list[Expr]] = {}
    for term in at.printed.args:
        ratios = {d / p if p != 0 else None for _, p, d in shared(monomials(term, at.points), meant) if p != 0}
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
                said = ("sign of ", printed) if factor == -1 else ("factor ", factor, " on ", printed)
                yield Edit(said, at.printed + (factor - 1) * printed)


def _simple_ratio(at: Comparison, above: Expr, below: Expr) -> Expr | None:
    """A number that one expression is of another at every point, if it is a simple one."""
    values = [(value(above, point), value(below, point)) for point in at.points]
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
        near = Fraction(str(mpmath.nstr(square, 20))).limit_denominator(SIMPLE**2)
        root = sp.sqrt(sp.Rational(near.numerator, near.denominator))
        exact = abs(square - mpf(near.numerator) / near.denominator) <= TOLERANCE * square
        if exact and 0 < max(sp.numer(root).evalf(), sp.denom(root).evalf()) <= SIMPLE:
            return sp.sign(int(mpmath.sign(ratio))) * root * sp.pi**power
    return None
