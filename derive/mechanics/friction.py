"""Dry friction for integrators: Coulomb's that creeps below a speed, and bristles that bend before they slide."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr


def square(components: Sequence[Expr]) -> Expr:
    return sp.Add(*(c**2 for c in components))


def creeping(limit: Expr, slip: Sequence[Expr], speed: Expr) -> Expr:
    """Friction per slip velocity, against it: Coulomb's ``limit`` whose sign is smoothed below a ``speed``."""
    return limit / sp.sqrt(square(slip) + speed**2)


def dahl(
    sliding: Sequence[Expr], bent: Sequence[Expr], stiffness: Expr, limit: Expr, creep: Expr
) -> tuple[tuple[Expr, ...], Expr]:
    """Rates at which bristles bend, and the power lost in them; their force is ``-stiffness * bent``.

    Elastic at first, with the limit as the largest force while sliding goes on one way. ``creep`` is a speed that
    keeps the law smooth where sliding stops (Dahl, Solid friction damping of mechanical vibrations, AIAA J. 14, 1976).
    """
    yielding = sp.sqrt(square(sliding) + creep**2) * stiffness / limit
    rates = tuple(speed - yielding * bend for speed, bend in zip(sliding, bent, strict=True))
    return rates, stiffness * square(bent) * yielding
