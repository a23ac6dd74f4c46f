"""Lagrange's equations of the second kind: from energies and generalised forces to accelerations."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr

from ..quantity import Quantity
from .frames import Motion


def accelerations(
    kinetic: Expr,
    potential: Expr,
    coordinates: Sequence[Quantity],
    rates: Sequence[Quantity],
    forces: Sequence[Expr],
) -> tuple[Expr, ...]:
    """Accelerations of the coordinates under generalised forces that no potential gives.

    d/dt dT/dq' - dT/dq + dV/dq = Q is linear in the accelerations. What else moves is not asked for.
    """
    wanted = [sp.Dummy(f"{rate}_dot", real=True) for rate in rates]
    motion = Motion(dict(zip((*coordinates, *rates), (*rates, *wanted), strict=True)))
    balances = [
        motion.rate(kinetic.diff(rate)) - (kinetic - potential).diff(coordinate) - force
        for coordinate, rate, force in zip(coordinates, rates, forces, strict=True)
    ]
    matrix, right = sp.linear_eq_to_matrix(balances, wanted)
    return tuple(matrix.LUsolve(right))
