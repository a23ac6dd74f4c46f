"""Robust designs: the mean plus k standard deviations of an objective over machines within
tolerances.

The machines are sampled once, so that the sum is a function of the design alone. Of objectives J_i
with gradients G_i,

    f = mean J + k s,   f' = mean G + k / (n s) sum (J_i - mean J) G_i,   s^2 = 1/n sum (J_i - mean
    J)^2,

where an extreme stays at its sample, as in every gradient of a sampled objective: slopes of true
extremes of so many machines would take seconds a step. Local searches start at the design of the
file and at random designs; limits are those of the nominal design, without deviations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize

from planter.engine.machine import Machine
from planter.engine.outputs import OBJECTIVE, SampledOutputs
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE, Constraints
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import LastCallCache
from planter.numerics.latin_hypercube import draw_latin_hypercube
from planter.numerics.statistics import Statistic
from planter.progress import Listener, ProgressPhase
from planter.rows.points import SobolSequence, Spread
from planter.rows.results import RobustFound

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


class Moments(NamedTuple):
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
        self.fixed_count = len(fixed)
        self.deviations = np.zeros((settings.machines, len(moved) + len(fixed)))
        # the machines are those of a Sobol' sequence, in the order of the tolerances
        cube = np.empty((settings.machines, 0))
        if spreads:
            cube = SobolSequence(len(spreads), settings.seed)(0, settings.machines)
        for shares, (path, spread) in zip(cube.T, spreads.items(), strict=True):
            column = [*moved, *fixed].index(path)
            deviations = spread.from_unit(shares) - (spread.centre if path in moved else 0.0)
            self.deviations[:, column] = deviations * self.outputs.machine.scale[column]
        self.at = LastCallCache(self._moments)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Return the objective (m,) of each machine, and its gradients (m, p).

        Raises ComputationError without one.
        """
        designs = self.deviations + np.concatenate([x, np.zeros(self.fixed_count)])
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
        mean, std = float(values.mean()), Statistic("std", values)
        has_slope = std.value > ROUNDING * abs(mean)
        std_slope = std.gradient(slopes) if has_slope else np.zeros(len(x))
        return Moments(mean, std.value, slopes.mean(axis=0), std_slope)

    def value(self, x: Array, sigmas: float) -> tuple[float, Array]:
        """Return mean plus `sigmas` standard deviations at x, with gradient (p,) [1/SI]."""
        at = self.at(x)
        return at.mean + sigmas * at.std, at.mean_slope + sigmas * at.std_slope


def find_robust(robust: RobustGoal, settings: Settings, progress: Listener | None) -> RobustFound:
    """Return the best design within the bounds of all local searches.

    Raises ComputationError if none satisfies the limits, or if the design of the file has no
    objective.
    """
    search = _Search(robust, settings.sigmas)
    generator = np.random.default_rng(settings.seed)
    random = draw_latin_hypercube(settings.starts, len(search.initial), generator)
    starts = [search.initial, *random]
    phase = ProgressPhase("robust design", "descent", len(starts), progress)
    ends = [search.descend(start, phase) for start in starts]
    best = min(filter(search.is_feasible, ends), key=lambda u: search.value(u)[0], default=None)
    if best is None:
        raise ComputationError(
            "no robust design satisfies the requirements; relax a requirement or widen the bounds"
        )
    x = search.design(best)
    at = robust.at(x)
    return RobustFound(
        design=robust.to_display(x),
        objective=search.value(best)[0],
        mean=at.mean,
        std=at.std,
        own_objective=robust.value(robust.design, settings.sigmas)[0],
        samples=robust.samples if robust.machine.motion is None else None,
        sigmas=settings.sigmas,
        machines=settings.machines,
        starts=len(starts),
    )


class _Search:
    """Local searches of mean plus `sigmas` standard deviations within the bounds, in shares u (p,)
    of their width.
    """

    def __init__(self, robust: RobustGoal, sigmas: float) -> None:
        self.robust, self.sigmas = robust, sigmas
        self.width = robust.upper - robust.lower
        self.initial = np.clip((robust.design - robust.lower) / self.width, 0, 1)
        self.scale = abs(robust.value(robust.design, sigmas)[0]) or 1.0

    def design(self, u: Array) -> Array:
        """Return the design x (p,) [SI] at a point."""
        return self.robust.lower + u * self.width

    def value(self, u: Array) -> tuple[float, Array]:
        """Return the objective at a point, and its gradient (p,) in the shares."""
        try:
            value, slope = self.robust.value(self.design(u), self.sigmas)
        except ComputationError:
            return REFUSED * self.scale, np.zeros(len(u))
        return value, slope * self.width

    def descend(self, start: Array, phase: ProgressPhase) -> Array:
        """Return the end of a local search from a point, or the point if that is better."""

        def scaled(u: Array) -> tuple[float, Array]:
            value, slope = self.value(np.clip(u, 0, 1))
            return value / self.scale, slope / self.scale

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
        is_better = self.value(end)[0] <= self.value(start)[0]
        return end if is_better or not self.is_feasible(start) else start

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
