"""Named steps whose slopes along some coordinates are followed by differentiation."""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..model import Let
from ..quantity import Quantity

Slopes = dict[Quantity, Expr]


@dataclass
class Followed:
    """Steps in their order with their derivatives along coordinates; what depends on no coordinate is constant."""

    coordinates: tuple[Quantity, ...]
    steps: list[Let] = field(default_factory=list)
    known: dict[sp.Symbol, Slopes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.known |= {q: {q: S.One} for q in self.coordinates}

    def let(self, symbol: Quantity, expr: Expr, reason: str = "") -> Quantity:
        """Name an expression, in the unit of ``symbol``, and return the symbol, whose derivatives are then known."""
        self.steps.append(Let(symbol, expr, f"derived: {reason or symbol.meaning}"))
        self.known[symbol] = self.slopes(expr)
        return symbol

    def slopes(self, expr: Expr) -> Slopes:
        """Return the derivatives of an expression along its coordinates [its unit per that of the coordinate]."""
        if isinstance(expr, sp.Piecewise):
            return self._of_cases(expr)
        found: Slopes = {}
        for symbol in sorted(expr.free_symbols & self.known.keys(), key=str):
            outer = expr.diff(symbol)
            for coordinate, inner in self.known[symbol].items():
                found[coordinate] = found.get(coordinate, S.Zero) + outer * inner
        return {coordinate: slope for coordinate, slope in found.items() if slope != 0}

    def along(self, expr: Expr, coordinate: Quantity) -> Expr:
        """Return the derivative of an expression along one coordinate [its unit per that of the coordinate]."""
        return self.slopes(expr).get(coordinate, S.Zero)

    def _of_cases(self, cases: sp.Piecewise) -> Slopes:
        parts = [(self.slopes(value), condition) for value, condition in cases.args]
        return {
            q: sp.Piecewise(*((slopes.get(q, S.Zero), condition) for slopes, condition in parts))
            for q in self.coordinates
            if any(q in slopes for slopes, _ in parts)
        }
