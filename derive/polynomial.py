"""Polynomials with their coefficients side by side: a target may evaluate them in the way that suits it."""

from __future__ import annotations

import sympy as sp
from sympy import Expr


class Polynomial(sp.Function):
    """``Polynomial(x, a_n, ..., a_0)``: the sum of a_k x^k."""

    @classmethod
    def of(cls, law: Expr, x: sp.Symbol, at: Expr) -> Expr:
        """A polynomial in ``x``, taken ``at`` something."""
        return cls(at, *sp.Poly(law, x).all_coeffs())

    def fdiff(self, argindex: int = 1) -> Expr:
        x, *coefficients = self.args
        powers = range(len(coefficients) - 1, 0, -1)
        return Polynomial(x, *(k * a for k, a in zip(powers, coefficients, strict=False)))

    def doit(self, **hints: object) -> Expr:
        """Written out."""
        x, *coefficients = self.args
        return sp.Add(*(a * x**k for k, a in enumerate(reversed(coefficients))))

    def _eval_evalf(self, prec: int) -> Expr:
        return self.doit()._eval_evalf(prec)
