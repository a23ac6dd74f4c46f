"""An objective as a smooth programme: epigraph form where it has rows.

Over z = (u of the free parameters, t_max, t_min), with the rows measured from a reference level in units of the range:

    minimise  weight (t_max - t_min) + outer(smooth(u))
    subject to  upper rows(u) <= t_max,  lower rows(u) >= t_min,  holds(u) in their bounds,  u in the box.

Where there are no rows there are no t_max and t_min either: z = u.
"""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import LastCallCache
from planter.optimise.conditions import Local, Values
from planter.optimise.problem import Problem


class Epigraph:
    """A `Programme` for `planter.optimise.ipopt` of a problem's objective on a local model with fixed rows."""

    def __init__(self, problem: Problem, local: Local, u: Array) -> None:
        self.problem, self.local = problem, local
        self.free, self.n = problem.free, len(problem.free)
        first = local.values(problem.design(u))
        self.a, self.b, self.k = len(first.upper), len(first.lower), len(first.holds)
        self.ends = 2 if self.a + self.b else 0
        look = problem.reference.look
        self.unit, self.level = (look.range or 1.0, look.mean) if self.ends else (1.0, 0.0)
        free = np.full(self.ends, np.inf)
        self.lower = np.append(problem.box.bottom[self.free], -free)
        self.upper = np.append(problem.box.top[self.free], free)
        self.g_lower = np.append(np.full(self.a + self.b, -np.inf), local.bounds[0])
        self.g_upper = np.append(np.zeros(self.a + self.b), local.bounds[1])
        self.start = np.append(u[self.free], self._ends(first))
        self._values = LastCallCache(lambda z: local.values(self.design(z)))

    def _ends(self, found: Values) -> Array:
        """t_max and t_min of the rows."""
        if not self.ends:
            return np.empty(0)
        return (np.array([found.upper.max(), found.lower.min()]) - self.level) / self.unit

    def point(self, z: Array) -> Array:
        """The point u (p,)."""
        return self.problem.point(z[: self.n])

    def limits(self, z: Array, more: float = 0.0) -> tuple[float, float]:
        """t_max and t_min in the unit of the rows, both wider by `more` of the range; no limits without rows."""
        if not self.ends:
            return np.inf, -np.inf
        return self.level + self.unit * (float(z[-2]) + more), self.level + self.unit * (float(z[-1]) - more)

    def design(self, z: Array) -> Array:
        return self.problem.design(self.point(z))

    def f(self, z: Array) -> float:
        self.problem.counts.objective += 1
        objective = self.problem.objective
        self.problem.met(self.point(z), self.local.look(self.design(z)))
        span = self.unit * (z[-2] - z[-1]) if self.ends else 0.0
        return float(objective.weight * span + objective.outer(self._values(z).smooth)[0]) / self.problem.scale

    def gradient(self, z: Array) -> Array:
        self.problem.counts.gradient += 1
        objective = self.problem.objective
        rate = objective.outer(self._values(z).smooth)[1]
        along = rate * self._scaled(self.local.slopes(self.design(z)).smooth)
        ends = objective.weight * self.unit * np.array([1.0, -1.0])
        return np.append(along, ends[: self.ends]) / self.problem.scale

    def g(self, z: Array) -> Array:
        found = self._values(z)
        if not self.ends:
            return found.holds
        upper = (found.upper - self.level) / self.unit - z[-2]
        lower = z[-1] - (found.lower - self.level) / self.unit
        return np.concatenate([upper, lower, found.holds])

    def jacobian(self, z: Array) -> Array:
        slopes = self.local.slopes(self.design(z))
        if not self.ends:
            return self._scaled(slopes.holds)
        rows = np.zeros((self.a + self.b + self.k, self.n + 2))
        parts = np.split(rows, [self.a, self.a + self.b])
        parts[0][:, :-2], parts[0][:, -2] = self._scaled(slopes.upper) / self.unit, -1
        parts[1][:, :-2], parts[1][:, -1] = -self._scaled(slopes.lower) / self.unit, 1
        parts[2][:, :-2] = self._scaled(slopes.holds)
        return rows

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        self.problem.counts.hessian += 1
        x, width = self.design(z), self.problem.box.unit
        _, first, second = self.problem.objective.outer(self._values(z).smooth)
        upper, lower, holds = np.split(multipliers, [self.a, self.a + self.b])
        share = weight / self.problem.scale
        weights = Values(share * first, upper / self.unit, -lower / self.unit, holds)
        bent = self.local.curvature(x, weights)
        along = self.local.slopes(x).smooth
        bent = (bent + share * second * np.outer(along, along)) * np.outer(width, width)
        total = np.zeros((len(z), len(z)))
        total[: self.n, : self.n] = bent[np.ix_(self.free, self.free)]
        return total

    def _scaled(self, slopes: Array) -> Array:
        """Derivatives in the free coordinates from derivatives in x."""
        scaled: Array = (slopes * self.problem.box.unit)[..., self.free]
        return scaled
