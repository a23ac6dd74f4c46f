"""SymPy functions of this package (branches, polynomials), and derivatives of expressions of many
symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy import Expr, S


def switch(g: Expr, then: Expr, other: Expr) -> Expr:
    """``then`` where ``g >= 0``, else ``other``."""
    return sp.Piecewise((then, sp.Ge(g, 0)), (other, True))


def clip(x: Expr, lower: Expr, upper: Expr) -> Expr:
    """``x`` held between two bounds."""
    return sp.Piecewise((lower, sp.Lt(x, lower)), (upper, sp.Gt(x, upper)), (x, True))


def clip_slope(x: Expr, slope: Expr) -> Expr:
    """The slope of ``clip(x, 0, 1)``, where that of ``x`` is ``slope``."""
    return sp.Piecewise((sp.S.Zero, sp.Lt(x, 0)), (sp.S.Zero, sp.Gt(x, 1)), (slope, True))


class Turns(sp.Function):
    """Number of whole periods in an angle: ``floor``, with the derivative that it has between its
    steps.
    """

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in the first argument."""
        return sp.S.Zero

    def _eval_rewrite(self, rule: object, args: tuple[Expr, ...], **hints: object) -> Expr | None:
        return sp.floor(*args) if rule == sp.floor else None

    def _eval_evalf(self, prec: int) -> Expr:
        return sp.floor(self.args[0])._eval_evalf(prec)


def wrap(x: Expr, period: Expr) -> Expr:
    """``x`` brought into ``[0, period)``."""
    return x - period * Turns(x / period)


class Polynomial(sp.Function):
    """``Polynomial(x, a_n, ..., a_0)``: the sum of a_k x^k."""

    @classmethod
    def of(cls, law: Expr, x: sp.Symbol, at: Expr) -> Expr:
        """A polynomial in ``x``, taken ``at`` something."""
        return cls(at, *sp.Poly(law, x).all_coeffs())

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in the first argument."""
        x, *coefficients = self.args
        powers = range(len(coefficients) - 1, 0, -1)
        return Polynomial(x, *(k * a for k, a in zip(powers, coefficients, strict=False)))

    def doit(self, **hints: object) -> Expr:
        """Written out."""
        x, *coefficients = self.args
        return sp.Add(*(a * x**k for k, a in enumerate(reversed(coefficients))))

    def _eval_evalf(self, prec: int) -> Expr:
        return self.doit()._eval_evalf(prec)


class TabulatedFunction(sp.Function):
    """A piecewise polynomial of one argument; `derive.read_table` creates a class for every table.

    ``pieces`` holds where each polynomial begins and its coefficients, of the highest power first,
    in the distance from there; ``exponents`` are those of kg, m and s in the unit. Outside of
    ``limits``, if there are any, it has no value.
    """

    nargs = 1
    exponents: tuple[Fraction, Fraction, Fraction]
    pieces: tuple[tuple[float, tuple[float, ...]], ...] = ()
    limits: tuple[float, float] | None = None
    slope: type[TabulatedFunction] | None = None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in the first argument."""
        return sp.S.Zero if self.slope is None else self.slope(self.args[0])

    def is_outside(self, at: Any) -> bool:
        """Return whether the function has no value there."""
        return self.limits is not None and not self.limits[0] <= at <= self.limits[1]

    def _eval_evalf(self, prec: int) -> Expr | None:
        at = self.args[0].evalf(prec)
        return None if not at.is_number or self.is_outside(at) else self.evaluate_at(at)

    def evaluate_at(self, at: Any) -> Any:
        """Return the value at a number of any precision."""
        start, coefficients = next(
            (piece for piece in reversed(self.pieces) if piece[0] <= at), self.pieces[0]
        )
        value = 0 * at
        for coefficient in coefficients:
            value = value * (at - start) + coefficient
        return value


def directional_derivative(expr: Expr, rates: Mapping[sp.Symbol, Expr]) -> Expr:
    """Rate of an expression whose symbols change at the rates; those without one are constant.

    >>> x, y = sp.symbols("x y")
    >>> directional_derivative(x**2 * sp.sin(y), {x: S.One, y: x})
    x**3*cos(y) + 2*x*sin(y)
    """
    return _Pass(rates).rate(sp.sympify(expr))


def partial_derivative(expr: Expr, symbol: sp.Symbol) -> Expr:
    """Derivative by a symbol."""
    return directional_derivative(expr, {symbol: S.One})


class _Pass:
    def __init__(self, rates: Mapping[sp.Symbol, Expr]) -> None:
        self._rates: dict[Expr, Expr] = dict(rates)

    def rate(self, expr: Expr) -> Expr:
        if expr in self._rates:
            return self._rates[expr]
        rate = S.Zero if expr.is_Atom else self._rate_of(expr)
        self._rates[expr] = rate
        return rate

    def _rate_of(self, expr: Expr) -> Expr:
        rates = [self.rate(a) if isinstance(a, Expr) else None for a in expr.args]
        if isinstance(expr, sp.Add):
            return sp.Add(*rates)
        if isinstance(expr, sp.Mul):
            return sp.Add(
                *(
                    sp.Mul(*expr.args[:i], r, *expr.args[i + 1 :])
                    for i, r in enumerate(rates)
                    if r != 0
                )
            )
        if isinstance(expr, sp.Pow) and rates[1] == 0:
            base, exponent = expr.args
            return exponent * base ** (exponent - 1) * rates[0]
        if (
            isinstance(expr, sp.Function)
            and not isinstance(expr, sp.Piecewise)
            and None not in rates
        ):
            return sp.Add(*(expr.fdiff(i) * r for i, r in enumerate(rates, 1) if r != 0))
        moving = sorted((s for s in expr.free_symbols if self.rate(s) != 0), key=str)
        return sp.Add(*(expr.diff(s) * self._rates[s] for s in moving))
