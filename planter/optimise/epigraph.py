"""The minimax objective as a smooth programme: epigraph form.

Over z = (u of the free parameters, t_max, t_min), with the force measured from a reference level in units of the range:

    minimise  weight_range (t_max - t_min) + spread(variance(u))
    subject to  upper rows(u) <= t_max,  lower rows(u) >= t_min,  holds(u) in their bounds,  u in [0, 1].
"""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.optimise.conditions import Local, Values
from planter.optimise.problem import Problem


class Epigraph:
    """A `Programme` for `planter.optimise.ipopt` of a problem's objective on a local model with fixed rows."""

    def __init__(self, problem: Problem, local: Local, u: Array) -> None:
        self.problem, self.local = problem, local
        self.free, self.n = problem.free, len(problem.free)
        self.unit, self.level = problem.reference.range_N or 1.0, problem.reference.mean_N
        first = local.values(problem.design(u))
        self.a, self.b, self.k = len(first.upper), len(first.lower), len(first.holds)
        self.lower = np.append(np.zeros(self.n), [-np.inf, -np.inf])
        self.upper = np.append(np.ones(self.n), [np.inf, np.inf])
        self.g_lower = np.append(np.full(self.a + self.b, -np.inf), local.bounds[0])
        self.g_upper = np.append(np.zeros(self.a + self.b), local.bounds[1])
        ends = (np.array([first.upper.max(), first.lower.min()]) - self.level) / self.unit
        self.start = np.append(u[self.free], ends)

    def design(self, z: Array) -> Array:
        return self.problem.design(self.problem.point(z[:-2]))

    def _values(self, z: Array) -> Values:
        return self.local.values(self.design(z))

    def f(self, z: Array) -> float:
        objective = self.problem.objective
        self.problem.counts.objective += 1
        self.problem.met(self.problem.point(z[:-2]), self.local.look(self.design(z)))
        span = self.unit * (z[-2] - z[-1])
        return objective.value(span, self._values(z).variance) / self.problem.scale

    def gradient(self, z: Array) -> Array:
        self.problem.counts.gradient += 1
        objective = self.problem.objective
        rate = objective.spread(self._values(z).variance)[1]
        along = rate * self._scaled(self.local.slopes(self.design(z)).variance)
        ends = objective.weight_range * self.unit * np.array([1.0, -1.0])
        return np.append(along, ends) / self.problem.scale

    def g(self, z: Array) -> Array:
        found = self._values(z)
        upper = (found.upper - self.level) / self.unit - z[-2]
        lower = z[-1] - (found.lower - self.level) / self.unit
        return np.concatenate([upper, lower, found.holds])

    def jacobian(self, z: Array) -> Array:
        slopes = self.local.slopes(self.design(z))
        rows = np.zeros((self.a + self.b + self.k, self.n + 2))
        parts = np.split(rows, [self.a, self.a + self.b])
        parts[0][:, :-2], parts[0][:, -2] = self._scaled(slopes.upper) / self.unit, -1
        parts[1][:, :-2], parts[1][:, -1] = -self._scaled(slopes.lower) / self.unit, 1
        parts[2][:, :-2] = self._scaled(slopes.holds)
        return rows

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        self.problem.counts.hessian += 1
        x = self.design(z)
        _, first, second = self.problem.objective.spread(self._values(z).variance)
        upper, lower, holds = np.split(multipliers, [self.a, self.a + self.b])
        share = weight / self.problem.scale
        weights = Values(share * first, upper / self.unit, -lower / self.unit, holds)
        bent = self.local.curvature(x, weights)
        along = self.local.slopes(x).variance
        bent = (bent + share * second * np.outer(along, along)) * np.outer(self.problem.width, self.problem.width)
        total = np.zeros((self.n + 2, self.n + 2))
        total[: self.n, : self.n] = bent[np.ix_(self.free, self.free)]
        return total

    def _scaled(self, slopes: Array) -> Array:
        """Derivatives in the free coordinates from derivatives in x."""
        scaled: Array = (slopes * self.problem.width)[..., self.free]
        return scaled
