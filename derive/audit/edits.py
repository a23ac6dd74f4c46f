"""Small edits of an expression: what a slip of the pen, the typesetter or the scanner does to a
formula.

Which of many may be corrections is seen in floating point, before any of them is carried out.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from itertools import combinations, groupby
from typing import Any

import numpy as np
import sympy as sp
from sympy import Basic, Expr, Rational, pi

from ..evaluate import Point
from ..quantity import NONE, DimensionError, Quantity, dimension, is_consistent, of_unit
from .typesetting import Piece, Said

FACTORS = (sp.Integer(2), Rational(1, 2), pi / 180, 180 / pi)
SWAPS = {sp.sin: sp.cos, sp.cos: sp.sin}
INVERSES = (sp.atan, sp.asin, sp.acos, sp.tan, sp.sin, sp.cos)
GROUP = 6
"""Summands of a bracket of which any group may have lost its sign."""
_DOTS = re.compile(r"_(d*)dot$")


PLACE = sp.Symbol("_place", real=True)
"""What stands for the part of an expression that an edit changes."""


@dataclass(frozen=True)
class Edit:
    """One replacement: at one place, or of one symbol throughout.

    ``swaps`` are symbols for others, where that is the edit: what stands in print, and what should.
    ``removes`` says whether it takes something away and puts nothing in its place. ``path`` are the
    indices of arguments down to the part that became ``part``; both are None if the swaps are made
    throughout, or if terms of a sum changed together.
    """

    words: tuple[Piece, ...]
    result: Expr
    swaps: tuple[tuple[Quantity, Expr], ...] = ()
    removes: bool = False
    path: tuple[int, ...] | None = None
    part: Basic | None = None

    def frame(self, expr: Expr) -> tuple[Expr | None, Expr, Expr]:
        """Return what was edited with `PLACE` for the part that changed, and that part before and
        after; no frame where symbols were replaced throughout.
        """
        if self.part is not None and self.path is not None:
            part = _find_part(expr, self.path)
            return _replace_part(expr, self.path, PLACE), part, self.part
        if self.swaps:
            return None, sp.S.Zero, sp.S.Zero
        return PLACE, expr, self.result

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
        if self.part is None:
            return Edit(self.words, expr.xreplace(dict(self.swaps)), self.swaps, self.removes)
        result = _replace_part(expr, self.path, self.part)
        return Edit(self.words, result, self.swaps, self.removes, self.path, self.part)


def _find_part(expr: Basic, path: tuple[int, ...]) -> Basic:
    return _find_part(expr.args[path[0]], path[1:]) if path else expr


def _replace_part(expr: Basic, path: tuple[int, ...], part: Basic) -> Expr:
    if not path:
        return part
    index, *rest = path
    changed = _replace_part(expr.args[index], tuple(rest), part)
    return expr.func(*expr.args[:index], changed, *expr.args[index + 1 :])


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


SCREEN = 1e-7
"""Share of the largest summand that is no more than rounding of 16 digits, some cancellation
included.
"""
MOST_AT_ONCE = 256
"""Symbols replaced throughout that are evaluated at once."""
ARRAY_FUNCTIONS: dict[type[Basic], Callable[..., Any]] = {
    **{
        getattr(sp, name): getattr(np, name)
        for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log")
    },
    sp.asin: np.arcsin,
    sp.acos: np.arccos,
    sp.atan: np.arctan,
    sp.atan2: np.arctan2,
    sp.cot: lambda x: 1 / np.tan(x),
    sp.sec: lambda x: 1 / np.cos(x),
    sp.csc: lambda x: 1 / np.sin(x),
    sp.sign: np.sign,
    sp.floor: np.floor,
    sp.Abs: np.abs,
    sp.Pow: np.power,
    sp.Min: lambda *some: reduce(np.minimum, some),
    sp.Max: lambda *some: reduce(np.maximum, some),
    sp.Add: lambda *some: sum(some),
    sp.Mul: lambda *some: reduce(np.multiply, some),
}
"""What computes each node of an expression on arrays."""


def is_computable(expr: Basic) -> bool:
    """Whether floating point has all functions of an expression."""
    return all(
        not node.args or node.func in ARRAY_FUNCTIONS for node in sp.preorder_traversal(expr)
    )


class EditValues:
    """Values of what edits make of an expression, at points: NaN where there is none that is real.

    A value is carried from the edited place up to the whole, past what stands beside it, which is
    evaluated once. Raises KeyError for an expression that is not computable.
    """

    def __init__(self, expr: Expr, points: Sequence[Point]) -> None:
        self.expr, self.points = expr, points
        self._values: dict[Basic, Any] = {}
        self._complements: dict[tuple[Basic, int], Any] = {}
        self._largest_complement: dict[int, Any] = {}

    def list_values(
        self, proposals: Iterable[EditProposal]
    ) -> Iterator[tuple[EditProposal, Any, Any]]:
        """Yield each edit with the values (points,) after it, and the sizes of their largest
        summands.
        """
        for path, group in groupby(
            proposals, lambda proposal: None if proposal.part is None else proposal.path
        ):
            some = list(group)
            with np.errstate(all="ignore"):
                if path is None:
                    for start in range(0, len(some), MOST_AT_ONCE):
                        few = some[start : start + MOST_AT_ONCE]
                        yield from zip(few, *self._throughout(few), strict=True)
                else:
                    yield from zip(some, *self._at_place(some, path), strict=True)

    def value(self, expr: Basic) -> Any:
        """Return the values (points,) of an expression."""
        return self._evaluate(expr, self._values)

    def _evaluate(self, expr: Basic, values: dict[Basic, Any]) -> Any:
        if expr not in values:
            if expr.args:
                values[expr] = ARRAY_FUNCTIONS[expr.func](
                    *(self._evaluate(part, values) for part in expr.args)
                )
            elif values is self._values:
                values[expr] = np.array([_to_float(expr, point) for point in self.points])
            else:
                values[expr] = self.value(expr)
        return values[expr]

    def _throughout(self, proposals: list[EditProposal]) -> tuple[Any, Any]:
        values: dict[Basic, Any] = {}
        for row, proposal in enumerate(proposals):
            for symbol, other in proposal.swaps:
                if symbol not in values:
                    values[symbol] = np.tile(self.value(symbol), (len(proposals), 1))
                values[symbol][row] = self.value(other)
        result = self._evaluate(self.expr, values)
        parts = [
            np.broadcast_to(self._evaluate(part, values), result.shape)
            for part in sp.Add.make_args(self.expr)
        ]
        return result, np.max(np.abs(parts), axis=0)

    def _at_place(self, proposals: list[EditProposal], path: tuple[int, ...]) -> tuple[Any, Any]:
        values = np.array(
            [self.value(proposal.part) for proposal in proposals if proposal.part is not None]
        )
        above = [self.expr]
        for index in path[:-1]:
            above.append(above[-1].args[index])
        if not path:
            summands = [sp.Add.make_args(proposal.part) for proposal in proposals]
            return values, np.array([self._find_largest(some) for some in summands])
        for expr, index in zip(reversed(above[1:]), reversed(path[1:]), strict=True):
            values = self._put(expr, index, values)
        summand, values = values, self._put(self.expr, path[0], values)
        if not isinstance(self.expr, sp.Add):
            return values, np.abs(values)
        if path[0] not in self._largest_complement:
            summands = self.expr.args[: path[0]] + self.expr.args[path[0] + 1 :]
            self._largest_complement[path[0]] = self._find_largest(summands)
        return values, np.maximum(np.abs(summand), self._largest_complement[path[0]])

    def _find_largest(self, summands: Iterable[Basic]) -> Any:
        return np.max([np.abs(self.value(summand)) for summand in summands], axis=0)

    def _put(self, expr: Basic, index: int, values: Any) -> Any:
        """Return the values of an expression with an argument of other values."""
        if not isinstance(expr, sp.Add | sp.Mul):
            return ARRAY_FUNCTIONS[expr.func](
                *(values if i == index else self.value(p) for i, p in enumerate(expr.args))
            )
        function = ARRAY_FUNCTIONS[expr.func]
        if (expr, index) not in self._complements:
            self._complements[expr, index] = function(
                *(self.value(p) for i, p in enumerate(expr.args) if i != index)
            )
        return function(values, self._complements[expr, index])


def screen_edits(
    expr: Expr,
    proposals: Iterator[EditProposal],
    points: Sequence[Point],
    is_promising: Callable[[Any, Any], bool],
) -> Iterator[EditProposal]:
    """Yield the edits of which the values (points,), beside the sizes of their largest summands,
    are promising; all of an expression that is not computable.
    """
    if not is_computable(expr):
        yield from proposals
        return
    for proposal, values, sizes in EditValues(expr, points).list_values(proposals):
        with np.errstate(all="ignore"):
            if is_promising(values, sizes):
                yield proposal


def _to_float(expr: Basic, point: Point) -> float:
    try:
        return float(point(expr))
    except (ValueError, TypeError):
        return float("nan")
