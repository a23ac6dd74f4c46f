"""The best fit of chosen inputs to measured curves: searches from many starts, intervals, agreement
of the starts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from planter.errors import ComputationError
from planter.jobs import run_in_order
from planter.kernels import Array
from planter.measured.curve import MeasuredCurve, Side
from planter.measured.noise import NoiseEstimate, estimate_noise
from planter.progress import ProgressPhase
from planter.task import AUTO, Means, Task

STARTS = 8
CANDIDATES, RESCANS, BETTER = 3, 3, 0.999
"""Number of phases from which a start searches, of later scans, and ratio of sums that is worth
another search.
"""
MOST_POINTS = 360
"""Maximum number of points of the searches."""
TOLERANCE, PROFILE_TOLERANCE, MAX_EVALUATIONS = 1e-10, 1e-6, 40
"""Relative changes at which a search and a point of a profile end, and the maximum number of
evaluations.
"""
AGREEING = 0.01
"""Share of the variance of the residuals by which the sums of squares of agreeing starts may
differ.
"""
DETERMINED = 1e-8
"""Share of the largest singular value below which the data do not determine a combination of
inputs.
"""
LEVEL = 0.95
"""Confidence of the intervals."""
END_TOLERANCE = 1e-3
"""Accuracy of an end, in shares of its distance."""
PARABOLIC = 0.15
"""Relative deviation of a profile from a parabola, below which a parabola through its point gives
the end.
"""
STEEP = 0.75
"""Ratio of an end to that of linearisation below which a profile is a step: a jump of the curve
passes a point.
"""
AT_BOUND = 1e-9
BAND_ANGLES = 36
"""Number of angles of a cycle at which the uncertainty of the noise's correlation widens the band
of a curve.
"""
REACHED, INSIDE = 1e-6, 0.05
"""Shares of the width of the bounds within which an input lies on one, and away from it in a fit
inside.
"""
UNEXPLAINED = 1e6
"""Sum of squares, relative to the best, of values without a cycle."""
TINY = 1e-9
"""Sum of squares, in variances of the noise, that is rounding."""
RECOLOURINGS, SAME_RHO = 3, 0.01
"""Maximum number of searches with the correlation of the residuals, and change of it that is
none.
"""
TINY_NOISE = 1e-3
"""Smallest standard deviation of residuals, in that of the noise of the data."""


@dataclass(frozen=True)
class Fit:
    """Best values (n,) [SI] of the chosen inputs; `sums` are the sums of squares at the ends of all
    starts.

    Sums are of white residuals, in standard deviations of the noise of the data.
    """

    curve: MeasuredCurve
    values: Array
    sums: tuple[float, ...]

    @cached_property
    def residuals(self) -> Array:
        """Residuals (m,) in display units, measured minus computed."""
        residuals: Array = self.curve.values - self.curve(self.values)[0]
        return residuals

    @cached_property
    def _white(self) -> tuple[Array, Array]:
        """White residuals (m,) and their Jacobian (m, n)."""
        return self.curve.residuals(self.values)

    @property
    def rms(self) -> float:
        """Root mean square of the residuals of the first quantity, in its display unit."""
        return self.channel_rms[0]

    @property
    def channel_rms(self) -> tuple[float, ...]:
        """Root mean square of the residuals of each quantity, in its display unit."""
        return tuple(
            float(np.sqrt(np.mean(self.residuals[points] ** 2))) for points in self.curve.channels
        )

    @property
    def agreeing(self) -> int:
        """Number of starts that ended at the same sum of squares as the best."""
        points = min(len(self.curve.values), MOST_POINTS)
        return sum(agrees(total, min(self.sums), points) for total in self.sums)

    @property
    def is_settled(self) -> bool:
        """Return whether most starts agree, so that a better fit is unlikely."""
        return 2 * self.agreeing > len(self.sums)

    @cached_property
    def active_bounds(self) -> dict[int, Side]:
        """Bounds on which inputs lie, by index; none if a fit inside of them is as good.

        Inside is `INSIDE` of the width away from all of them, and as good is within `LEVEL` of the
        likelihood ratio for as many inputs. So an input on a bound does not count if the data
        hardly depend on it.
        """
        active: dict[int, Side] = {}
        curve, values = self.curve, self.values
        while reached := {
            i: side for i, side in _find_reached(self.curve, values).items() if i not in active
        }:
            active |= reached
            curve = self.curve.with_bounds_moved({i: (side, INSIDE) for i, side in active.items()})
            values, total = search(curve, np.clip(values, *curve.bounds(values)), _all(self))
        if not active:
            return {}
        count, free = len(active), max(len(self.residuals) - self.rank, 1)
        white = self._white[0]
        allowed = (
            float(white @ white) * (1 + count * float(scipy.stats.f.ppf(LEVEL, count, free)) / free)
            + TOLERANCE
        )
        return active if total > allowed else {}

    @property
    def _widths(self) -> Array:
        widths: Array = self.curve.chosen.upper - self.curve.chosen.lower
        return widths

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Singular values (n,) and right singular vectors (n, n) of the Jacobian, inputs in widths
        of their bounds.
        """
        slopes = self._white[1] * self._widths
        _, values, rows = np.linalg.svd(slopes, full_matrices=False)
        return values, rows

    @property
    def rank(self) -> int:
        """Number of combinations of inputs that the data, with normal priors, determine."""
        values, _ = self._directions
        return int((values > DETERMINED * values[0]).sum())

    def project(self, start: Array) -> Array:
        """Return `start` (n,) changed to the values only in the combinations that the data
        determine.
        """
        values, rows = self._directions
        determined = rows[values > DETERMINED * values[0]]
        change = determined.T @ (determined @ ((self.values - start) / self._widths))
        projected: Array = start + self._widths * change
        return projected

    @cached_property
    def covariance(self) -> Array | None:
        """Covariance (n, n) [SI] of the inputs by linearisation, for the noise of the fit.

        None if the data do not determine all of them.
        """
        if self.rank < len(self.values):
            return None
        values, rows = self._directions
        covariance: Array = (rows.T / values**2) @ rows * np.outer(self._widths, self._widths)
        return covariance

    def correlation(self) -> Array | None:
        """Return the correlation matrix (n, n) of the inputs; None if the data do not determine all
        of them.
        """
        if self.covariance is None:
            return None
        deviation = np.sqrt(np.diag(self.covariance))
        correlation: Array = self.covariance / np.outer(deviation, deviation)
        return correlation

    @cached_property
    def noise(self) -> NoiseEstimate:
        """Noise that the residuals show, given how many combinations of inputs were fitted."""
        return estimate_noise(self.curve, self.residuals, self.curve(self.values)[1])

    def band(self, index: int) -> tuple[float, float]:
        """Return the interval of an input in which its profile likelihood is within `LEVEL`, cut at
        the bounds.

        The width allows for the uncertainty of the noise's size and correlation. Where a jump of
        the curve passes a measured point, the profile has a step, and linearisation gives the end.
        """
        free = max(len(self.residuals) - self.rank, 1)
        white = self._white[0]
        best = float(white @ white)
        standard_error = self._standard_error(index)
        spread = (
            1.0
            if standard_error is None
            else self.noise.widen(np.eye(len(self.values))[index], LEVEL)
        )
        allowed = (
            best * (1 + spread**2 * float(scipy.stats.f.ppf(LEVEL, 1, free)) / free) + TOLERANCE
        )
        lower, upper = (float(ends[index]) for ends in self.curve.bounds(self.values))
        first = (
            (upper - lower) / 8
            if standard_error is None
            else standard_error * float(np.sqrt(allowed - best))
        )
        ends = (
            self._end(index, lower, -2 * first, allowed),
            self._end(index, upper, 2 * first, allowed),
        )
        if standard_error is None:
            return ends
        value = float(self.values[index])
        low, high = (
            end if abs(end - value) > STEEP * first else value + side * first
            for end, side in zip(ends, (-1, 1), strict=True)
        )
        return max(low, lower), min(high, upper)

    def curve_band(self, phi: Array) -> tuple[Array, Array]:
        """Return the curves (k, n) at angles [rad] and half the widths of their intervals at each,
        for `LEVEL`.

        They are those of linearisation, without the noise of a measured point. The width allows for
        the uncertainty of the noise's size and correlation, of the latter at `BAND_ANGLES` angles
        and in between by interpolation.
        """
        white, free = self._white[0], max(len(self.residuals) - self.rank, 1)
        variance = float(white @ white) / free
        singular, rows = self._directions
        determined = singular > DETERMINED * singular[0]
        root = (rows[determined].T / singular[determined]) * self._widths[:, None]
        values, slopes = self.curve.evaluate(self.values, phi)
        moves = self.curve.duration is not None  # over a record, which does not repeat
        nodes = np.linspace(0, self.curve.machine.turn, BAND_ANGLES, endpoint=moves)
        directions = self.curve.evaluate(self.values, nodes)[1]
        factors = [
            np.interp(
                phi,
                nodes,
                [self.noise.widen(row, LEVEL) for row in channel],
                period=None if moves else self.curve.machine.turn,
            )
            for channel in directions
        ]
        deviations = np.sqrt(variance) * np.linalg.norm(slopes @ root, axis=2)
        return values, float(scipy.stats.t.ppf((1 + LEVEL) / 2, free)) * np.array(
            factors
        ) * deviations

    def _standard_error(self, index: int) -> float | None:
        """Return the standard error of an input for noise of variance 1, by linearisation; None if
        not determined.
        """
        values, rows = self._directions
        share = np.abs(rows[:, index])
        if (share[values <= DETERMINED * values[0]] > DETERMINED).any():
            return None
        determined = values > DETERMINED * values[0]
        return float(
            np.sqrt(((share[determined] / values[determined]) ** 2).sum()) * self._widths[index]
        )

    def _end(self, index: int, bound: float, step: float, allowed: float) -> float:
        """Return the end of an interval towards a bound: the first crossing in growing steps."""
        last, value = float(self.values[index]), float(self.values[index])
        best = float(self._white[0] @ self._white[0])

        def find_distance(at: float) -> float:
            """Return the root of the share of the allowed increase, which is linear where the
            profile is a parabola.
            """
            return float(np.sqrt(max(self._profile(index, at) - best, 0.0) / (allowed - best)))

        first = value + step / 2
        if abs(first - value) < abs(bound - value):
            distance = find_distance(first)
            if abs(distance**2 - 1) < PARABOLIC:  # the profile is a parabola up to there
                return float(
                    np.clip(value + step / 2 / distance, min(bound, value), max(bound, value))
                )
        while abs(value - bound) > AT_BOUND * self._widths[index]:
            value = last + step if abs(step) < abs(bound - last) else bound
            if find_distance(value) > 1:
                end = scipy.optimize.brentq(
                    lambda at: find_distance(at) - 1,
                    last,
                    value,
                    xtol=END_TOLERANCE * abs(value - self.values[index]) + 1e-15,
                    rtol=1e-6,
                )
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
                return search(self.curve, values, free, PROFILE_TOLERANCE)[1]
            residuals = self.curve.residuals(values)[0]
        except ComputationError:  # no cycle exists at this value
            return UNEXPLAINED * (1 + float(self._white[0] @ self._white[0]))
        return float(residuals @ residuals)


@dataclass(frozen=True)
class SearchEnd:
    """Values (n,) at the end of a search with their sum of squares, or the reason of its
    failure.
    """

    values: Array
    total: float
    reason: str = ""


def fit_curve(
    curve: MeasuredCurve,
    seed: int = 0,
    starts: int = STARTS,
    phase: ProgressPhase | None = None,
    task: Task | None = None,
    means: Means = AUTO,
) -> Fit:
    """Return the best fit of searches from the values of the machine and from random ones, with
    scans of the phase.

    `means` selects the workers, which prepare their searches by `task`, and does not change the
    results. Raises ComputationError if no search ends at values with a cycle.
    """
    phase = phase or ProgressPhase("calibration", "start", starts, None)
    ends = []
    for end in run_in_order(
        task,
        find_starts(curve, seed, starts),
        means,
        prepare_searches(curve),
        lambda end: end,
        lambda: phase.report_if_slow(None),
    ):
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
            for part in thin.list_beginnings():
                begin = search(part, begin, list(range(len(begin))), PROFILE_TOLERANCE)[0]
            return SearchEnd(*_search_from(thin, begin))
        except ComputationError as error:
            return SearchEnd(begin, float("inf"), error.message)

    return run


def choose_fit(curve: MeasuredCurve, ends: Sequence[SearchEnd]) -> Fit:
    """Return the fit on all points from the best end, among agreeing ends from the nearest to the
    machine's values.

    Combinations of values that the data do not determine are unchanged. Raises ComputationError if
    all searches failed.
    """
    lowest = min(ends, key=lambda end: end.total)
    if lowest.reason:
        raise ComputationError(
            f"no start of the fit has a cycle; narrow the bounds: {ends[-1].reason}"
        )
    curve.restart()
    initial, points = curve.machine_values(), min(len(curve.values), MOST_POINTS)
    lower, upper = curve.bounds(initial)
    agreeing = [end for end in ends if agrees(end.total, lowest.total, points)]
    best = min(
        agreeing, key=lambda end: float(np.linalg.norm((end.values - initial) / (upper - lower)))
    )
    values, _ = search(curve, best.values, list(range(len(initial))))
    fit = _recolour(Fit(curve, values, tuple(end.total for end in ends)))
    closer = Fit(fit.curve, fit.project(initial), fit.sums)
    lower, upper = curve.bounds(fit.values)
    inside = ((closer.values >= lower) & (closer.values <= upper)).all()
    sums = [
        float(white @ white)
        for white in (each.curve.residuals(each.values)[0] for each in (fit, closer))
    ]
    return closer if inside and sums[1] - sums[0] <= TOLERANCE * (1 + sums[0]) else fit


def _recolour(fit: Fit) -> Fit:
    """Return the fit for the noise that its residuals show, searched again until the correlation
    stays the same.
    """
    for _ in range(RECOLOURINGS):
        noises = fit.noise.noises
        changes = [
            abs(new.rho - old.rho) for new, old in zip(noises, fit.curve.noises, strict=True)
        ]
        curve = fit.curve.with_noises(
            [
                replace(new, std=max(new.std, old.std * TINY_NOISE))
                for new, old in zip(noises, fit.curve.noises, strict=True)
            ]
        )
        if max(changes) == 0:
            return Fit(
                curve,
                fit.values if len(noises) == 1 else search(curve, fit.values, _all(fit))[0],
                fit.sums,
            )
        values, _ = _search_from(curve, fit.values)
        fit = Fit(curve, values, fit.sums)
        if max(changes) < SAME_RHO:
            break
    return fit


def _find_reached(curve: MeasuredCurve, values: Array) -> dict[int, Side]:
    """Return the bounds on which values (n,) lie, by index."""
    lower, upper = curve.bounds(values)
    margin = REACHED * (upper - lower)
    on_lower, on_upper = values <= lower + margin, values >= upper - margin
    return {
        int(i): "lower" if on_lower[i] else "upper" for i in np.flatnonzero(on_lower | on_upper)
    }


def _all(fit: Fit) -> list[int]:
    return list(range(len(fit.values)))


def _search_from(curve: MeasuredCurve, begin: Array) -> tuple[Array, float]:
    """Search from one point, and again from each better minimum of a scan at its end."""
    indices = list(range(len(begin)))
    starts = curve.find_starts(begin, CANDIDATES)
    best = min((search(curve, values, indices) for values, _ in starts), key=lambda end: end[1])
    for _ in range(RESCANS):
        values, predicted = curve.find_starts(best[0], 1)[0]
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


def search(
    curve: MeasuredCurve, start: Array, moved: list[int], tolerance: float = TOLERANCE
) -> tuple[Array, float]:
    """Return values (n,) and sum of squares of a least-squares fit of the inputs `moved` within
    their bounds.
    """
    lower, upper = curve.bounds(start)
    low, width = lower[moved], (upper - lower)[moved]

    def at(u: Array) -> Array:
        values = start.copy()
        values[moved] = low + u * width
        return values

    solution = scipy.optimize.least_squares(
        lambda u: curve.residuals(at(u))[0],
        np.clip((start[moved] - low) / width, 1e-9, 1 - 1e-9),
        lambda u: curve.residuals(at(u))[1][:, moved] * width,
        bounds=(0, 1),
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        max_nfev=MAX_EVALUATIONS,
    )
    return at(solution.x), float(2 * solution.cost)
