"""Cross-references that cannot be meant: to equations that do not give what the paper says it has from them."""

from __future__ import annotations

from typing import Any

from ..equations import Equation
from ..quantity import Quantity
from .case import Case
from .paper import Reference


def references(case: Case) -> list[dict[str, Any]]:
    """Every reference of a paper: whether its equations give the quantities, and which of the paper's do."""
    return [_judged(case, reference) for reference in case.paper.references]


def _judged(case: Case, reference: Reference) -> dict[str, Any]:
    lacking = [s for s in reference.symbols if not any(_gives(_meant(case, n), s) for n in reference.numbers)]
    instead = [n for n in case.paper.equations if any(_gives(_meant(case, n), s) for s in lacking)]
    return {
        "paper": case.paper.name,
        "quantities": [str(symbol) for symbol in reference.symbols],
        "refers_to": list(reference.numbers),
        "verdict": "cannot be meant" if lacking else "can be meant",
        "lacking": [str(symbol) for symbol in lacking],
        "instead": instead,
    }


def _meant(case: Case, number: str) -> Equation:
    """An equation as it is derived, for of many the print is lost; one that stands alone as it is printed."""
    printed = case.paper.equations[number]
    return printed if printed.stands_alone else case.derived(number)


def _gives(equation: Equation, symbol: Quantity) -> bool:
    """Whether an equation says what a quantity is: it defines it, or defines nothing and speaks of it."""
    if equation.defines is not None:
        return equation.defines == symbol
    return symbol in equation.residual.free_symbols
