"""A chain of equations that can be audited and executed: residuals, an order of solution, and the steps they give."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import sympy as sp
from sympy import Expr

from .equations import Claimed, Equation, among
from .model import Let
from .quantity import Quantity


class ChainError(ValueError):
    """A chain does not determine its unknowns."""


@dataclass(frozen=True)
class Solve:
    """Solve one equation for one unknown; others may first be used to eliminate what they define in terms of it."""

    equation: str
    unknown: Quantity
    eliminate: tuple[tuple[str, Quantity], ...] = ()


@dataclass(frozen=True)
class Chain:
    """Equations, their order of solution, and how printed symbols bind to named quantities."""

    equations: Mapping[str, Equation]
    order: Sequence[Solve]
    bind: Mapping[sp.Symbol, Expr] = field(default_factory=dict)

    @classmethod
    def of_claims(
        cls,
        equations: Mapping[Claimed, Equation],
        order: Iterable[tuple[Claimed, Quantity]],
        bind: Mapping[sp.Symbol, Expr] | None = None,
    ) -> Chain:
        """A chain whose order says what each equation claims to be; raises ClaimError for what none of them does."""
        found = [(among(equations, claim), unknown) for claim, unknown in order]
        return cls({e.number: e for e, _ in found}, [Solve(e.number, unknown) for e, unknown in found], bind or {})

    def replace(self, number: str, equation: Equation) -> Chain:
        """The same chain with one equation exchanged."""
        if number not in self.equations:
            raise ChainError(f"the chain has no equation {number}")
        return replace(self, equations={**self.equations, number: equation})

    def lets(self) -> tuple[Let, ...]:
        """The executable steps; each is linear in its one unknown."""
        return tuple(self._let(solve) for solve in self.order)

    def _let(self, solve: Solve) -> Let:
        equation = self.equations[solve.equation]
        residual = equation.residual
        for number, symbol in solve.eliminate:
            residual = residual.xreplace({symbol: solve_linear(self.equations[number], symbol)})
        expr = solve_linear(replace(equation, residual=residual), solve.unknown)
        return Let(solve.unknown, close_cases(expr.xreplace(dict(self.bind))), equation.source)


def solve_linear(equation: Equation, unknown: sp.Symbol) -> Expr:
    """The one root of an equation that is linear in ``unknown``."""
    slope = equation.residual.diff(unknown)
    if slope == 0 or slope.has(unknown):
        raise ChainError(f"equation {equation.number} is not linear in {unknown}")
    return -equation.residual.xreplace({unknown: sp.S.Zero}) / slope


def close_cases(expr: Expr) -> Expr:
    """Let the last of a list of cases hold wherever no other does (the papers leave out borderlines)."""

    def closed(cases: sp.Piecewise) -> Expr:
        *head, (last, _) = cases.args
        return sp.Piecewise(*head, (last, True))

    return expr.replace(lambda e: isinstance(e, sp.Piecewise), closed)


def ordered(equations: Sequence[Equation], unknowns: Sequence[Quantity], wanted: Sequence[Quantity]) -> Chain:
    """A chain whose order is found by matching.

    Again and again the first equation with a single open unknown gives it. Where there is none, the first balance
    whose open unknowns are all defined in terms of a single one gives that one.
    """
    still_open = set(unknowns)
    left = list(equations)
    order: list[Solve] = []
    while still_open & set(wanted):
        solve = _single(left, still_open) or _common(left, still_open)
        if solve is None:
            names = ", ".join(sorted(map(str, still_open)))
            raise ChainError(f"no equation is left that gives one more unknown; still open: {names}")
        left = [e for e in left if e.number != solve.equation]
        still_open.discard(solve.unknown)
        order.append(solve)
    return Chain({e.number: e for e in equations}, order)


def _single(equations: Sequence[Equation], still_open: set[Quantity]) -> Solve | None:
    for equation in equations:
        here = equation.residual.free_symbols & still_open
        if len(here) == 1 and (equation.defines is None or equation.defines in here):
            return Solve(equation.number, here.pop())
    return None


def _common(equations: Sequence[Equation], still_open: set[Quantity]) -> Solve | None:
    """A balance in several unknowns that all hang on one: those others are eliminated through their definitions."""
    definitions = {e.defines: e for e in equations if e.defines in still_open}
    for equation in equations:
        here = equation.residual.free_symbols & still_open
        defined = sorted(here & definitions.keys(), key=str)
        roots = (here - definitions.keys()).union(*(_open_in(definitions[s], still_open) for s in defined))
        if equation.defines is None and len(roots) == 1:
            return Solve(equation.number, roots.pop(), tuple((definitions[s].number, s) for s in defined))
    return None


def _open_in(definition: Equation, still_open: set[Quantity]) -> set[Quantity]:
    return (definition.residual.free_symbols & still_open) - {definition.defines}
