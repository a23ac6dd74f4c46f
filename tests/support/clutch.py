"""Values of what is derived of the clutch, at high precision and in floating point."""

from __future__ import annotations

import mpmath
import sympy as sp

from derive.papers.clutch import subject as claims
from tests.support.late import LateDict

CLAIMS = LateDict(
    lambda: {str(claim): equation for claim, equation in claims.derive_formulas().equations.items()}
)


def value(expr: sp.Expr, point: claims.Values) -> mpmath.mpf:
    symbols = sorted(expr.free_symbols, key=str)
    with mpmath.workdps(60):
        return mpmath.mpf(sp.lambdify(symbols, expr, "mpmath")(*(point[s] for s in symbols)))


def size(expr: sp.Expr, point: claims.Values) -> mpmath.mpf:
    return max(
        (abs(value(term, point)) for term in sp.Add.make_args(expr)), default=mpmath.mpf(1)
    ) or mpmath.mpf(1)


def derived(claim: str) -> sp.Expr:
    """The expression that a derived definition gives."""
    equation = CLAIMS[claim]
    return equation.defines - equation.residual


def number(claim: str, **values: float) -> float:
    """The same in floating point, symbols given by name."""
    expr = derived(claim)
    return float(sp.lambdify(sorted(expr.free_symbols, key=str), expr, "numpy")(**values))
