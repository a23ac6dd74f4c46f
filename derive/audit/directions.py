"""Which angles are directions, that a whole turn does not change: told from how equations use them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from sympy import Basic

from ..equations import Equation
from ..quantity import Quantity

_PERIODIC = (sp.sin, sp.cos, sp.tan)


def directions(equations: Sequence[Equation]) -> frozenset[Quantity]:
    """Angles that come in by sines, cosines and tangents alone, or in what another direction is defined as.

    Whole multiples of them only: half a turn of half an angle is not a turn.
    """
    symbols = set().union(*(e.residual.free_symbols for e in equations))
    found = {s for s in symbols if isinstance(s, Quantity) and s.unit == "rad"}
    while counted := {s for s in found if not _turns_freely(s, equations, found)}:
        found -= counted
    return frozenset(s for s in found if any(_is_periodic_in(e, s) for e in equations))


def _turns_freely(symbol: Quantity, equations: Iterable[Equation], known: set[Quantity]) -> bool:
    """Whether no equation but those of other directions tells it from itself a turn later."""
    for equation in equations:
        if symbol in equation.residual.free_symbols:
            outside = _outside(equation.residual, symbol)
            if equation.defines is not None and equation.defines in known:
                outside = {node for node in outside if not _adds(node, symbol)}
            if outside:
                return False
    return True


def _outside(expr: Basic, symbol: Quantity) -> set[Basic]:
    """The terms of an expression, or of its cases, in which a symbol stands elsewhere than in a periodic function."""
    if symbol not in expr.free_symbols:
        return set()
    if isinstance(expr, _PERIODIC):
        return set() if _adds(expr.args[0], symbol) else {expr}
    if isinstance(expr, sp.Mul) and expr.args[0].is_Integer:
        return _outside(sp.Mul(*expr.args[1:]), symbol)
    inner = set().union(*(_outside(part, symbol) for part in expr.args))
    if isinstance(expr, sp.Add | sp.Piecewise | sp.Tuple):
        return inner
    return {expr} if inner or isinstance(expr, sp.Symbol) else set()


def _adds(expr: Basic, symbol: Quantity) -> bool:
    """Whether a symbol stands in a sum, a whole number of times."""
    if not isinstance(expr, sp.Expr):
        return False
    here = [term for term in sp.Add.make_args(sp.expand_mul(expr)) if symbol in term.free_symbols]
    return len(here) == 1 and bool((here[0] / symbol).is_Integer)


def _is_periodic_in(equation: Equation, symbol: Quantity) -> bool:
    return any(symbol in node.free_symbols for node in equation.residual.atoms(*_PERIODIC))
