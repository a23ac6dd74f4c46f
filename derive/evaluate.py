"""Values to many digits: of expressions at points, and of the data of machine files."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Basic, Expr

from .functions import TabulatedFunction, Turns
from .quantity import Quantities, Quantity, find_factor

DIGITS = 50
GUARD = 10
TOLERANCE = mpf(10) ** -(DIGITS - 8)
"""Equality to this share of the largest term."""

_FUNCTIONS = {
    **{
        getattr(sp, name): getattr(mpmath, name)
        for name in ("cos", "sin", "tan", "acos", "asin", "atan", "atan2")
    },
    **{
        getattr(sp, name): getattr(mpmath, name)
        for name in ("exp", "log", "sign", "floor", "cosh", "sinh", "tanh")
    },
    **{getattr(sp, name): getattr(mpmath, name) for name in ("cot", "sec", "csc")},
    sp.Abs: abs,
    sp.Min: min,
    sp.Max: max,
    Turns: mpmath.floor,
}
_RELATIONS = {
    sp.Ge: lambda a, b: a >= b,
    sp.Gt: lambda a, b: a > b,
    sp.Le: lambda a, b: a <= b,
    sp.Lt: lambda a, b: a < b,
    sp.Eq: lambda a, b: a == b,
    sp.Ne: lambda a, b: a != b,
}


class NotEvaluated(ValueError):
    """A symbol has no value at a point, or an expression no real one."""


class UnknownNodeError(ValueError):
    """An expression contains a function or a relation that cannot be evaluated at any point."""


class Point:
    """Values of symbols; expressions of them are evaluated on demand and remembered."""

    def __init__(self, values: Mapping[sp.Symbol, object]) -> None:
        with mpmath.workdps(DIGITS + GUARD):
            self._symbols: dict[sp.Symbol, mpf] = {
                symbol: _number(value) for symbol, value in values.items()
            }
        self._values: dict[Basic, mpf] = dict(self._symbols)
        self._digits: dict[Expr, str] = {}

    def __contains__(self, symbol: sp.Symbol) -> bool:
        return symbol in self._symbols

    def digits(self, expr: Expr) -> str:
        """The value to 30 digits, to compare by."""
        if expr not in self._digits:
            self._digits[expr] = mpmath.nstr(self(expr), 30)
        return self._digits[expr]

    def values(self) -> dict[sp.Symbol, mpf]:
        """Return the values of all symbols that have one."""
        return dict(self._symbols)

    def set(self, symbol: sp.Symbol, value: object) -> None:
        """Give a symbol a value; if it had another, what was evaluated with that is forgotten."""
        with mpmath.workdps(DIGITS + GUARD):
            number = _number(value)
        if symbol in self._symbols:
            self._values, self._digits = dict(self._symbols), {}
        self._symbols[symbol] = self._values[symbol] = number

    def __call__(self, expr: Expr) -> mpf:
        with mpmath.workdps(DIGITS + GUARD):
            return self._value(expr)

    def holds(self, condition: Basic) -> bool:
        """Whether a condition holds at the point."""
        with mpmath.workdps(DIGITS + GUARD):
            return self._holds(condition)

    def _value(self, expr: Basic) -> mpf:
        value = self._values.get(expr)
        if value is None:
            value = self._fresh(expr)
            if isinstance(value, mpmath.mpc):
                raise NotEvaluated(f"{expr} is not real")
            self._values[expr] = value
        return value

    def _fresh(self, expr: Basic) -> mpf:
        if isinstance(expr, sp.Symbol):
            raise NotEvaluated(f"{expr} has no value")
        if not expr.args:
            return _number(expr)
        if isinstance(expr, sp.Piecewise):
            return self._case(expr)
        values = [self._value(a) for a in expr.args]
        if isinstance(expr, TabulatedFunction):
            if expr.is_outside(values[0]):
                raise NotEvaluated(f"{expr} is not real")
            return expr.evaluate_at(values[0])
        if isinstance(expr, sp.Add):
            return mpmath.fsum(values)
        if isinstance(expr, sp.Mul):
            return mpmath.fprod(values)
        if isinstance(expr, sp.Pow):
            return values[0] ** values[1]
        if expr.func in _FUNCTIONS:
            return _FUNCTIONS[expr.func](*values)
        raise UnknownNodeError(f"{expr.func.__name__} cannot be evaluated")

    def _case(self, expr: sp.Piecewise) -> mpf:
        for value, condition in expr.args:
            if self._holds(condition):
                return self._value(value)
        return mpf(0)

    def _holds(self, condition: Basic) -> bool:
        if condition in (sp.true, sp.false):
            return bool(condition)
        if isinstance(condition, sp.And):
            return all(self._holds(a) for a in condition.args)
        if isinstance(condition, sp.Or):
            return any(self._holds(a) for a in condition.args)
        if isinstance(condition, sp.Not):
            return not self._holds(condition.args[0])
        if condition.func not in _RELATIONS:
            raise UnknownNodeError(f"{condition} cannot be evaluated")
        relation: Callable[[mpf, mpf], bool] = _RELATIONS[condition.func]
        return bool(relation(self._value(condition.args[0]), self._value(condition.args[1])))


def _number(value: object) -> mpf:
    return _constant(value) if isinstance(value, sp.Basic) else mpf(value)


@cache
def _constant(value: Basic) -> mpf:
    with mpmath.workdps(DIGITS + GUARD):
        return mpf(sp.N(value, DIGITS + GUARD))


@dataclass(frozen=True)
class MachineFile:
    """Tables of a machine, decimal numbers as they are written."""

    tables: Mapping[str, Any]

    @classmethod
    def read(cls, path: Path) -> MachineFile:
        """Read a machine file (TOML) with its numbers as exact decimals."""
        return cls(tomllib.loads(path.read_text(encoding="utf-8"), parse_float=Decimal))

    def si(self, place: str) -> mpf:
        """The number at ``section.key``, ``section.key[index]`` or ``section[index].key``, to the
        working precision.
        """
        value, key = self._at(place)
        return mpf(str(value)) * si_factor(key)

    def all_si(self, place: str) -> list[mpf]:
        """The numbers of a list."""
        values, key = self._at(place)
        return [mpf(str(value)) * si_factor(key) for value in values]

    def _at(self, place: str) -> tuple[Any, str]:
        """A value and its key."""
        value: Any = self.tables
        key = ""
        for key, index in re.findall(r"(\w+)(?:\[(\d+)\])?", place):
            value = value[key][int(index)] if index else value[key]
        return value, key


def si_factor(key: str) -> mpf:
    """Return the factor to SI of the unit at the end of a key."""
    return mpf(find_factor(key).evalf(mpmath.mp.dps))


def table_values(table: Quantities) -> dict[Quantity, mpf]:
    """Return the values of a table, in SI."""
    return {
        table[name]: mpf(str(datum.value)) * si_factor(table[name].shown)
        for name, datum in table.data.items()
    }
