"""Small edits of an expression: what a slip of the pen, the typesetter or the scanner does to a
formula.
"""

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

    ``swaps`` are symbols for others, where that is the edit: what stands in print, and what should.
    ``removes`` says whether it takes something away and puts nothing in its place.
    """

    words: tuple[Piece, ...]
    result: Expr
    swaps: tuple[tuple[Quantity, Expr], ...] = ()
    removes: bool = False

    @property
    def text(self) -> Said:
        """The edit in words."""
        return Said(*self.words)


@dataclass(frozen=True)
class EditProposal:
    """An edit that is not carried out yet: what the part at a place becomes.

    ``path`` are the indices of arguments from the whole down to the part. Where ``part`` is None,
    ``swaps`` are made throughout.
    """

    words: tuple[Piece, ...]
    part: Basic | None
    swaps: tuple[tuple[Quantity, Expr], ...] = ()
    removes: bool = False
    path: tuple[int, ...] = ()

    def apply(self, expr: Expr) -> Edit:
        """Return the edit of a whole expression."""
        result = (
            expr.xreplace(dict(self.swaps))
            if self.part is None
            else _replace_part(expr, self.path, self.part)
        )
        return Edit(self.words, result, self.swaps, self.removes)


def _replace_part(expr: Basic, path: tuple[int, ...], part: Basic) -> Expr:
    if not path:
        return part
    index, *rest = path
    changed = _replace_part(expr.args[index], tuple(rest), part)
    return expr.func(*expr.args[:index], changed, *expr.args[index + 1 :])


def list_edits(
    expr: Expr,
    vocabulary: Iterable[Quantity],
    overall: bool = True,
    present: Iterable[sp.Symbol] = (),
) -> Iterator[Edit]:
    """Every single edit of an expression: see `propose_edits`."""
    return (proposal.apply(expr) for proposal in propose_edits(expr, vocabulary, overall, present))


def propose_edits(
    expr: Expr,
    vocabulary: Iterable[Quantity],
    overall: bool = True,
    present: Iterable[sp.Symbol] = (),
) -> Iterator[EditProposal]:
    """Propose every single edit of an expression, but for a factor on the whole (``overall``) where
    that is no error.

    Where the expression mixes dimensions a symbol may stand for one of any dimension. ``present``
    are symbols that a bracket may lack as a summand.
    """
    consistent = is_consistent(expr)
    lacking = [s for s in present if isinstance(s, Quantity)]
    quantities = tuple(sorted(set(vocabulary), key=str))
    words = Words(quantities, tuple(sorted(lacking, key=str)), any_dimension=not consistent)
    for factor in (-1, *FACTORS) if overall else ():
        yield EditProposal(("factor ", sp.sympify(factor), " on the whole"), factor * expr)
    yield from _throughout(expr, words)
    yield from _at_places(expr, words, (), linear=True)


@dataclass(frozen=True)
class Words:
    """Quantities that may have been meant, and those that may be lacking together with others."""

    vocabulary: tuple[Quantity, ...]
    lacking: tuple[Quantity, ...]
    any_dimension: bool
    _alternatives: dict[Quantity, list[Quantity]] = field(
        init=False, default_factory=dict, compare=False
    )

    def list_replacements(self, symbol: Basic) -> list[Quantity]:
        """Return the words that may replace a symbol: equal dimension, or the same name with other
        dots.
        """
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
        return [
            w for w in fitting if of_unit(w.unit) == dimensions or _DOTS.sub("", w.name) == stem
        ]

    def list_sums_with(self, symbol: Basic) -> Iterator[tuple[Quantity, Expr]]:
        """A quantity that a symbol is or may be part of a sum with, and the sum."""
        if isinstance(symbol, Quantity):
            for other in self.lacking:
                if other != symbol and of_unit(other.unit) == of_unit(symbol.unit):
                    yield from ((other, symbol + sign * other) for sign in (1, -1))


def _throughout(expr: Expr, words: Words) -> Iterator[EditProposal]:
    symbols = sorted(expr.free_symbols, key=str)
    for symbol in symbols:
        if expr.count(symbol) > 1:
            for other in words.list_replacements(symbol):
                yield EditProposal(
                    (other, " for ", symbol, " throughout"), None, ((symbol, other),)
                )
            for _, both in words.list_sums_with(symbol) if _is_bent(expr, symbol) else ():
                yield EditProposal((both, " for ", symbol, " throughout"), None, ((symbol, both),))
    for first, second in combinations(symbols, 2):
        if second in words.list_replacements(first):
            yield EditProposal(
                (first, " and ", second, " exchanged"), None, ((first, second), (second, first))
            )


def _is_bent(expr: Basic, symbol: sp.Symbol) -> bool:
    """Whether a symbol stands in a power or a function, where a missing summand is no missing
    term.
    """
    nodes = (n for n in sp.preorder_traversal(expr) if _bends(n))
    return any(symbol in node.free_symbols for node in nodes)


def _bends(node: Basic) -> bool:
    return isinstance(node, sp.Pow | sp.Function | sp.Rel)


def _at_places(
    expr: Basic, words: Words, path: tuple[int, ...], linear: bool
) -> Iterator[EditProposal]:
    """Edits at this node, then at every place below it."""
    for proposal in _node_edits(expr, words, linear):
        yield replace(proposal, path=(*path, *proposal.path))
    for index, part in enumerate(expr.args):
        if not isinstance(part, sp.Integer | Rational) and part not in (sp.true, sp.false):
            yield from _at_places(part, words, (*path, index), linear and not _bends(expr))


def _node_edits(expr: Basic, words: Words, linear: bool) -> Iterator[EditProposal]:
    for other in words.list_replacements(expr):
        yield EditProposal((other, " for ", expr), other, ((expr, other),))
    if not linear:
        yield from (
            EditProposal((both, " for ", expr), both, ((expr, both),))
            for _, both in words.list_sums_with(expr)
        )
    if isinstance(expr, sp.Add):
        yield from _summands(expr, linear)
    if expr.func in SWAPS:
        other = SWAPS[expr.func]
        yield EditProposal(
            (f"{other.__name__} for {expr.func.__name__} of ", expr.args[0]), other(*expr.args)
        )
    if isinstance(expr, sp.Piecewise) and len(expr.args) == 2:
        (first, condition), (second, other) = expr.args
        exchanged = ("cases ", condition, " and ", other, " exchanged")
        yield EditProposal(exchanged, sp.Piecewise((second, condition), (first, other)))
    if isinstance(expr, Expr) and not expr.is_number and not isinstance(expr, sp.Piecewise):
        yield from _functions(expr)


def _summands(expr: sp.Add, linear: bool) -> Iterator[EditProposal]:
    """A term with another sign or factor, or too many; in a bracket of few terms, a group with
    another sign.
    """
    for index, term in enumerate(expr.args):
        yield EditProposal(("sign of ", term), -term, path=(index,))
        for factor in FACTORS:
            yield EditProposal(("factor ", factor, " on ", term), factor * term, path=(index,))
        yield EditProposal(("without ", term), sp.S.Zero, removes=True, path=(index,))
    if 2 < len(expr.args) <= GROUP or (len(expr.args) == 2 and not linear):
        for size in range(2, len(expr.args) // 2 + 1 if linear else len(expr.args) + 1):
            for group in combinations(expr.args, size):
                flipped = sp.Add(*(-term if term in group else term for term in expr.args))
                yield EditProposal(("sign of the group ", sp.Add(*group)), flipped)


def _functions(expr: Expr) -> Iterator[EditProposal]:
    """A function that was left out, or one too many; a factor on its argument, or under a root."""
    if isinstance(expr, sp.Function):
        for factor in FACTORS:
            if len(expr.args) == 1:
                yield EditProposal(
                    ("factor ", factor, " on the argument of ", expr),
                    expr.func(factor * expr.args[0]),
                )
    if isinstance(expr, sp.Pow) and not expr.exp.is_Integer:
        for factor in FACTORS:
            yield EditProposal(
                ("factor ", factor, " on ", expr.base), (factor * expr.base) ** expr.exp
            )
    if isinstance(expr, INVERSES):
        yield EditProposal((f"without {expr.func.__name__} of ", expr.args[0]), expr.args[0])
    elif isinstance(expr, sp.Add | sp.Mul | sp.Pow | Quantity) and _is_number(expr):
        for function in INVERSES[3:] if isinstance(expr, sp.Add | Quantity) else INVERSES[:3]:
            yield EditProposal((f"{function.__name__} of ", expr), function(expr))
        if isinstance(expr, sp.Add):
            yield EditProposal(("atan of ", expr), sp.atan(expr))


def _is_number(expr: Expr) -> bool:
    try:
        return dimension(expr) == NONE
    except DimensionError:
        return False
