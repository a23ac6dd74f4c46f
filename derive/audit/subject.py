"""A paper on trial: its transcriptions, the system that derives what they claim, and points to decide at."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import sympy as sp
from sympy import Expr

from ..equations import Equation
from ..evaluate import Point
from ..quantity import Quantity
from .paper import Paper

SEEDS = (1, 2, 5, 8)
"""Seeds of the random admissible points: between them they take both cases of every branch."""
DEFINITION = "definition:"

Common = Callable[[Expr, Expr], tuple[Expr, Expr]]


Lift = Callable[[str, Expr], Expr | None]
"""For a claim and the printed residual: the derived one while assumptions are lifted, in the same quantities; None for
a claim that no assumption bears on."""


def unchanged(printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
    return printed, derived


def nothing(claim: str, printed: Expr) -> None:
    return None


@dataclass(frozen=True)
class Subject:
    """A paper with its system. ``reading`` says what printed symbols stand for, ``readings`` in single equations.

    ``common`` brings two sums into the same quantities; ``reference`` gives values along the machine's own cycle;
    ``lift`` derives again without the assumptions that make the quantities of ``zero`` vanish, each for a reason.
    """

    paper: Paper
    derive_claims: Callable[[], dict[str, Equation]]
    admissible: Callable[[random.Random], Mapping[Any, Any]]
    reference: Callable[[int], list[Mapping[Any, Any]]]
    reading: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    readings: Mapping[str, Mapping[sp.Symbol, Expr]] = field(default_factory=dict)
    common: Common = unchanged
    lift: Lift = nothing
    zero: Mapping[sp.Symbol, str] = field(default_factory=dict)
    _lifted: dict[str, Equation | None] = field(init=False, default_factory=dict)

    @classmethod
    def of(cls, paper: ModuleType, system: ModuleType) -> Subject:
        """The subject of a module of transcriptions and a module that derives."""
        return cls(
            paper.PAPER, system.claims, system.admissible, system.reference,
            getattr(paper, "READING", {}), getattr(paper, "READINGS", {}), getattr(system, "common", unchanged),
            getattr(system, "lift", nothing), getattr(system, "ZERO", {}),
        )  # fmt: skip

    @cached_property
    def claims(self) -> dict[str, Equation]:
        return self.derive_claims()

    @cached_property
    def points(self) -> list[Point]:
        return [Point(self.admissible(random.Random(seed))) for seed in SEEDS]

    @cached_property
    def cycle(self) -> list[Point]:
        return [Point(values) for values in self.reference(24)]

    @cached_property
    def words(self) -> list[Quantity]:
        """Every quantity that the paper's equations speak of."""
        found = set().union(*(e.residual.free_symbols for e in self.paper.equations.values()))
        return sorted((s for s in found if isinstance(s, Quantity)), key=str)

    def pair(self, number: str) -> tuple[Equation, Equation | None]:
        """A printed equation as it is read, and its derivation, in the same quantities; None for a definition."""
        printed = self.paper.equations[number]
        read = replace(printed, residual=self._read(number))
        claim = str(printed.claims)
        if claim.startswith(DEFINITION):
            return read, None
        derived = self.claims[claim]
        if _states_a_sum(printed, derived):
            first, second = self.common(read.residual, derived.residual)
            return replace(read, residual=first), replace(derived, residual=second)
        return read, derived

    def _read(self, number: str) -> Expr:
        residual = self.paper.equations[number].residual.xreplace(self.reading_of(number))
        if not residual.free_symbols & self.zero.keys() or self.lifted(number) is None:
            return residual
        return residual.xreplace(dict.fromkeys(self.zero, sp.S.Zero))

    def lifted(self, number: str) -> Equation | None:
        """The derivation of an equation while assumptions are lifted; None where none bears on it."""
        if number not in self._lifted:
            printed = self.paper.equations[number]
            claim = str(printed.claims)
            kept = self.lift(claim, printed.residual.xreplace(self.reading_of(number)))
            self._lifted[number] = None if kept is None else replace(self.claims[claim], residual=kept)
        return self._lifted[number]

    def assumed(self, number: str) -> dict[sp.Symbol, str]:
        """Quantities of an equation, printed or derived, that an assumption makes zero, each with the reason."""
        kept = self.lifted(number)
        if kept is None:
            return {}
        here = kept.residual.free_symbols | self.paper.equations[number].residual.free_symbols
        return {s: why for s, why in self.zero.items() if s in here}

    def reading_of(self, number: str) -> dict[sp.Symbol, Expr]:
        """What the printed symbols of an equation stand for."""
        return {**self.reading, **self.readings.get(number, {})}

    def read_as(self, number: str) -> str:
        """How the symbols of an equation are read that stand for something else."""
        here = self.paper.equations[number].residual.free_symbols
        return "; ".join(f"{s} read as {e}" for s, e in sorted(self.reading_of(number).items(), key=str) if s in here)


def _states_a_sum(printed: Equation, derived: Equation) -> bool:
    return printed.defines is None and derived.defines is None and printed.relation == "="
