"""Derivatives of expressions in one pass over their parts, each part once: for expressions of many symbols."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy import Expr, S


def along(expr: Expr, rates: Mapping[sp.Symbol, Expr]) -> Expr:
    """Rate of an expression whose symbols change at the rates; those without one are constant.

    >>> x, y = sp.symbols("x y")
    >>> along(x**2 * sp.sin(y), {x: S.One, y: x})
    x**3*cos(y) + 2*x*sin(y)
    """
    return _Pass(rates).rate(sp.sympify(expr))


def slope(expr: Expr, symbol: sp.Symbol) -> Expr:
    """Derivative by a symbol."""
    return along(expr, {symbol: S.One})


class _Pass:
    def __init__(self, rates: Mapping[sp.Symbol, Expr]) -> None:
        self._found: dict[Expr, Expr] = dict(rates)

    def rate(self, expr: Expr) -> Expr:
        if expr in self._found:
            return self._found[expr]
        found = S.Zero if expr.is_Atom else self._of(expr)
        self._found[expr] = found
        return found

    def _of(self, expr: Expr) -> Expr:
        rates = [self.rate(a) if isinstance(a, Expr) else None for a in expr.args]
        if isinstance(expr, sp.Add):
            return sp.Add(*rates)
        if isinstance(expr, sp.Mul):
            return sp.Add(*(sp.Mul(*expr.args[:i], r, *expr.args[i + 1 :]) for i, r in enumerate(rates) if r != 0))
        if isinstance(expr, sp.Pow) and rates[1] == 0:
            base, exponent = expr.args
            return exponent * base ** (exponent - 1) * rates[0]
        if isinstance(expr, sp.Function) and not isinstance(expr, sp.Piecewise) and None not in rates:
            return sp.Add(*(expr.fdiff(i) * r for i, r in enumerate(rates, 1) if r != 0))
        return sp.Add(*(expr.diff(s) * self._found[s] for s in sorted(expr.free_symbols & self._found.keys(), key=str)))
