"""An objective as a smooth programme: epigraph form where it has rows.

Over z = (u of the free parameters, t of each group), with the rows measured from a reference level
in their units:

    minimise  smooth(u) + weights . t   subject to  rows(u) <= t of their group,  holds(u) in
    bounds,  u in the box.
"""

from __future__ import annotations

import numpy as np

from planter.engine.solvers.objective import LocalModel, find_tops
from planter.engine.solvers.problem import Problem
from planter.kernels import Array
from planter.numerics.arrays import LastCallCache


class Epigraph:
    """A `Programme` for `planter.engine.solvers.ipopt` of a problem's objective on a local model with
    fixed rows.
    """

    def __init__(self, problem: Problem, local: LocalModel, u: Array) -> None:
        self.problem, self.local = problem, local
        self.free, self.n = problem.free, len(problem.free)
        first, self.groups = local.values(problem.design(u)), local.groups
        self.ends, self.rows = len(problem.objective.weights), len(self.groups)
        first_rows = first[1 : 1 + self.rows]
        self.units, self.levels = problem.objective.units, problem.reference.summary.tops
        self.row_units, self.row_levels = self.units[self.groups], self.levels[self.groups]
        self.weights = problem.objective.weights * self.units
        free = np.full(self.ends, np.inf)
        self.lower = np.append(problem.box.bottom[self.free], -free)
        self.upper = np.append(problem.box.top[self.free], free)
        self.g_lower = np.append(np.full(self.rows, -np.inf), local.bounds[0])
        self.g_upper = np.append(np.zeros(self.rows), local.bounds[1])
        self.start = np.append(
            u[self.free], (find_tops(first_rows, self.groups, self.ends) - self.levels) / self.units
        )
        self._values = LastCallCache(lambda z: local.values(self.design(z)))

    def point(self, z: Array) -> Array:
        """The point u (p,)."""
        return self.problem.point(z[: self.n])

    def tops(self, z: Array, more: float = 0.0) -> Array:
        """Return t in the unit of the rows (g,), greater by `more` of their unit."""
        return self.levels + self.units * (z[self.n :] + more)

    def design(self, z: Array) -> Array:
        """Return the design x (p,) of variables z (n,)."""
        return self.problem.design(self.point(z))

    def f(self, z: Array) -> float:
        """Return the objective at z (n,)."""
        self.problem.counts.objective += 1
        self.problem.record(self.point(z), self.local.summarise(self.design(z)))
        level = float(self.problem.objective.weights @ self.levels)
        return (
            level + float(self.weights @ z[self.n :]) + float(self._values(z)[0])
        ) / self.problem.scale

    def gradient(self, z: Array) -> Array:
        """Return the gradient (n,) of the objective at z (n,)."""
        self.problem.counts.gradient += 1
        smooth = self._scaled(self.local.slopes(self.design(z))[0])
        return np.append(smooth, self.weights) / self.problem.scale

    def g(self, z: Array) -> Array:
        """Return the constraints (m,) at z (n,)."""
        values = self._values(z)
        rows, holds = np.split(values[1:], [self.rows])
        rows = (rows - self.row_levels) / self.row_units - z[self.n :][self.groups]
        return np.append(rows, holds)

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""
        slopes = self._scaled(self.local.slopes(self.design(z))[1:])
        slopes[: self.rows] /= self.row_units[:, None]
        jacobian = np.hstack([slopes, np.zeros((len(slopes), self.ends))])
        jacobian[np.arange(self.rows), self.n + self.groups] = -1
        return jacobian

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""
        self.problem.counts.hessian += 1
        width = self.problem.box.unit
        rows, holds = np.split(multipliers, [self.rows])
        weights = np.concatenate([[weight / self.problem.scale], rows / self.row_units, holds])
        curvature = self.local.curvature(self.design(z), weights) * np.outer(width, width)
        total = np.zeros((len(z), len(z)))
        total[: self.n, : self.n] = curvature[np.ix_(self.free, self.free)]
        return total

    def _scaled(self, slopes: Array) -> Array:
        """Derivatives in the free coordinates from derivatives in x."""
        scaled: Array = (slopes * self.problem.box.unit)[..., self.free]
        return scaled
