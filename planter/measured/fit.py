"""Least squares from many starts, and what the data determine: rank, correlation, bands by profiles of likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import f as f_distribution

from planter.errors import ComputationError
from planter.kernels import Array
from planter.measured.curve import MeasuredCurve
from planter.measured.phase import find_phases
from planter.parallel.jobs import run_in_order
from planter.parallel.task import HERE, Means, Task
from planter.progress import Phase

STARTS = 8
CANDIDATES, RESCANS, BETTER = 3, 3, 0.999
"""Phases from which a start searches, most scans after them, and the share of a sum that is worth another search."""
MOST_POINTS = 360
"""Points on which starts are compared."""
CLOSE, MOST = 1e-10, 40
"""Relative change at which a search ends, and its most evaluations."""
AGREEING = 0.01
"""Starts agree whose sums of squares differ by less than this share of the residuals' variance: the data cannot tell
them apart."""
DETERMINED = 1e-8
"""Singular values below this share of the largest are those of combinations that the data do not determine."""
LEVEL = 0.95
"""Confidence of the bands."""
AT_BOUND = 1e-9
UNEXPLAINED = 1e6
"""Sum of squares, in parts of the best, that stands for values without a cycle."""
TINY = 1e-12
"""Sum of squares [SI] that counts as none."""


@dataclass(frozen=True)
class Fit:
    """The best values (n,) in SI of the chosen inputs; `sums` are the sums of squares that all starts ended at."""

    curve: MeasuredCurve
    values: Array
    sums: tuple[float, ...]

    @cached_property
    def residuals(self) -> Array:
        """Measured less computed [SI], (m,)."""
        found: Array = self.curve.values - self.curve(self.values)[0]
        return found

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def agreeing(self) -> int:
        """Starts that ended at the same sum of squares."""
        points = min(len(self.curve.values), MOST_POINTS)
        return sum(agrees(total, min(self.sums), points) for total in self.sums)

    @property
    def is_settled(self) -> bool:
        """Whether most starts agree, so that no better fit is likely."""
        return 2 * self.agreeing > len(self.sums)

    @property
    def _widths(self) -> Array:
        found: Array = self.curve.chosen.upper - self.curve.chosen.lower
        return found

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Singular values (n,) and right singular vectors (n, n) of the Jacobian, inputs in widths of their bounds."""
        slopes = self.curve(self.values)[1] * self._widths
        _, values, rows = np.linalg.svd(slopes, full_matrices=False)
        return values, rows

    @property
    def rank(self) -> int:
        """Combinations of inputs that the data determine."""
        values, _ = self._directions
        return int((values > DETERMINED * values[0]).sum())

    def towards(self, own: Array) -> Array:
        """The values less what the data do not feel of their way from others (n,)."""
        values, rows = self._directions
        felt = rows[values > DETERMINED * values[0]]
        found: Array = own + self._widths * (felt.T @ (felt @ ((self.values - own) / self._widths)))
        return found

    def correlation(self) -> Array | None:
        """Of the inputs, (n, n); None where the data do not determine all of them."""
        if self.rank < len(self.values):
            return None
        values, rows = self._directions
        covariance = (rows.T / values**2) @ rows
        deviation = np.sqrt(np.diag(covariance))
        found: Array = covariance / np.outer(deviation, deviation)
        return found

    def band(self, index: int) -> tuple[float, float]:
        """Where the profile of the likelihood of an input passes `LEVEL`, on each side; its bound where it does not.

        The noise is assumed to be white: equal and independent at all points.
        """
        free = max(len(self.residuals) - len(self.values), 1)
        best = float(self.residuals @ self.residuals)
        allowed = best * (1 + float(f_distribution.ppf(LEVEL, 1, free)) / free) + CLOSE
        lower, upper = (float(ends[index]) for ends in self.curve.bounds(self.values))
        first = self._standard_error(index, best / free) or (upper - lower) / 8
        return self._end(index, lower, -2 * first, allowed), self._end(index, upper, 2 * first, allowed)

    def _standard_error(self, index: int, variance: float) -> float | None:
        """Of an input in the linearised curve; None if the data do not determine it."""
        values, rows = self._directions
        share = np.abs(rows[:, index])
        if (share[values <= DETERMINED * values[0]] > DETERMINED).any():
            return None
        some = values > DETERMINED * values[0]
        return float(np.sqrt(variance * ((share[some] / values[some]) ** 2).sum()) * self._widths[index])

    def _end(self, index: int, bound: float, step: float, allowed: float) -> float:
        """The end of a band towards a bound: the first crossing on a way of growing steps, which no far basin hides."""
        near, value = float(self.values[index]), float(self.values[index])
        while abs(value - bound) > AT_BOUND * self._widths[index]:
            value = near + step if abs(step) < abs(bound - near) else bound
            if self._held(index, value) > allowed:
                end = brentq(
                    lambda at: self._held(index, at) - allowed, near, value,
                    xtol=1e-4 * abs(value - self.values[index]) + 1e-15, rtol=1e-6,
                )  # fmt: skip
                return float(end)
            near, step = value, 2 * step
        return bound

    def _held(self, index: int, value: float) -> float:
        """Least sum of squares with one input held."""
        others = [i for i in range(len(self.values)) if i != index]
        values = self.values.copy()
        values[index] = value
        try:
            if others:
                return search(self.curve, values, others)[1]
            left = self.curve.values - self.curve(values)[0]
        except ComputationError:  # there is no cycle, so that the value explains nothing
            return UNEXPLAINED * (1 + float(self.residuals @ self.residuals))
        return float(left @ left)


@dataclass(frozen=True)
class SearchEnd:
    """Values (n,) that a search ended at with the sum of squares that they leave, or why it ended without any."""

    values: Array
    total: float
    reason: str = ""


def fit_curve(
    curve: MeasuredCurve, seed: int = 0, starts: int = STARTS, phase: Phase | None = None, task: Task | None = None,
    means: Means = HERE,
) -> Fit:  # fmt: skip
    """Return the best of searches from the machine's values and from others all over the bounds, the phase by scans.

    `means` says what runs the searches, whose ends do not depend on it; workers take those of a task, which prepares
    `prepare_searches`. Raises ComputationError if none of them comes to values that have a cycle.
    """
    phase = phase or Phase("calibration", "start", starts, None)
    ends = []
    for end in run_in_order(
        task, find_starts(curve, seed, starts), means, prepare_searches(curve), lambda end: end,
        lambda: phase.under_way(None),
    ):  # fmt: skip
        ends.append(end)
        phase.next()
    return choose_fit(curve, ends)


def find_starts(curve: MeasuredCurve, seed: int, starts: int) -> list[Array]:
    """Return the machine's own values, then others drawn from the bounds, (n,) each."""
    rng, own = np.random.default_rng(seed), curve.own()
    lower, upper = curve.bounds(own)
    return [own, *(rng.uniform(lower, upper) for _ in range(starts - 1))]


def prepare_searches(curve: MeasuredCurve) -> Callable[[Array], SearchEnd]:
    """Return the function that searches from values (n,), on `MOST_POINTS` of the points."""
    thin = curve.thinned(MOST_POINTS)

    def run(begin: Array) -> SearchEnd:
        thin.restart()
        try:
            return SearchEnd(*_search_from(thin, begin))
        except ComputationError as error:
            return SearchEnd(begin, float("inf"), error.message)

    return run


def choose_fit(curve: MeasuredCurve, ends: Sequence[SearchEnd]) -> Fit:
    """Return the fit on all points from the best end; of those that agree, from the nearest to the machine's values.

    Combinations of values that the data do not determine stay as they were. Raises ComputationError if there is no end.
    """
    least = min(ends, key=lambda end: end.total)
    if least.reason:
        raise ComputationError(f"no start of the fit leads anywhere; narrow the bounds: {ends[-1].reason}")
    curve.restart()
    own, points = curve.own(), min(len(curve.values), MOST_POINTS)
    lower, upper = curve.bounds(own)
    agreeing = [end for end in ends if agrees(end.total, least.total, points)]
    best = min(agreeing, key=lambda end: float(np.linalg.norm((end.values - own) / (upper - lower))))
    values, total = search(curve, best.values, list(range(len(own))))
    fit = Fit(curve, values, tuple(end.total for end in ends))
    closer = Fit(curve, fit.towards(own), fit.sums)
    lower, upper = curve.bounds(values)
    inside = ((closer.values >= lower) & (closer.values <= upper)).all()
    sum_closer = float(closer.residuals @ closer.residuals)
    return closer if inside and sum_closer - total <= CLOSE * (1 + total) else fit


def _search_from(curve: MeasuredCurve, begin: Array) -> tuple[Array, float]:
    """A search from one place, on from any better phase that a scan shows at its end."""
    every = list(range(len(begin)))
    phases = find_phases(curve, begin, CANDIDATES)
    best = min((search(curve, values, every) for values, _ in phases), key=lambda end: end[1])
    for _ in range(RESCANS if curve.phase_index is not None else 0):
        values, predicted = find_phases(curve, best[0], 1)[0]
        if predicted > BETTER * best[1]:
            break
        end = search(curve, values, every)
        if end[1] >= best[1]:
            break
        best = end
    return best


def agrees(total: float, least: float, points: int) -> bool:
    """Whether a sum of squares over so many points is as good as the least one."""
    return total - least <= AGREEING * least / points + TINY


def search(curve: MeasuredCurve, start: Array, moved: list[int]) -> tuple[Array, float]:
    """Least squares over some of the inputs within their bounds: values (n,) and the sum of squares."""
    lower, upper = curve.bounds(start)
    low, width = lower[moved], (upper - lower)[moved]

    def at(u: Array) -> Array:
        values = start.copy()
        values[moved] = low + u * width
        return values

    found = least_squares(
        lambda u: curve(at(u))[0] - curve.values, np.clip((start[moved] - low) / width, 1e-9, 1 - 1e-9),
        lambda u: curve(at(u))[1][:, moved] * width, bounds=(0, 1), ftol=CLOSE, xtol=CLOSE, gtol=CLOSE, max_nfev=MOST,
    )  # fmt: skip
    return at(found.x), float(2 * found.cost)
