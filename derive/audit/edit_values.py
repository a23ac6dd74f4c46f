"""Values of edits in floating point: which of many may be corrections is seen before any of them is
carried out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from itertools import groupby
from typing import Any

import numpy as np
import sympy as sp
from sympy import Basic, Expr

from ..evaluate import Point
from .edits import EditProposal

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


def _to_float(expr: Basic, point: Point) -> float:
    try:
        return float(point(expr))
    except (ValueError, TypeError):
        return float("nan")
