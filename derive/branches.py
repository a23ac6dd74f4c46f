"""Branches: values that are selected, wrapped or clipped, each case finite everywhere."""

from __future__ import annotations

import sympy as sp
from sympy import Expr


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
    """Number of whole periods in an angle: ``floor``, with the derivative that it has between its steps."""

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Expr:
        return sp.S.Zero

    def _eval_rewrite(self, rule: object, args: tuple[Expr, ...], **hints: object) -> Expr | None:
        return sp.floor(*args) if rule == sp.floor else None

    def _eval_evalf(self, prec: int) -> Expr:
        return sp.floor(self.args[0])._eval_evalf(prec)


def wrap(x: Expr, period: Expr) -> Expr:
    """``x`` brought into ``[0, period)``."""
    return x - period * Turns(x / period)
