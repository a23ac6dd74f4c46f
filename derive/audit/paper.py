"""A paper as data: its equations as they stand in print."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr

from ..equations import Claimed, Equation, Legibility, Relation
from ..quantity import Quantity


@dataclass
class Paper:
    """Transcriptions of one paper, by equation number; a short name stands for a number where print gives none.

    ``reading`` says what printed symbols stand for in the named quantities, ``readings`` in single equations. Papers
    are shown in the order of their ``place``, those that have none after them, by name.
    """

    name: str
    reference: str
    equations: dict[str, Equation] = field(default_factory=dict)
    place: int | None = None
    reading: dict[sp.Symbol, Expr] = field(default_factory=dict)
    readings: dict[str, dict[sp.Symbol, Expr]] = field(default_factory=dict)

    @property
    def rank(self) -> tuple[bool, int, str]:
        """What papers are sorted by."""
        return self.place is None, self.place or 0, self.name

    def equation(self, number: str, residual: Expr, claims: Claimed, legibility: Legibility = "printed") -> None:
        """An equation printed as ``residual = 0``, and the balance or relation that the paper says it is."""
        self._add(Equation(number, residual, f"{self.name} ({number})", claims, legibility))

    def defines(
        self, number: str, symbol: Quantity, expr: Expr, claims: Claimed, legibility: Legibility = "printed"
    ) -> None:
        """A formula printed as ``symbol = expr``."""
        self._add(Equation(number, symbol - expr, f"{self.name} ({number})", claims, legibility, defines=symbol))

    def inequality(
        self,
        number: str,
        left: Expr,
        relation: Relation,
        right: Expr,
        claims: Claimed,
        legibility: Legibility = "printed",
    ) -> None:
        """A condition printed as ``left < right`` or the like."""
        source = f"{self.name} ({number})"
        self._add(Equation(number, left - right, source, claims, legibility, relation=relation))

    def symbol(self, name: str, unit: str, meaning: str) -> Quantity:
        """A symbol that only the paper uses."""
        return Quantity(name, unit, meaning, self.name)

    def reads(self, meaning: Mapping[sp.Symbol, Expr], *numbers: str) -> None:
        """What printed symbols stand for: in the equations of these numbers, or wherever they stand without any."""
        for number in numbers:
            if number not in self.equations:
                raise ValueError(f"{self.name} has no equation {number} to read")
            self.readings.setdefault(number, {}).update(meaning)
        if not numbers:
            self.reading.update(meaning)

    def _add(self, equation: Equation) -> None:
        if equation.number in self.equations:
            raise ValueError(f"{self.name} has two equations {equation.number}")
        self.equations[equation.number] = equation
