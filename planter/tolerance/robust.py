"""Robust designs: the mean plus k standard deviations of an objective over machines within
tolerances.

The machines are sampled once, so that the sum is a function of the design alone. Of objectives J_i
with gradients G_i,

    f = mean J + k s,   f' = mean G + k / (n s) sum (J_i - mean J) G_i,   s^2 = 1/n sum (J_i - mean
    J)^2,

where an extreme stays at its sample, as in every gradient of a sampled objective. Local searches
start at the design of the file, at the nominal optimum and at random designs; limits are those of
the nominal design, without deviations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from planter.engine.machine import Machine
from planter.engine.outputs import OBJECTIVE, SampledOutputs
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import LastCallCache
from planter.optimise.constraints import FEASIBILITY_TOLERANCE, Constraints
from planter.progress import Listener, ProgressPhase
from planter.sweeps.plan import SobolSequence
from planter.tolerance.job import Spread
from planter.tolerance.results import RobustFound, Scored

ROUNDING = 1e-12
"""Share of the mean below which a standard deviation is rounding and has no slope."""
ITERATIONS = 60
"""Maximum number of steps of a local search."""
PRECISION = 1e-9
"""Change of the objective, relative to that of the design of the file, at which a local search
ends.
"""
REFUSED = 1e3
"""Objective of a design without a cycle, relative to that of the file: steps to such a design are
shortened.
"""
THREADS = 4
"""Number of threads that evaluate the machines."""
NOMINAL = None
"""Number of standard deviations that stands for the objective without tolerances."""


@dataclass(frozen=True)
class Settings:
    """Settings of a robust design: standard deviations added to the mean, random machines, starts,
    a seed.

    `sum_text` replaces the sum of the machine file, `holds` are further limits, `ranges` the bounds
    of further design variables, by path, in display units.
    """

    sigmas: float = 3.0
    machines: int = 128
    starts: int = 2
    seed: int = 0
    sum_text: str | None = None
    holds: tuple[str, ...] = ()
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def is_stated(self) -> bool:
        """Return whether options, not the file alone, define the search."""
        return self.sum_text is not None or bool(self.holds or self.ranges)


@dataclass(frozen=True)
class Moments:
    """Mean and standard deviation of the objective over the machines, and their gradients (p,) in
    the design [1/SI].
    """

    mean: float
    std: float
    mean_slope: Array
    std_slope: Array


class RobustGoal:
    """Objective of a machine over a fixed sample of machines, as a function of its design variables
    x (p,) [SI].

    `design`, `lower` and `upper` (p,) are the design and its bounds, `limits` its constraints; the
    objective is evaluated at `samples` angles of a cycle. `spreads` are distributions of values by
    path, about the design if it has them.
    """

    def __init__(
        self,
        machine: Machine,
        spreads: Mapping[str, Spread],
        settings: Settings,
        samples: int,
        limits: Constraints | None = None,
    ) -> None:
        self.machine, self.samples, self.limits = machine, samples, limits
        self.design, self.lower, self.upper = machine.design, machine.lower, machine.upper
        moved = [machine.values[index].path for index in machine.moved]
        fixed = [path for path in spreads if path not in moved]
        self.outputs = SampledOutputs(machine, [*moved, *fixed], [OBJECTIVE], samples)
        self._rest = self.outputs.machine.design[len(moved) :]
        samples_by_path = sample_inputs(spreads, settings)
        self.deviations = np.zeros((settings.machines, len(moved) + len(fixed)))
        for column, path in enumerate([*moved, *fixed]):
            if path in samples_by_path:
                centre = spreads[path].centre if path in moved else 0.0
                self.deviations[:, column] = (
                    samples_by_path[path] - centre
                ) * self.outputs.machine.scale[column]
        self.at = LastCallCache(self._moments)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Return the objective (m,) of each machine, and its gradients (m, p).

        Raises ComputationError without one.
        """
        return self._differentiate(self.deviations + np.concatenate([x, np.zeros_like(self._rest)]))

    def nominal(self, x: Array) -> tuple[float, Array]:
        """Return the objective without tolerances, and its gradient (p,).

        Raises ComputationError without one.
        """
        values, slopes = self._differentiate(np.concatenate([x, self._rest])[None])
        return float(values[0]), slopes[0]

    def _differentiate(self, designs: Array) -> tuple[Array, Array]:
        points = designs / self.outputs.machine.scale
        values, slopes = self.outputs.gradients(points, THREADS)
        failed = np.flatnonzero(np.isnan(slopes).any(axis=(1, 2)))
        if len(failed):
            raise ComputationError(self.outputs.find_reason(points[failed[0]]))
        return values[:, 0], (slopes[:, 0] / self.outputs.machine.scale)[:, : len(self.design)]

    def to_display(self, x: Array) -> dict[str, float]:
        """Return a design by the names of the file, in its units."""
        names = self.machine.design_names
        return {
            name: float(value) for name, value in zip(names, x / self.machine.scale, strict=True)
        }

    def _moments(self, x: Array) -> Moments:
        values, slopes = self.evaluate(x)
        mean, std = float(values.mean()), float(values.std())
        has_slope = std > ROUNDING * abs(mean)
        deviations = (values - mean) / len(values)
        std_slope = deviations @ slopes / std if has_slope else np.zeros(len(x))
        return Moments(mean, std, slopes.mean(axis=0), std_slope)

    def value(self, x: Array, sigmas: float | None) -> tuple[float, Array]:
        """Return mean plus `sigmas` standard deviations at x, or the nominal objective, with
        gradient (p,) [1/SI].
        """
        if sigmas is NOMINAL:
            return self.nominal(x)
        at = self.at(x)
        return at.mean + sigmas * at.std, at.mean_slope + sigmas * at.std_slope

    def score(self, x: Array, sigmas: float) -> Scored:
        """Return a design with its objectives, for results."""
        at = self.at(x)
        return Scored(
            self.to_display(x), self.nominal(x)[0], at.mean, at.std, at.mean + sigmas * at.std
        )


def sample_inputs(spreads: Mapping[str, Spread], settings: Settings) -> dict[str, Array]:
    """Return values (m,) of each input: points of a Sobol' sequence, scaled to the
    distributions.
    """
    if not spreads:
        return {}
    cube = SobolSequence(len(spreads), settings.seed)(0, settings.machines)
    return {
        name: spread.quantiles(shares)
        for (name, spread), shares in zip(spreads.items(), cube.T, strict=True)
    }


def find_robust(robust: RobustGoal, settings: Settings, progress: Listener | None) -> RobustFound:
    """Return the best design within the bounds of all local searches.

    Raises ComputationError if none satisfies the limits, or if the design of the file has no
    objective.
    """
    search, sigmas = _Search(robust), settings.sigmas
    starts = [search.initial, *search.random_starts(settings)]
    phase = ProgressPhase("robust design", "descent", 2 * len(starts) + 2, progress)

    def descend(points: Sequence[Array], deviations: float | None) -> list[Array]:
        return [search.descend(start, deviations, phase) for start in points]

    ends = descend(starts, NOMINAL)
    ends += descend([*starts, search.best(ends, NOMINAL)], sigmas)
    ends += descend([search.best(ends, sigmas)], NOMINAL)
    nominal, best = search.best(ends, NOMINAL), search.best(ends, sigmas)
    if not search.is_feasible(best):
        raise ComputationError(
            "no robust design satisfies the requirements; relax a requirement or widen the bounds"
        )
    score = robust.score(search.design(best), sigmas)
    return RobustFound(
        design=score.design,
        objective=score.robust,
        samples=robust.samples,
        sigmas=sigmas,
        machines=settings.machines,
        starts=len(starts) + 1,
        residual=search.residual(best, sigmas),
        own=robust.score(robust.design, sigmas),
        best_nominal=robust.score(search.design(nominal), sigmas),
        best_robust=score,
    )


class _Search:
    """Local searches within the bounds, in shares u (p,) of their width."""

    def __init__(self, robust: RobustGoal) -> None:
        self.robust = robust
        self.width = robust.upper - robust.lower
        self.initial = np.clip((robust.design - robust.lower) / self.width, 0, 1)
        robust.at(robust.design)
        self.scale = abs(robust.nominal(robust.design)[0]) or 1.0

    def design(self, u: Array) -> Array:
        """Return the design x (p,) [SI] at a point."""
        return self.robust.lower + u * self.width

    def random_starts(self, settings: Settings) -> Array:
        """Return random initial points, (n, p)."""
        generator = np.random.default_rng(settings.seed)
        cube: Array = scipy.stats.qmc.LatinHypercube(len(self.initial), rng=generator).random(
            settings.starts
        )
        return cube

    def value(self, u: Array, sigmas: float | None) -> tuple[float, Array]:
        """Return the objective at a point, and its gradient (p,) in the shares."""
        try:
            value, slope = self.robust.value(self.design(u), sigmas)
        except ComputationError:
            return REFUSED * self.scale, np.zeros(len(u))
        return value, slope * self.width

    def descend(self, start: Array, sigmas: float | None, phase: ProgressPhase) -> Array:
        """Return the end of a local search from a point."""
        scale = abs(self.value(self.initial, sigmas)[0]) or 1.0

        def scaled(u: Array) -> tuple[float, Array]:
            value, slope = self.value(np.clip(u, 0, 1), sigmas)
            return value / scale, slope / scale

        result = scipy.optimize.minimize(
            scaled,
            start,
            jac=True,
            method="SLSQP",
            bounds=[(0, 1)] * len(start),
            constraints=self._constraints,
            options={"maxiter": ITERATIONS, "ftol": PRECISION},
        )
        phase.advance()
        end: Array = np.clip(result.x, 0, 1)
        return (
            end
            if self.value(end, sigmas)[0] <= self.value(start, sigmas)[0]
            or not self.is_feasible(start)
            else start
        )

    def best(self, points: Sequence[Array], sigmas: float | None) -> Array:
        """Return the best of some points that satisfy the limits; the first if none does."""
        return min(
            filter(self.is_feasible, points),
            key=lambda u: self.value(u, sigmas)[0],
            default=points[0],
        )

    def is_feasible(self, u: Array) -> bool:
        """Return whether a point satisfies the limits."""
        limits = self.robust.limits
        try:
            return limits is None or limits.violation(self.design(u)) <= FEASIBILITY_TOLERANCE
        except ComputationError:
            return False

    @cached_property
    def _constraints(self) -> list[dict[str, Any]]:
        """Limits in the form of SciPy: components that must not be negative."""
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
        """Return the largest projected slope relative to the value; active limits are not
        subtracted.
        """
        value, slope = self.value(u, sigmas)
        step = np.clip(u - slope, 0, 1) - u
        return float(np.abs(np.where(np.abs(step) > 0, slope, 0.0)).max() / (abs(value) or 1.0))
