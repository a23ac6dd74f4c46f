"""The search for a robust design: descents with exact gradients from the own design, the nominal optimum and others.

Requirements, if the file has any, are those of the design that is meant, without deviations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.constraints import KEPT
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.requirements.constraints import Required
from planter.planting.swept.robust import Robust
from planter.progress import Listener, Phase
from planter.tolerance.results import RobustFound
from planter.tolerance.room import Settings
from planter.tolerance.spread import Spread

ITERATIONS = 60
"""Most steps of a descent."""
PRECISION = 1e-9
"""Change of the objective, over that of the own design, at which a descent ends."""
NOMINAL = None
"""Instead of a number of standard deviations: the objective without tolerances."""


def optimum(
    machine: Machine, model: Model, spreads: Mapping[str, Spread], settings: Settings, progress: Listener | None
) -> RobustFound:
    """The best design within the file's bounds that any of the descents ends at.

    Raises ComputationError where none keeps the requirements.
    """
    robust, sigmas = Robust(machine, model, spreads, settings), settings.sigmas
    search = _Search(robust)
    starts = [search.own, *search.others(settings)]
    phase = Phase("robust design", "descent", 2 * len(starts) + 2, progress)

    def descended(points: Sequence[Array], wanted: float | None) -> list[Array]:
        return [search.descended(start, wanted, phase) for start in points]

    ends = descended(starts, NOMINAL)
    ends += descended([*starts, search.best(ends, NOMINAL)], sigmas)
    ends += descended([search.best(ends, sigmas)], NOMINAL)
    nominal, best = search.best(ends, NOMINAL), search.best(ends, sigmas)
    if not search.keeps(best):
        raise ComputationError("no robust design was found that keeps the requirements")
    found = robust.scored(search.design(best), sigmas)
    return RobustFound(
        design=found.design, objective=found.robust, samples=robust.turns.samples, sigmas=sigmas,
        machines=settings.machines, starts=len(starts) + 1, residual=search.residual(best, sigmas),
        own=robust.scored(robust.device.design, sigmas),
        best_nominal=robust.scored(search.design(nominal), sigmas), best_robust=found,
    )  # fmt: skip


class _Search:
    """Descents within the box, in shares u (p,) of its width."""

    def __init__(self, robust: Robust) -> None:
        self.robust, self.device = robust, robust.device
        self.width = self.device.upper - self.device.lower
        self.required = Required.of(self.device)
        self.own = np.clip((self.device.design - self.device.lower) / self.width, 0, 1)

    def design(self, u: Array) -> Array:
        """The design x (p,) [SI] at a point."""
        return self.device.lower + u * self.width

    def others(self, settings: Settings) -> Array:
        """More points to start from, (n, p)."""
        cube: Array = qmc.LatinHypercube(len(self.own), rng=np.random.default_rng(settings.seed)).random(
            settings.starts
        )
        return cube

    def value(self, u: Array, sigmas: float | None) -> tuple[float, Array]:
        """What is made small at a point, and its gradient in the shares."""
        x = self.design(u)
        value, slope = self.robust.turns.gradient(x) if sigmas is NOMINAL else self.robust.value(x, sigmas)
        return value, slope * self.width

    def descended(self, start: Array, sigmas: float | None, phase: Phase) -> Array:
        """Where a descent from a point ends."""
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
        """Of some points the best that keeps the requirements; the first where none does."""
        return min(filter(self.keeps, points), key=lambda u: self.value(u, sigmas)[0], default=points[0])

    def keeps(self, u: Array) -> bool:
        """Whether a point keeps the requirements."""
        return self.required is None or self.required.violation(self.design(u)) <= KEPT

    @cached_property
    def _constraints(self) -> list[dict[str, Any]]:
        """The requirements as SciPy takes them: rows that must not be negative."""
        required = self.required
        if required is None:
            return []
        above, below = np.isfinite(required.lower), np.isfinite(required.upper)

        def rows(u: Array) -> Array:
            values = required.values(self.design(np.clip(u, 0, 1)))
            return np.concatenate([(values - required.lower)[above], (required.upper - values)[below]])

        def slopes(u: Array) -> Array:
            found = required.slopes(self.design(np.clip(u, 0, 1))) * self.width
            return np.vstack([found[above], -found[below]])

        return [{"type": "ineq", "fun": rows, "jac": slopes}]

    def residual(self, u: Array, sigmas: float) -> float:
        """The largest slope that is left within the box, relative to the value; with requirements those count too."""
        value, slope = self.value(u, sigmas)
        step = np.clip(u - slope, 0, 1) - u
        return float(np.abs(np.where(np.abs(step) > 0, slope, 0.0)).max() / (abs(value) or 1.0))
