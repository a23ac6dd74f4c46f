"""Dimensions of expressions from the units of their quantities."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction
from functools import cache

import sympy as sp
from sympy import Expr
from sympy.core.relational import Relational

from .branches import Turns
from .quantity import Quantity

Dimension = tuple[Fraction, Fraction, Fraction]
NONE: Dimension = (Fraction(0), Fraction(0), Fraction(0))
_BASE = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2), "W": (1, 2, -3), "J": (1, 2, -2),
    "rad": (0, 0, 0), "1": (0, 0, 0),
}  # fmt: skip


class DimensionError(ValueError):
    """An expression adds, compares or feeds to a function what does not fit."""


@cache
def of_unit(unit: str) -> Dimension:
    """Exponents of kg, m, s in a unit such as ``kg m2``, ``m/s2`` or ``N/m1.5``; angles are pure numbers."""
    total = NONE
    for sign, part in zip((1, -1), unit.split("/"), strict=False):
        for name, power in re.findall(r"([A-Za-z]+|1)(\d*(?:\.\d+)?)", part):
            total = _plus(total, _times(_dimension(_BASE[name]), sign * Fraction(power or 1)))
    return total


def dimension(expr: Expr) -> Dimension | None:
    """Dimension of an expression; None for a zero, which fits everywhere. Raises DimensionError where it has none."""
    if expr.is_Symbol:
        return of_unit(expr.unit) if isinstance(expr, Quantity) else NONE
    if expr.is_number:
        return None if expr.is_zero else NONE
    if isinstance(expr, sp.Add | sp.Min | sp.Max):
        return _same(expr.args, expr)
    if isinstance(expr, sp.Mul):
        parts = [dimension(a) for a in expr.args]
        return None if None in parts else _sum(p for p in parts if p is not None)
    if isinstance(expr, sp.Pow):
        return _power(expr)
    if isinstance(expr, sp.Piecewise):
        for _, condition in expr.args:
            _check_condition(condition)
        return _same([value for value, _ in expr.args], expr)
    if isinstance(expr, sp.Abs):
        return dimension(expr.args[0])
    return _of_function(expr)


def is_consistent(expr: Expr) -> bool:
    """Whether all that an expression joins has one dimension."""
    try:
        dimension(expr)
    except DimensionError:
        return False
    return True


def _of_function(expr: Expr) -> Dimension:
    if isinstance(expr, sp.atan2):
        _same(expr.args, expr)
    elif isinstance(expr, Turns | sp.floor | sp.Function) and not isinstance(expr, sp.sign):
        for argument in expr.args:
            if dimension(argument) not in (None, NONE):
                raise DimensionError(f"the argument of {expr} has a dimension")
    return NONE


def _power(expr: Expr) -> Dimension | None:
    base, exponent = expr.args
    found = dimension(base)
    if found is None or found == NONE:
        return found
    if not isinstance(exponent, sp.Rational):
        raise DimensionError(f"{expr} raises a dimension to a power that is no fraction")
    return _times(found, Fraction(exponent.p, exponent.q))


def _check_condition(condition: sp.Basic) -> None:
    for relation in condition.atoms(Relational):
        _same(relation.args, relation)


def _same(args: Iterable[Expr], whole: sp.Basic) -> Dimension | None:
    found = {d for d in map(dimension, args) if d is not None}
    if len(found) > 1:
        raise DimensionError(f"{whole} joins different dimensions")
    return found.pop() if found else None


def _dimension(exponents: tuple[int, int, int]) -> Dimension:
    kg, m, s = exponents
    return Fraction(kg), Fraction(m), Fraction(s)


def _plus(a: Dimension, b: Dimension) -> Dimension:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _times(a: Dimension, power: Fraction) -> Dimension:
    return a[0] * power, a[1] * power, a[2] * power


def _sum(parts: Iterable[Dimension]) -> Dimension:
    total = NONE
    for part in parts:
        total = _plus(total, part)
    return total
