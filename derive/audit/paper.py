"""A paper as data: its equations as they stand in print."""

from __future__ import annotations

from dataclasses import dataclass, field

from sympy import Expr

from ..equations import Balance, Equation, Legibility, Relation
from ..quantity import Quantity


@dataclass
class Paper:
    """Transcriptions of one paper, by equation number; a short name stands for a number where print gives none."""

    name: str
    reference: str
    equations: dict[str, Equation] = field(default_factory=dict)

    def equation(self, number: str, residual: Expr, claims: Balance | str, legibility: Legibility = "printed") -> None:
        """An equation printed as ``residual = 0``, and the balance or relation that the paper says it is."""
        self._add(Equation(number, residual, f"{self.name} ({number})", claims, legibility))

    def defines(
        self, number: str, symbol: Quantity, expr: Expr, claims: str, legibility: Legibility = "printed"
    ) -> None:
        """A formula printed as ``symbol = expr``."""
        self._add(Equation(number, symbol - expr, f"{self.name} ({number})", claims, legibility, defines=symbol))

    def inequality(
        self, number: str, left: Expr, relation: Relation, right: Expr, claims: str, legibility: Legibility = "printed"
    ) -> None:
        """A condition printed as ``left < right`` or the like."""
        source = f"{self.name} ({number})"
        self._add(Equation(number, left - right, source, claims, legibility, relation=relation))

    def symbol(self, name: str, unit: str, meaning: str) -> Quantity:
        """A symbol that only the paper uses."""
        return Quantity(name, unit, meaning, self.name)

    def _add(self, equation: Equation) -> None:
        if equation.number in self.equations:
            raise ValueError(f"{self.name} has two equations {equation.number}")
        self.equations[equation.number] = equation
