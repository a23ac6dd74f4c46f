"""Equations that are claimed to be nothing in particular: they hold of the subject's own values, or they do not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import mpmath
import sympy as sp
from sympy import Expr

from ..dimensions import is_consistent
from ..equations import Equation
from ..evaluate import TOLERANCE, Point
from ..quantity import Quantity
from .comparison import solved
from .edits import Edit, edits
from .judgement import Judgement
from .terms import Points, largest_term, value
from .wording import Said


def held(printed: Equation, points: Points, words: Iterable[Quantity]) -> Judgement:
    """The verdict on an equation by values alone: whether it holds at every point, or which single edits make it."""
    lacking = sorted(str(s) for s in printed.residual.free_symbols if any(s not in point for point in points))
    if lacking or printed.relation != "=":
        reason = f"{', '.join(lacking)} has no value here" if lacking else "a condition without a claim"
        return Judgement("untested", f"{reason}, so that nothing tests it")
    if holds(printed.residual, points):
        return Judgement("confirmed", "it holds at every point that was tried")
    remark = "" if is_consistent(printed.residual) else "not dimensionally consistent; "
    found = [edit for edit, residual in _edited(printed, words, points) if holds(residual, points)]
    if found:
        texts = tuple(dict.fromkeys((edit.what,) for edit in found))
        return Judgement("misprint", f"{remark}removed by 1 edit(s)", texts, edits=(found[0],))
    return Judgement("contradicted", Said(f"{remark}{_failing(printed.residual, points)}"))


def _edited(printed: Equation, words: Iterable[Quantity], points: Points) -> Iterator[tuple[Edit, Expr]]:
    """Every edit with the residual that it leaves, but for those that leave nothing to say."""
    known = [word for word in words if all(word in point for point in points)]
    symbol = printed.defines
    said = printed.residual if symbol is None else solved(printed, symbol)
    for edit in edits(said, known, whole=symbol is not None):
        residual = edit.result if symbol is None else symbol - edit.result
        if len(sp.Add.make_args(residual)) > 1:
            yield edit, residual


def holds(residual: Expr, points: Points) -> bool:
    """Whether a residual vanishes at every point."""
    return all(_vanishes(residual, point) for point in points)


def _vanishes(residual: Expr, point: Point) -> bool:
    found = value(residual, point)
    return found is not None and abs(found) <= TOLERANCE * largest_term(residual, point)


def _failing(residual: Expr, points: Points) -> str:
    """What is left at the first point where the equation does not hold, beside its largest term."""
    where = next(point for point in points if not _vanishes(residual, point))
    left = value(residual, where)
    told = "no real value" if left is None else mpmath.nstr(left, 6)
    return f"it does not hold: {told} is left of terms of up to {mpmath.nstr(largest_term(residual, where), 6)}"
