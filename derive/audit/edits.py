"""Small edits of an expression: what a slip of the pen, the typesetter or the scanner does to a formula."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations

import sympy as sp
from sympy import Basic, Expr, Rational, pi

from ..quantity import NONE, DimensionError, Quantity, dimension, is_consistent, of_unit
from .typesetting import Piece, Said

FACTORS = (sp.Integer(2), Rational(1, 2), pi / 180, 180 / pi)
SWAPS = {sp.sin: sp.cos, sp.cos: sp.sin}
INVERSES = (sp.atan, sp.asin, sp.acos, sp.tan, sp.sin, sp.cos)
GROUP = 6
"""Summands of a bracket of which any group may have lost its sign."""
_DOTS = re.compile(r"_(d*)dot$")


@dataclass(frozen=True)
class Edit:
    """One replacement: at one place, or of one symbol throughout.

    ``swaps`` are symbols for others, where that is the edit: what stands in print, and what should. ``removes`` says
    whether it takes something away and puts nothing in its place.
    """

    words: tuple[Piece, ...]
    result: Expr
    swaps: tuple[tuple[Quantity, Expr], ...] = ()
    removes: bool = False

    @property
    def text(self) -> Said:
        """The edit in words."""
        return Said(*self.words)


def list_edits(
    expr: Expr, vocabulary: Iterable[Quantity], overall: bool = True, present: Iterable[sp.Symbol] = ()
) -> Iterator[Edit]:
    """Every single edit of an expression, but for a factor on the whole (``overall``) where that is no error.

    Where the expression mixes dimensions a symbol may stand for one of any dimension. ``present`` are symbols that a
    bracket may lack as a summand.
    """
    consistent = is_consistent(expr)
    lacking = [s for s in present if isinstance(s, Quantity)]
    quantities = tuple(sorted(set(vocabulary), key=str))
    words = Words(quantities, tuple(sorted(lacking, key=str)), any_dimension=not consistent)
    for factor in (-1, *FACTORS) if overall else ():
        yield Edit(("factor ", sp.sympify(factor), " on the whole"), factor * expr)
    yield from _throughout(expr, words)
    yield from _at_places(expr, words, linear=True)


@dataclass(frozen=True)
class Words:
    """Quantities that may have been meant, and those that may be lacking together with others."""

    vocabulary: tuple[Quantity, ...]
    lacking: tuple[Quantity, ...]
    any_dimension: bool
    _alternatives: dict[Quantity, list[Quantity]] = field(init=False, default_factory=dict, compare=False)

    def list_replacements(self, symbol: Basic) -> list[Quantity]:
        """Return the words that may replace a symbol: equal dimension, or the same name with other dots."""
        if not isinstance(symbol, Quantity):
            return []
        if symbol not in self._alternatives:
            self._alternatives[symbol] = self._fitting(symbol)
        return self._alternatives[symbol]

    def _fitting(self, symbol: Quantity) -> list[Quantity]:
        dimensions, stem = of_unit(symbol.unit), _DOTS.sub("", symbol.name)
        fitting = (w for w in self.vocabulary if w != symbol)
        if self.any_dimension:
            return list(fitting)
        return [w for w in fitting if of_unit(w.unit) == dimensions or _DOTS.sub("", w.name) == stem]

    def list_sums_with(self, symbol: Basic) -> Iterator[tuple[Quantity, Expr]]:
        """A quantity that a symbol is or may be part of a sum with, and the sum."""
        if isinstance(symbol, Quantity):
            for other in self.lacking:
                if other != symbol and of_unit(other.unit) == of_unit(symbol.unit):
                    yield from ((other, symbol + sign * other) for sign in (1, -1))


def _throughout(expr: Expr, words: Words) -> Iterator[Edit]:
    symbols = sorted(expr.free_symbols, key=str)
    for symbol in symbols:
        if expr.count(symbol) > 1:
            for other in words.list_replacements(symbol):
                swaps = ((symbol, other),)
                yield Edit((other, " for ", symbol, " throughout"), expr.xreplace({symbol: other}), swaps)
            for _, both in words.list_sums_with(symbol) if _is_bent(expr, symbol) else ():
                swaps = ((symbol, both),)
                yield Edit((both, " for ", symbol, " throughout"), expr.xreplace({symbol: both}), swaps)
    for first, second in combinations(symbols, 2):
        if second in words.list_replacements(first):
            exchanged = expr.xreplace({first: second, second: first})
            yield Edit((first, " and ", second, " exchanged"), exchanged, ((first, second), (second, first)))


def _is_bent(expr: Basic, symbol: sp.Symbol) -> bool:
    """Whether a symbol stands in a power or a function, where a missing summand is no missing term."""
    nodes = (n for n in sp.preorder_traversal(expr) if _bends(n))
    return any(symbol in node.free_symbols for node in nodes)


def _bends(node: Basic) -> bool:
    return isinstance(node, sp.Pow | sp.Function | sp.Rel)


def _at_places(expr: Basic, words: Words, linear: bool) -> Iterator[Edit]:
    """Edits at this node, then at every place below it."""
    yield from _node_edits(expr, words, linear)
    for index, part in enumerate(expr.args):
        if isinstance(part, sp.Integer | Rational) or part in (sp.true, sp.false):
            continue
        for edit in _at_places(part, words, linear and not _bends(expr)):
            arguments = (*expr.args[:index], edit.result, *expr.args[index + 1 :])
            yield replace(edit, result=expr.func(*arguments))


def _node_edits(expr: Basic, words: Words, linear: bool) -> Iterator[Edit]:
    for other in words.list_replacements(expr):
        yield Edit((other, " for ", expr), other, ((expr, other),))
    if not linear:
        yield from (Edit((both, " for ", expr), both, ((expr, both),)) for _, both in words.list_sums_with(expr))
    if isinstance(expr, sp.Add):
        yield from _summands(expr, linear)
    if expr.func in SWAPS:
        other = SWAPS[expr.func]
        yield Edit((f"{other.__name__} for {expr.func.__name__} of ", expr.args[0]), other(*expr.args))
    if isinstance(expr, sp.Piecewise) and len(expr.args) == 2:
        (first, condition), (second, other) = expr.args
        exchanged = ("cases ", condition, " and ", other, " exchanged")
        yield Edit(exchanged, sp.Piecewise((second, condition), (first, other)))
    if isinstance(expr, Expr) and not expr.is_number and not isinstance(expr, sp.Piecewise):
        yield from _functions(expr)


def _summands(expr: sp.Add, linear: bool) -> Iterator[Edit]:
    """A term with another sign or factor, or too many; in a bracket of few terms, a group with another sign."""
    for index, term in enumerate(expr.args):
        rest = (*expr.args[:index], *expr.args[index + 1 :])
        yield Edit(("sign of ", term), sp.Add(*rest, -term))
        for factor in FACTORS:
            yield Edit(("factor ", factor, " on ", term), sp.Add(*rest, factor * term))
        yield Edit(("without ", term), sp.Add(*rest), removes=True)
    if 2 < len(expr.args) <= GROUP or (len(expr.args) == 2 and not linear):
        for size in range(2, len(expr.args) // 2 + 1 if linear else len(expr.args) + 1):
            for group in combinations(expr.args, size):
                flipped = sp.Add(*(-term if term in group else term for term in expr.args))
                yield Edit(("sign of the group ", sp.Add(*group)), flipped)


def _functions(expr: Expr) -> Iterator[Edit]:
    """A function that was left out, or one too many; a factor on its argument, or under a root."""
    if isinstance(expr, sp.Function):
        for factor in FACTORS:
            if len(expr.args) == 1:
                yield Edit(("factor ", factor, " on the argument of ", expr), expr.func(factor * expr.args[0]))
    if isinstance(expr, sp.Pow) and not expr.exp.is_Integer:
        for factor in FACTORS:
            yield Edit(("factor ", factor, " on ", expr.base), (factor * expr.base) ** expr.exp)
    if isinstance(expr, INVERSES):
        yield Edit((f"without {expr.func.__name__} of ", expr.args[0]), expr.args[0])
    elif isinstance(expr, sp.Add | sp.Mul | sp.Pow | Quantity) and _is_number(expr):
        for function in INVERSES[3:] if isinstance(expr, sp.Add | Quantity) else INVERSES[:3]:
            yield Edit((f"{function.__name__} of ", expr), function(expr))
        if isinstance(expr, sp.Add):
            yield Edit(("atan of ", expr), sp.atan(expr))


def _is_number(expr: Expr) -> bool:
    try:
        return dimension(expr) == NONE
    except DimensionError:
        return False
