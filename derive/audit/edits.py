"""Small edits of an expression: what a slip of the pen, the typesetter or the scanner does to a formula."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations

import sympy as sp
from sympy import Basic, Expr, Rational, pi

from ..dimensions import NONE, DimensionError, dimension, of_unit
from ..quantity import Quantity
from .wording import Said

FACTORS = (sp.Integer(2), Rational(1, 2), pi / 180, 180 / pi)
SWAPS = {sp.sin: sp.cos, sp.cos: sp.sin}
INVERSES = (sp.atan, sp.asin, sp.acos, sp.tan, sp.sin, sp.cos)
_DOTS = re.compile(r"_(d*)dot$")


@dataclass(frozen=True)
class Edit:
    """One replacement: at one place, or of one symbol throughout."""

    what: Said
    result: Expr


def edits(expr: Expr, vocabulary: Iterable[Quantity], whole: bool = True) -> Iterator[Edit]:
    """Every single edit of an expression, but for a factor on the ``whole`` where that is no error.

    Where the expression mixes dimensions a symbol may stand for one of any dimension.
    """
    words = Words(tuple(sorted(set(vocabulary), key=str)), any_dimension=not _is_consistent(expr))
    for factor in (-1, *FACTORS) if whole else ():
        yield Edit(Said("factor ", factor, " on the whole"), factor * expr)
    yield from _throughout(expr, words)
    yield from _at_places(expr, words)


@dataclass(frozen=True)
class Words:
    """Quantities that may have been meant."""

    known: tuple[Quantity, ...]
    any_dimension: bool

    def instead_of(self, symbol: Basic) -> list[Quantity]:
        """Those of the same dimension, or the same with another number of dots."""
        if not isinstance(symbol, Quantity):
            return []
        dimensions, stem = of_unit(symbol.unit), _DOTS.sub("", symbol.name)
        fitting = (w for w in self.known if w != symbol)
        if self.any_dimension:
            return list(fitting)
        return [w for w in fitting if of_unit(w.unit) == dimensions or _DOTS.sub("", w.name) == stem]


def _throughout(expr: Expr, words: Words) -> Iterator[Edit]:
    symbols = sorted(expr.free_symbols, key=str)
    for symbol in symbols:
        if expr.count(symbol) > 1:
            for other in words.instead_of(symbol):
                yield Edit(Said(other, " for ", symbol, " throughout"), expr.xreplace({symbol: other}))
    for one, two in combinations(symbols, 2):
        if two in words.instead_of(one):
            yield Edit(Said(one, " and ", two, " exchanged"), expr.xreplace({one: two, two: one}))


def _at_places(expr: Basic, words: Words) -> Iterator[Edit]:
    """Edits at this node, then at every place below it."""
    yield from _here(expr, words)
    for index, part in enumerate(expr.args):
        if isinstance(part, sp.Integer | Rational) or part in (sp.true, sp.false):
            continue
        for edit in _at_places(part, words):
            arguments = (*expr.args[:index], edit.result, *expr.args[index + 1 :])
            yield Edit(edit.what, expr.func(*arguments))


def _here(expr: Basic, words: Words) -> Iterator[Edit]:
    for other in words.instead_of(expr):
        yield Edit(Said(other, " for ", expr), other)
    if isinstance(expr, sp.Add):
        for index, term in enumerate(expr.args):
            rest = (*expr.args[:index], *expr.args[index + 1 :])
            yield Edit(Said("sign of ", term), sp.Add(*rest, -term))
            for factor in FACTORS:
                yield Edit(Said("factor ", factor, " on ", term), sp.Add(*rest, factor * term))
    if expr.func in SWAPS:
        other = SWAPS[expr.func]
        yield Edit(Said(f"{other.__name__} for {expr.func.__name__} of ", expr.args[0]), other(*expr.args))
    if isinstance(expr, sp.Piecewise) and len(expr.args) == 2:
        (first, condition), (second, other) = expr.args
        yield Edit(Said("conditions of the two cases exchanged"), sp.Piecewise((second, condition), (first, other)))
    if isinstance(expr, Expr) and not expr.is_number and not isinstance(expr, sp.Piecewise):
        yield from _functions(expr)


def _functions(expr: Expr) -> Iterator[Edit]:
    """A function that was left out, or one too many; a factor on its argument."""
    if isinstance(expr, sp.Function):
        for factor in FACTORS:
            if len(expr.args) == 1:
                yield Edit(Said("factor ", factor, " on the argument of ", expr), expr.func(factor * expr.args[0]))
    if isinstance(expr, INVERSES):
        yield Edit(Said(f"without {expr.func.__name__} of ", expr.args[0]), expr.args[0])
    elif isinstance(expr, sp.Mul | sp.Pow) and _is_number(expr):
        for function in INVERSES[:3]:
            yield Edit(Said(f"{function.__name__} of ", expr), function(expr))


def _is_number(expr: Expr) -> bool:
    try:
        return dimension(expr) == NONE
    except DimensionError:
        return False


def _is_consistent(expr: Expr) -> bool:
    try:
        dimension(expr)
    except DimensionError:
        return False
    return True
