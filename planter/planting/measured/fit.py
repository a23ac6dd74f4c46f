"""Least squares from many starts, and what the data determine: rank, correlation, bands by profiles of likelihood."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import f as f_distribution

from planter.kernels import Array
from planter.planting.measured.curve import MeasuredCurve

STARTS = 8
CLOSE, MOST = 1e-10, 40
"""Relative change at which a search ends, and its most evaluations."""
AGREEING = 1e-6
"""Starts agree whose sums of squares differ by less than this share."""
DETERMINED = 1e-8
"""Singular values below this share of the largest are those of combinations that the data do not determine."""
LEVEL = 0.95
"""Confidence of the bands."""
AT_BOUND = 1e-9


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
        return sum(agrees(one, min(self.sums)) for one in self.sums)

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
        """Where the profile of the likelihood of an input passes `LEVEL`, on each side; its bound where it does not."""
        free = max(len(self.residuals) - len(self.values), 1)
        best = float(self.residuals @ self.residuals)
        allowed = best * (1 + float(f_distribution.ppf(LEVEL, 1, free)) / free) + CLOSE
        low, high = self.curve.chosen.lower[index], self.curve.chosen.upper[index]
        ends = []
        for bound in (low, high):
            if abs(bound - self.values[index]) <= AT_BOUND * (high - low) or self._held(index, bound) <= allowed:
                ends.append(float(bound))
                continue
            found = brentq(
                lambda value: self._held(index, value) - allowed, self.values[index], bound,
                xtol=1e-4 * abs(bound - self.values[index]) + 1e-15, rtol=1e-6,
            )  # fmt: skip
            ends.append(float(found))
        return ends[0], ends[1]

    def _held(self, index: int, value: float) -> float:
        """Least sum of squares with one input held."""
        others = [i for i in range(len(self.values)) if i != index]
        values = self.values.copy()
        values[index] = value
        if not others:
            left = self.curve.values - self.curve(values)[0]
            return float(left @ left)
        return search(self.curve, values, others)[1]


def searched(curve: MeasuredCurve, seed: int = 0, starts: int = STARTS) -> Fit:
    """The best of searches from the machine's own values and from places all over the bounds.

    Of those that agree, the one nearest to the machine's own values; what the data do not feel stays as it was.
    """
    chosen, rng = curve.chosen, np.random.default_rng(seed)
    begins = [curve.own(), *(rng.uniform(chosen.lower, chosen.upper) for _ in range(starts - 1))]
    every = list(range(len(chosen.names)))
    ends = [search(curve, begin, every) for begin in begins]
    least, own = min(end[1] for end in ends), begins[0]
    agreeing = [end for end in ends if agrees(end[1], least)]
    width = chosen.upper - chosen.lower
    best = min(agreeing, key=lambda end: float(np.linalg.norm((end[0] - own) / width)))
    found = Fit(curve, best[0], tuple(end[1] for end in ends))
    closer = Fit(curve, found.towards(own), found.sums)
    total = float(closer.residuals @ closer.residuals)
    inside = ((closer.values >= chosen.lower) & (closer.values <= chosen.upper)).all()
    return closer if inside and agrees(total, least) else found


def agrees(total: float, least: float) -> bool:
    """Whether a sum of squares is the least one but for the search's end."""
    return total - least <= AGREEING * least + AGREEING**2


def search(curve: MeasuredCurve, start: Array, moved: list[int]) -> tuple[Array, float]:
    """Least squares over some of the inputs within their bounds: values (n,) and the sum of squares."""
    low, width = curve.chosen.lower[moved], (curve.chosen.upper - curve.chosen.lower)[moved]

    def at(u: Array) -> Array:
        values = start.copy()
        values[moved] = low + u * width
        return values

    found = least_squares(
        lambda u: curve(at(u))[0] - curve.values, np.clip((start[moved] - low) / width, 1e-9, 1 - 1e-9),
        lambda u: curve(at(u))[1][:, moved] * width, bounds=(0, 1), ftol=CLOSE, xtol=CLOSE, gtol=CLOSE, max_nfev=MOST,
    )  # fmt: skip
    return at(found.x), float(2 * found.cost)
