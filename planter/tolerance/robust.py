"""Robust designs: the mean plus k standard deviations of an objective over machines as their tolerances make them.

The machines are drawn once, so that the sum is a function of the design alone. Of objectives J_i with gradients G_i,

    f = mean J + k s,   f' = mean G + k / (n s) sum (J_i - mean J) G_i,   s^2 = 1/n sum (J_i - mean J)^2,

where an extreme stays at its sample, as in every gradient of a sampled objective. The search descends from the own
design, the nominal optimum and others; limits are those of the design that is meant, without deviations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from planter.engine.goal import Goal, GoalConstraints
from planter.engine.machine import Machine
from planter.engine.outputs import OBJECTIVE, SampledOutputs
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.numerics.latest import Latest
from planter.optimise.constraints import KEPT, Constraints, Kind
from planter.optimise.spread import Variance
from planter.progress import Listener, Phase
from planter.sweeps.points import SobolSequence
from planter.tolerance.results import RobustFound, Scored
from planter.tolerance.room import Settings
from planter.tolerance.spread import Spread

ROUNDING = 1e-12
"""Share of the mean below which machines differ by rounding alone: their deviation has no slope then."""
ITERATIONS = 60
"""Most steps of a descent."""
PRECISION = 1e-9
"""Change of the objective, over that of the own design, at which a descent ends."""
REFUSED = 1e3
"""What a design without a cycle counts as, in objectives of the own design: steps that lead there are shortened."""
THREADS = 4
"""Threads that evaluate the machines."""
NOMINAL = None
"""Instead of a number of standard deviations: the objective without tolerances."""


@dataclass(frozen=True)
class Moments:
    """Mean and standard deviation of the objective over the machines, and their gradients (p,) in the design [1/SI]."""

    mean: float
    std: float
    mean_slope: Array
    std_slope: Array


class RobustGoal:
    """A machine's objective over machines that are drawn once, as a function of its moved values x (p,) [SI].

    `design` (p,) is the machine's, `lower` and `upper` (p,) are its bounds, `limits` what it has to satisfy; the
    objective is one over `samples` of a cycle. `spreads` are those of values by path; those of the design move with it.
    """

    def __init__(
        self, machine: Machine, spreads: Mapping[str, Spread], settings: Settings, samples: int,
        limits: Constraints | None = None,
    ) -> None:  # fmt: skip
        self.machine, self.samples, self.limits = machine, samples, limits
        self.design, self.lower, self.upper = machine.design, machine.lower, machine.upper
        moved = [machine.values[index].path for index in machine.moved]
        others = [path for path in spreads if path not in moved]
        self.outputs = SampledOutputs(machine, [*moved, *others], [OBJECTIVE], samples)
        self._rest = self.outputs.machine.design[len(moved) :]
        drawn = draw_inputs(spreads, settings)
        self.apart = np.zeros((settings.machines, len(moved) + len(others)))
        for column, path in enumerate([*moved, *others]):
            if path in drawn:
                centre = spreads[path].centre if path in moved else 0.0
                self.apart[:, column] = (drawn[path] - centre) * self.outputs.machine.scale[column]
        self.at = Latest(self._moments)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Return the objective (m,) of each machine, and its gradients (m, p). Raises ComputationError without one."""
        return self._differentiate(self.apart + np.concatenate([x, np.zeros_like(self._rest)]))

    def nominal(self, x: Array) -> tuple[float, Array]:
        """Return the objective without tolerances, and its gradient (p,). Raises ComputationError without one."""
        values, slopes = self._differentiate(np.concatenate([x, self._rest])[None])
        return float(values[0]), slopes[0]

    def _differentiate(self, designs: Array) -> tuple[Array, Array]:
        points = designs / self.outputs.machine.scale
        values, slopes = self.outputs.gradients(points, THREADS)
        failed = np.flatnonzero(np.isnan(slopes).any(axis=(1, 2)))
        if len(failed):
            raise ComputationError(self.outputs.find_reason(points[failed[0]]))
        return values[:, 0], (slopes[:, 0] / self.outputs.machine.scale)[:, : len(self.design)]

    def named(self, x: Array) -> dict[str, float]:
        """Return a design by the names of the file, in its units."""
        names = self.machine.design_names
        return {name: float(value) for name, value in zip(names, x / self.machine.scale, strict=True)}

    def _moments(self, x: Array) -> Moments:
        values, slopes = self.evaluate(x)
        variance = Variance(values)
        std = float(np.sqrt(variance.value))
        has_slope = std > ROUNDING * abs(variance.mean)
        std_slope = variance.gradient(slopes) / (2 * std) if has_slope else np.zeros(len(x))
        return Moments(variance.mean, std, slopes.mean(axis=0), std_slope)

    def value(self, x: Array, sigmas: float | None) -> tuple[float, Array]:
        """Return mean plus so many standard deviations at x, or the nominal objective, and the gradient (p,) [1/SI]."""
        if sigmas is NOMINAL:
            return self.nominal(x)
        at = self.at(x)
        return at.mean + sigmas * at.std, at.mean_slope + sigmas * at.std_slope

    def score(self, x: Array, sigmas: float) -> Scored:
        """Return a design as results show it."""
        at = self.at(x)
        return Scored(self.named(x), self.nominal(x)[0], at.mean, at.std, at.mean + sigmas * at.std)


def draw_inputs(spreads: Mapping[str, Spread], settings: Settings) -> dict[str, Array]:
    """Return values (m,) of each input: points of a Sobol' sequence, spread out."""
    if not spreads:
        return {}
    cube = SobolSequence(len(spreads), settings.seed)(0, settings.machines)
    return {name: one.at(shares) for (name, one), shares in zip(spreads.items(), cube.T, strict=True)}


def find_robust(robust: RobustGoal, settings: Settings, progress: Listener | None) -> RobustFound:
    """Return the best design within the bounds that any of the descents ends at.

    Raises ComputationError if none satisfies the limits, or if the own design has no objective.
    """
    search, sigmas = _Search(robust), settings.sigmas
    starts = [search.own, *search.others(settings)]
    phase = Phase("robust design", "descent", 2 * len(starts) + 2, progress)

    def descend(points: Sequence[Array], deviations: float | None) -> list[Array]:
        return [search.descend(start, deviations, phase) for start in points]

    ends = descend(starts, NOMINAL)
    ends += descend([*starts, search.best(ends, NOMINAL)], sigmas)
    ends += descend([search.best(ends, sigmas)], NOMINAL)
    nominal, best = search.best(ends, NOMINAL), search.best(ends, sigmas)
    if not search.keeps(best):
        raise ComputationError("no robust design was found that keeps the requirements")
    score = robust.score(search.design(best), sigmas)
    return RobustFound(
        design=score.design, objective=score.robust, samples=robust.samples, sigmas=sigmas,
        machines=settings.machines, starts=len(starts) + 1, residual=search.residual(best, sigmas),
        own=robust.score(robust.design, sigmas), best_nominal=robust.score(search.design(nominal), sigmas),
        best_robust=score,
    )  # fmt: skip


class _Search:
    """Descents within the box, in shares u (p,) of its width."""

    def __init__(self, robust: RobustGoal) -> None:
        self.robust = robust
        self.width = robust.upper - robust.lower
        self.own = np.clip((robust.design - robust.lower) / self.width, 0, 1)
        robust.at(robust.design)
        self.scale = abs(robust.nominal(robust.design)[0]) or 1.0

    def design(self, u: Array) -> Array:
        """Return the design x (p,) [SI] at a point."""
        return self.robust.lower + u * self.width

    def others(self, settings: Settings) -> Array:
        """Return more points to start from, (n, p)."""
        generator = np.random.default_rng(settings.seed)
        cube: Array = qmc.LatinHypercube(len(self.own), rng=generator).random(settings.starts)
        return cube

    def value(self, u: Array, sigmas: float | None) -> tuple[float, Array]:
        """Return what is to be small at a point, and its gradient in the shares."""
        try:
            value, slope = self.robust.value(self.design(u), sigmas)
        except ComputationError:
            return REFUSED * self.scale, np.zeros(len(u))
        return value, slope * self.width

    def descend(self, start: Array, sigmas: float | None, phase: Phase) -> Array:
        """Return where a descent from a point ends."""
        scale = abs(self.value(self.own, sigmas)[0]) or 1.0

        def scaled(u: Array) -> tuple[float, Array]:
            value, slope = self.value(np.clip(u, 0, 1), sigmas)
            return value / scale, slope / scale

        found = minimize(
            scaled, start, jac=True, method="SLSQP", bounds=[(0, 1)] * len(start), constraints=self._constraints,
            options={"maxiter": ITERATIONS, "ftol": PRECISION},
        )  # fmt: skip
        phase.next()
        end: Array = np.clip(found.x, 0, 1)
        return end if self.value(end, sigmas)[0] <= self.value(start, sigmas)[0] or not self.keeps(start) else start

    def best(self, points: Sequence[Array], sigmas: float | None) -> Array:
        """Return the best of some points that satisfy the limits; the first if none does."""
        return min(filter(self.keeps, points), key=lambda u: self.value(u, sigmas)[0], default=points[0])

    def keeps(self, u: Array) -> bool:
        """Return whether a point satisfies the limits."""
        limits = self.robust.limits
        try:
            return limits is None or limits.violation(self.design(u)) <= KEPT
        except ComputationError:
            return False

    @cached_property
    def _constraints(self) -> list[dict[str, Any]]:
        """The limits as SciPy takes them: rows that must not be negative."""
        limits = self.robust.limits
        if limits is None:
            return []
        above, below = np.isfinite(limits.lower), np.isfinite(limits.upper)
        count = np.count_nonzero(above) + np.count_nonzero(below)

        def rows(u: Array) -> Array:
            try:
                values = limits.values(self.design(np.clip(u, 0, 1)))
            except ComputationError:
                return np.full(count, -REFUSED)
            return np.concatenate([(values - limits.lower)[above], (limits.upper - values)[below]])

        def slopes(u: Array) -> Array:
            try:
                slopes = limits.slopes(self.design(np.clip(u, 0, 1))) * self.width
            except ComputationError:
                return np.zeros((count, len(u)))
            return np.vstack([slopes[above], -slopes[below]])

        return [{"type": "ineq", "fun": rows, "jac": slopes}]

    def residual(self, u: Array, sigmas: float) -> float:
        """Return the largest slope that is left within the box, over the value; with limits those count too."""
        value, slope = self.value(u, sigmas)
        step = np.clip(u - slope, 0, 1) - u
        return float(np.abs(np.where(np.abs(step) > 0, slope, 0.0)).max() / (abs(value) or 1.0))


class DesignLimits(Constraints):
    """The limits of a goal as rows in the design alone, its variables as tight as they can be."""

    def __init__(self, goal: Goal) -> None:
        self.goal, self._rows = goal, GoalConstraints(goal)
        self.kinds: Sequence[Kind] = self._rows.kinds
        self.owner: Integers = self._rows.owner
        self.lower, self.upper = self._rows.lower, self._rows.upper

    def values(self, x: Array) -> Array:
        """Return the rows (k,) at a design. Raises ComputationError where there is no cycle."""
        return self._rows.values(self.goal.start(x))

    def slopes(self, x: Array) -> Array:
        """Return the gradients (k, p) of the rows; an extreme's is that of the node that has it."""
        slopes = self._rows.slopes(self.goal.start(x))
        return slopes[:, : len(x)] + slopes[:, len(x) :] @ self.goal.variable_slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the weighted sum (p, p) of the rows' Hessians."""
        return self._rows.curvature(self.goal.start(x), weights)[: len(x), : len(x)]
