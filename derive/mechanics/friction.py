"""Dry friction for integrators: Coulomb's that creeps below a speed, and bristles that bend before they slide."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr


def square(components: Sequence[Expr]) -> Expr:
    return sp.Add(*(c**2 for c in components))


def creeping(limit: Expr, slip: Sequence[Expr], speed: Expr) -> Expr:
    """Return the friction force per slip velocity [N s/m], Coulomb's ``limit`` [N] smoothed below ``speed`` [m/s].

    The force acts against the slip velocity [m/s], whose components are passed: it is minus the result times them.

    >>> from sympy import symbols
    >>> from derive import creeping
    >>> limit, v, speed = symbols("limit v speed", positive=True)
    >>> creeping(limit, (v,), speed)
    limit/sqrt(speed**2 + v**2)
    """
    return limit / sp.sqrt(square(slip) + speed**2)


def dahl(
    sliding: Sequence[Expr], bent: Sequence[Expr], stiffness: Expr, limit: Expr, creep: Expr
) -> tuple[tuple[Expr, ...], Expr]:
    """Return the rates [m/s] at which bristles bend, and the power lost in them [W], by Dahl's law of friction.

    ``sliding`` [m/s] and ``bent`` [m] are components of the sliding velocity and of the bristles' deflection; the force
    is ``-stiffness * bent``, with ``stiffness`` in [N/m]. It is elastic at first and tends to ``limit`` [N] while
    sliding continues one way. ``creep`` [m/s] keeps the law smooth at rest (Dahl, Solid friction damping of mechanical
    vibrations, AIAA J. 14, 1976).

    >>> from sympy import symbols
    >>> from derive import dahl
    >>> v, z, k, limit = symbols("v z k limit", positive=True)
    >>> dahl((v,), (z,), k, limit, 0)
    ((-k*v*z/limit + v,), k**2*v*z**2/limit)
    """
    yielding = sp.sqrt(square(sliding) + creep**2) * stiffness / limit
    rates = tuple(speed - yielding * bend for speed, bend in zip(sliding, bent, strict=True))
    return rates, stiffness * square(bent) * yielding
