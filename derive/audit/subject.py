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

from derive.equations import Equation
from derive.evaluate import Point
from derive.paper import Paper
from derive.quantity import Quantity

SEEDS = (1, 2, 5, 8)
"""Seeds of the random admissible points: between them they take both cases of every branch."""
DEFINITION = "definition:"

Common = Callable[[Expr, Expr], tuple[Expr, Expr]]


def unchanged(printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
    return printed, derived


@dataclass(frozen=True)
class Subject:
    """A paper with its system. ``reading`` says what printed symbols stand for, ``readings`` in single equations.

    ``common`` brings two sums into the same quantities; ``reference`` gives values along the machine's own cycle.
    """

    paper: Paper
    derive_claims: Callable[[], dict[str, Equation]]
    admissible: Callable[[random.Random], Mapping[Any, Any]]
    reference: Callable[[int], list[Mapping[Any, Any]]]
    reading: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    readings: Mapping[str, Mapping[sp.Symbol, Expr]] = field(default_factory=dict)
    common: Common = unchanged

    @classmethod
    def of(cls, paper: ModuleType, system: ModuleType) -> Subject:
        """The subject of a module of transcriptions and a module that derives."""
        return cls(
            paper.PAPER, system.claims, system.admissible, system.reference,
            getattr(paper, "READING", {}), getattr(paper, "READINGS", {}), getattr(system, "common", unchanged),
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
        reading = self._reading(number)
        read = replace(printed, residual=printed.residual.xreplace(reading))
        claim = str(printed.claims)
        if claim.startswith(DEFINITION):
            return read, None
        derived = self.claims[claim]
        if printed.defines is None and derived.defines is None and printed.relation == "=":
            first, second = self.common(read.residual, derived.residual)
            return replace(read, residual=first), replace(derived, residual=second)
        return read, derived

    def _reading(self, number: str) -> dict[sp.Symbol, Expr]:
        return {**self.reading, **self.readings.get(number, {})}

    def read_as(self, number: str) -> str:
        """How the symbols of an equation are read that stand for something else."""
        here = self.paper.equations[number].residual.free_symbols
        return "; ".join(f"{s} read as {e}" for s, e in sorted(self._reading(number).items(), key=str) if s in here)
