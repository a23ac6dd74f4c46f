"""Tests of residuals for white noise and for noise with correlated neighbours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import f as f_distribution

from planter.errors import ComputationError
from planter.kernels import Array
from planter.measured.curve import MeasuredCurve, find_phases
from planter.parallel.jobs import run_in_order
from planter.parallel.task import AUTO, Means, Task
from planter.progress import ProgressPhase

LAGS = 10
"""Maximum number of lags of a test, which has at most a fifth of the number of points."""
SIGNIFICANCE, REFUTING = 0.01, 1e-4
"""Significance levels of the warning of correlated residuals and of the refutation of a model."""


@dataclass(frozen=True)
class Correlation:
    """Correlation of residuals in the order of their angles: `rho` of neighbours, and tests of Ljung and Box.

    `is_white`: the residuals pass as white noise. `is_autoregressive`: the remainder of a first-order autoregression
    with `rho` passes as white, as for slowly drifting noise and rarely for a wrong model.
    """

    rho: float
    is_white: bool
    is_autoregressive: bool


def assess_correlation(residuals: Array) -> Correlation:
    """Return the correlation of residuals (m,)."""
    total = float(residuals @ residuals)
    if total == 0:
        return Correlation(0.0, True, True)
    rho = float(residuals[1:] @ residuals[:-1]) / total
    return Correlation(
        rho, _is_white(residuals, SIGNIFICANCE), _is_white(residuals[1:] - rho * residuals[:-1], REFUTING, 1)
    )


def _is_white(residuals: Array, significance: float, fitted: int = 0) -> bool:
    lags = max(min(LAGS, len(residuals) // 5), 1 + fitted)
    return ljung_box_probability(residuals, lags, fitted) > significance


def ljung_box_probability(residuals: Array, lags: int, fitted: int = 0) -> float:
    """Return the probability of autocorrelations at least as large as those of residuals (m,) if they are white noise.

    Ljung and Box (1978), On a measure of lack of fit in time series models, Biometrika 65, 297: m (m + 2) times the sum
    over `lags` of rho_k^2 / (m - k) follows a chi-squared distribution; its degrees of freedom are `lags` less the
    number of `fitted` coefficients. Equal residuals have the probability 0.
    """
    from scipy import stats

    count, centred = len(residuals), residuals - residuals.mean()
    total = float(centred @ centred)
    if total == 0:
        return 0.0
    rho = np.array([centred[k:] @ centred[:-k] for k in range(1, lags + 1)]) / total
    statistic = count * (count + 2) * float(np.sum(rho**2 / (count - np.arange(1, lags + 1))))
    return float(stats.chi2.sf(statistic, lags - fitted))


STARTS = 8
CANDIDATES, RESCANS, BETTER = 3, 3, 0.999
"""Number of phases from which a start searches, of later scans, and ratio of sums that is worth another search."""
MOST_POINTS = 360
"""Maximum number of points of the searches."""
TOLERANCE, MAX_EVALUATIONS = 1e-10, 40
"""Relative change at which a search ends, and its maximum number of evaluations."""
AGREEING = 0.01
"""Share of the variance of the residuals by which the sums of squares of agreeing starts may differ."""
DETERMINED = 1e-8
"""Share of the largest singular value below which the data do not determine a combination of inputs."""
LEVEL = 0.95
"""Confidence of the intervals."""
AT_BOUND = 1e-9
UNEXPLAINED = 1e6
"""Sum of squares, relative to the best, of values without a cycle."""
TINY = 1e-12
"""Sum of squares [SI] that is rounding."""


@dataclass(frozen=True)
class Fit:
    """Best values (n,) [SI] of the chosen inputs; `sums` are the sums of squares at the ends of all starts."""

    curve: MeasuredCurve
    values: Array
    sums: tuple[float, ...]

    @cached_property
    def residuals(self) -> Array:
        """Residuals (m,) [SI], measured minus computed."""
        residuals: Array = self.curve.values - self.curve(self.values)[0]
        return residuals

    @property
    def rms(self) -> float:
        """Root mean square of the residuals [SI]."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def agreeing(self) -> int:
        """Number of starts that ended at the same sum of squares as the best."""
        points = min(len(self.curve.values), MOST_POINTS)
        return sum(agrees(total, min(self.sums), points) for total in self.sums)

    @property
    def is_settled(self) -> bool:
        """Return whether most starts agree, so that a better fit is unlikely."""
        return 2 * self.agreeing > len(self.sums)

    @property
    def _widths(self) -> Array:
        widths: Array = self.curve.chosen.upper - self.curve.chosen.lower
        return widths

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Singular values (n,) and right singular vectors (n, n) of the Jacobian, inputs in widths of their bounds."""
        slopes = self.curve(self.values)[1] * self._widths
        _, values, rows = np.linalg.svd(slopes, full_matrices=False)
        return values, rows

    @property
    def rank(self) -> int:
        """Number of combinations of inputs that the data determine."""
        values, _ = self._directions
        return int((values > DETERMINED * values[0]).sum())

    def project(self, start: Array) -> Array:
        """Return `start` (n,) changed to the values only in the combinations that the data determine."""
        values, rows = self._directions
        determined = rows[values > DETERMINED * values[0]]
        change = determined.T @ (determined @ ((self.values - start) / self._widths))
        projected: Array = start + self._widths * change
        return projected

    def correlation(self) -> Array | None:
        """Return the correlation matrix (n, n) of the inputs; None if the data do not determine all of them."""
        if self.rank < len(self.values):
            return None
        values, rows = self._directions
        covariance = (rows.T / values**2) @ rows
        deviation = np.sqrt(np.diag(covariance))
        correlation: Array = covariance / np.outer(deviation, deviation)
        return correlation

    def band(self, index: int) -> tuple[float, float]:
        """Return the interval of an input in which its profile likelihood is within `LEVEL`, cut at the bounds.

        The noise is assumed to be white, equal and independent at all points.
        """
        free = max(len(self.residuals) - len(self.values), 1)
        best = float(self.residuals @ self.residuals)
        allowed = best * (1 + float(f_distribution.ppf(LEVEL, 1, free)) / free) + TOLERANCE
        lower, upper = (float(ends[index]) for ends in self.curve.bounds(self.values))
        first = self._standard_error(index, best / free) or (upper - lower) / 8
        return self._end(index, lower, -2 * first, allowed), self._end(index, upper, 2 * first, allowed)

    def _standard_error(self, index: int, variance: float) -> float | None:
        """Return the standard error of an input by linearisation; None if the data do not determine it."""
        values, rows = self._directions
        share = np.abs(rows[:, index])
        if (share[values <= DETERMINED * values[0]] > DETERMINED).any():
            return None
        determined = values > DETERMINED * values[0]
        return float(np.sqrt(variance * ((share[determined] / values[determined]) ** 2).sum()) * self._widths[index])

    def _end(self, index: int, bound: float, step: float, allowed: float) -> float:
        """Return the end of an interval towards a bound: the first crossing in growing steps."""
        last, value = float(self.values[index]), float(self.values[index])
        while abs(value - bound) > AT_BOUND * self._widths[index]:
            value = last + step if abs(step) < abs(bound - last) else bound
            if self._profile(index, value) > allowed:
                end = brentq(
                    lambda at: self._profile(index, at) - allowed, last, value,
                    xtol=1e-4 * abs(value - self.values[index]) + 1e-15, rtol=1e-6,
                )  # fmt: skip
                return float(end)
            last, step = value, 2 * step
        return bound

    def _profile(self, index: int, value: float) -> float:
        """Return the minimum sum of squares with one input fixed."""
        free = [i for i in range(len(self.values)) if i != index]
        values = self.values.copy()
        values[index] = value
        try:
            if free:
                return search(self.curve, values, free)[1]
            residuals = self.curve.values - self.curve(values)[0]
        except ComputationError:  # no cycle exists at this value
            return UNEXPLAINED * (1 + float(self.residuals @ self.residuals))
        return float(residuals @ residuals)


@dataclass(frozen=True)
class SearchEnd:
    """Values (n,) at the end of a search with their sum of squares, or the reason of its failure."""

    values: Array
    total: float
    reason: str = ""


def fit_curve(
    curve: MeasuredCurve, seed: int = 0, starts: int = STARTS, phase: ProgressPhase | None = None,
    task: Task | None = None, means: Means = AUTO,
) -> Fit:  # fmt: skip
    """Return the best fit of searches from the values of the machine and from random ones, with scans of the phase.

    `means` selects the workers, which prepare their searches by `task`, and does not change the results. Raises
    ComputationError if no search ends at values with a cycle.
    """
    phase = phase or ProgressPhase("calibration", "start", starts, None)
    ends = []
    for end in run_in_order(
        task, find_starts(curve, seed, starts), means, prepare_searches(curve), lambda end: end,
        lambda: phase.report_if_slow(None),
    ):  # fmt: skip
        ends.append(end)
        phase.advance()
    return choose_fit(curve, ends)


def find_starts(curve: MeasuredCurve, seed: int, starts: int) -> list[Array]:
    """Return the values of the machine, then random ones within the bounds, (n,) each."""
    rng, first = np.random.default_rng(seed), curve.machine_values()
    lower, upper = curve.bounds(first)
    return [first, *(rng.uniform(lower, upper) for _ in range(starts - 1))]


def prepare_searches(curve: MeasuredCurve) -> Callable[[Array], SearchEnd]:
    """Return the function that searches from values (n,), on `MOST_POINTS` of the points."""
    thin = curve.with_points(MOST_POINTS)

    def run(begin: Array) -> SearchEnd:
        thin.restart()
        try:
            return SearchEnd(*_search_from(thin, begin))
        except ComputationError as error:
            return SearchEnd(begin, float("inf"), error.message)

    return run


def choose_fit(curve: MeasuredCurve, ends: Sequence[SearchEnd]) -> Fit:
    """Return the fit on all points from the best end, among agreeing ends from the nearest to the machine's values.

    Combinations of values that the data do not determine are unchanged. Raises ComputationError if all searches failed.
    """
    lowest = min(ends, key=lambda end: end.total)
    if lowest.reason:
        raise ComputationError(f"no start of the fit has a cycle; narrow the bounds: {ends[-1].reason}")
    curve.restart()
    initial, points = curve.machine_values(), min(len(curve.values), MOST_POINTS)
    lower, upper = curve.bounds(initial)
    agreeing = [end for end in ends if agrees(end.total, lowest.total, points)]
    best = min(agreeing, key=lambda end: float(np.linalg.norm((end.values - initial) / (upper - lower))))
    values, total = search(curve, best.values, list(range(len(initial))))
    fit = Fit(curve, values, tuple(end.total for end in ends))
    closer = Fit(curve, fit.project(initial), fit.sums)
    lower, upper = curve.bounds(values)
    inside = ((closer.values >= lower) & (closer.values <= upper)).all()
    sum_closer = float(closer.residuals @ closer.residuals)
    return closer if inside and sum_closer - total <= TOLERANCE * (1 + total) else fit


def _search_from(curve: MeasuredCurve, begin: Array) -> tuple[Array, float]:
    """Search from one point, and again from each better phase of a scan at its end."""
    indices = list(range(len(begin)))
    phases = find_phases(curve, begin, CANDIDATES)
    best = min((search(curve, values, indices) for values, _ in phases), key=lambda end: end[1])
    for _ in range(RESCANS if curve.phase_index is not None else 0):
        values, predicted = find_phases(curve, best[0], 1)[0]
        if predicted > BETTER * best[1]:
            break
        end = search(curve, values, indices)
        if end[1] >= best[1]:
            break
        best = end
    return best


def agrees(total: float, minimum: float, points: int) -> bool:
    """Return whether a sum of squares over a number of points is as good as the minimum."""
    return total - minimum <= AGREEING * minimum / points + TINY


def search(curve: MeasuredCurve, start: Array, moved: list[int]) -> tuple[Array, float]:
    """Return values (n,) and sum of squares of a least-squares fit of the inputs `moved` within their bounds."""
    lower, upper = curve.bounds(start)
    low, width = lower[moved], (upper - lower)[moved]

    def at(u: Array) -> Array:
        values = start.copy()
        values[moved] = low + u * width
        return values

    solution = least_squares(
        lambda u: curve(at(u))[0] - curve.values, np.clip((start[moved] - low) / width, 1e-9, 1 - 1e-9),
        lambda u: curve(at(u))[1][:, moved] * width, bounds=(0, 1),
        ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE, max_nfev=MAX_EVALUATIONS,
    )  # fmt: skip
    return at(solution.x), float(2 * solution.cost)
