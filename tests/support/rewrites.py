"""Other ways to write the same equation: what must change nothing in an audit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import sympy as sp
from sympy import Basic, Expr

from derive import papers
from derive.audit.verdicts import find_cases
from derive.discovery import import_modules
from derive.equations import Equation
from tests.support.errors import REVERSED, rewritten


def _make_opaque(function: type[sp.Function]) -> Callable[[Expr], Expr]:
    return lambda argument: function(argument, evaluate=False)


_sin, _cos, _tan = (_make_opaque(f) for f in (sp.sin, sp.cos, sp.tan))


def _replaced(old: type[Basic], new: Callable[..., Expr]) -> Callable[[Expr], Expr]:
    return lambda expr: expr.replace(old, new)


def _reversed(expr: Expr) -> Expr:
    return (
        expr.func(*reversed(expr.args), evaluate=False)
        if isinstance(expr, sp.Add | sp.Mul)
        else expr
    )


def _product(base: Expr, exponent: Expr) -> Expr:
    return sp.Mul(base, base, evaluate=False) if exponent == 2 else sp.Pow(base, exponent)


def _conditions_turned(expr: Expr) -> Expr:
    return expr.replace(
        sp.Piecewise,
        lambda *cases: sp.Piecewise(
            *((v, c.reversed if c.is_Relational else c) for v, c in cases[::-1])
        ),
    )


def _sides_exchanged(equation: Equation) -> Equation:
    if equation.defines is not None:
        return equation
    relation = REVERSED.get(equation.relation, equation.relation)
    return replace(equation, residual=-equation.residual, relation=relation)


def _multiplied(equation: Equation) -> Equation:
    if equation.defines is not None or equation.relation != "=":
        return equation
    return replace(equation, residual=sp.Rational(7, 3) * equation.residual)


def _turned_round(equation: Equation) -> Equation:
    """Both sides of a definition counted in the other sense."""
    return equation if equation.defines is None else replace(equation, residual=-equation.residual)


def _divided(equation: Equation) -> Equation:
    """A homogeneous equation divided by a factor that it has, or may have, in every term."""
    if equation.defines is not None or equation.relation != "=" or equation.residual == 0:
        return equation
    expanded = sp.expand(equation.residual, trig=False)
    factor = sorted(expanded.free_symbols, key=str)[0]
    return replace(equation, residual=sp.expand(expanded / factor, trig=False))


def _a_turn_on(equation: Equation) -> Equation:
    """A direction a whole turn on: an angle of which everything else asks for sines and cosines
    alone.
    """
    direction = any(
        equation.defines in case.directions for case in find_cases(import_modules(papers)).values()
    )
    return rewritten(equation, lambda e: e + 2 * sp.pi) if direction else equation


_EXPRESSIONS: dict[str, Callable[[Expr], Expr]] = {
    "multiplied out": sp.expand,
    "products multiplied out": sp.expand_mul,
    "factored": sp.factor,
    "common factors taken out": sp.factor_terms,
    "one fraction": sp.together,
    "terms reversed": _reversed,
    "double negation": lambda e: sp.Mul(-1, sp.Mul(-1, e, evaluate=False), evaluate=False),
    "halves of the double": lambda e: (
        e and sp.Mul(sp.Rational(1, 2), sp.Mul(2, e, evaluate=False), evaluate=False)
    ),
    "divided by one": lambda e: sp.Mul(
        e, sp.Pow(sp.Integer(1), -1, evaluate=False), evaluate=False
    ),
    "sin(pi - x)": _replaced(sp.sin, lambda x: _sin(sp.pi - x)),
    "-sin(-x)": _replaced(sp.sin, lambda x: -_sin(-x)),
    "cos(-x)": _replaced(sp.cos, lambda x: _cos(-x)),
    "-cos(pi - x)": _replaced(sp.cos, lambda x: -_cos(sp.pi - x)),
    "cos(2 pi + x)": _replaced(sp.cos, lambda x: _cos(2 * sp.pi + x)),
    "tan(pi + x)": _replaced(sp.tan, lambda x: _tan(sp.pi + x)),
    "sin/cos for tan": _replaced(sp.tan, lambda x: sp.sin(x) / sp.cos(x)),
    "-atan(-x)": _replaced(sp.atan, lambda x: -sp.atan(-x, evaluate=False)),
    "squares as products": _replaced(sp.Pow, _product),
    "sin^2 + cos^2 for one": lambda e: e * (sp.sin(1) ** 2 + sp.cos(1) ** 2),
    "sums of angles multiplied out": sp.expand_trig,
    "conditions the other way round": _conditions_turned,
}
REWRITES: dict[str, Callable[[Equation], Equation]] = {
    **{name: partial(rewritten, change=change) for name, change in _EXPRESSIONS.items()},
    "sides exchanged": _sides_exchanged,
    "both sides times a number": _multiplied,
    "both sides the other way round": _turned_round,
    "divided by a factor": _divided,
    "a whole turn on": _a_turn_on,
}
"""Other ways to write the same, by name."""
PLACES_KEPT = (
    "sides exchanged",
    "both sides times a number",
    "terms reversed",
    "double negation",
    "halves of the double",
    "one fraction",
    "cos(-x)",
    "-sin(-x)",
    "sin/cos for tan",
    "-atan(-x)",
    "squares as products",
)
"""Rewrites that keep the places at which an equation may be corrected: the rest may join or split
them.
"""
