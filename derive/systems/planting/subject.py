"""What the audit asks of the planting device."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...audit.laws import Dynamics
from ...audit.subject import Subject
from ...equations import Claimed, Equation
from . import assumptions, claims, cycle, laws


class PlantingDevice(Subject):
    """The planting device, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        return claims.claims()

    def admissible(self, rng: random.Random) -> Mapping[sp.Symbol, mpf]:
        return claims.admissible(rng)

    def reference(self, points: int) -> Sequence[Mapping[sp.Symbol, mpf]]:
        return claims.reference(points)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        return claims.common(printed, derived)

    def footings(self, printed: Expr, derived: Expr) -> Sequence[tuple[Expr, Expr]]:
        return claims.footings(printed, derived)

    def folds(self) -> Mapping[sp.Symbol, Expr]:
        return claims.OFFSETS

    def actions(self) -> Mapping[sp.Symbol, str]:
        return claims.actions()

    def zero(self) -> Mapping[sp.Symbol, str]:
        return assumptions.ZERO

    def lift(self, claim: Claimed, printed: Expr) -> Expr | None:
        return assumptions.lift(claim, printed)

    def dynamics(self) -> Dynamics:
        return laws.dynamics()

    def files(self) -> Iterable[Path]:
        """Return the machine file, on which the laws depend."""
        return (cycle.MACHINE,)


SUBJECT = PlantingDevice()
