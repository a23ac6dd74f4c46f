"""Convex quadratic programmes of a few variables, by DAQP, a dual active-set method that comes with CasADi."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array

OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "daqp": {"eps_prox": 1e-4, "primal_tol": 1e-10, "dual_tol": 1e-12},
}
"""The proximal term makes what is only convex strictly so; it is taken back by iterating."""


@dataclass(frozen=True)
class Quadratic:
    """A minimum: variables (n,), multipliers of the rows (m,) and of the bounds (n,), positive at upper ones."""

    z: Array
    rows: Array
    bounds: Array


def solve(hessian: Array, gradient: Array, rows: Array, most: Array, bounds: tuple[Array, Array]) -> Quadratic | None:
    """Minimise gradient . z + z' hessian z / 2 with rows (m, n) . z <= most and z in bounds; None where that failed."""
    solver = _solver(len(gradient), len(most))
    low, high = bounds
    least = np.full(len(most), -np.inf)
    found = solver(h=hessian, g=gradient, a=rows, lba=least, uba=most, lbx=low, ubx=high)
    if not solver.stats()["success"]:
        return None
    z, along, held = (np.asarray(found[key], dtype=float)[:, 0] for key in ("x", "lam_a", "lam_x"))
    return Quadratic(z, along, held)


@cache
def _solver(size: int, rows: int) -> ca.Function:
    shapes = {"h": ca.Sparsity.dense(size, size), "a": ca.Sparsity.dense(rows, size)}
    return ca.conic("quadratic", "daqp", shapes, OPTIONS)
