"""Noise of residuals: its size and the correlation of neighbours, and whether a model leaves more
than noise.

Noise is an autoregression of first order, e_i = rho e_(i-1) + white. Its correlation maximises the
restricted likelihood, which allows for what the fit of the inputs takes from the residuals
(Harville 1977, Maximum likelihood approaches to variance component estimation, J. Am. Stat. Assoc.
72, 320).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.polynomial import legendre

from planter.files.record import Record
from planter.kernels import Array, Integers
from planter.measured.curve import ChannelNoise, MeasuredCurve
from planter.measured.reading import TWO_REVOLUTIONS, count_mean_harmonics, fourier_basis
from planter.numerics.arrays import TURN

RHOS = np.tanh(np.linspace(0.0, 3.2, 65))
"""Correlations that are tried, 0 to 0.997."""
RHO_PRIOR = np.gradient(RHOS) / np.sqrt(1 - RHOS**2)
"""Prior of the correlations, (1 - rho^2)^-1/2, with the widths between them."""
CORRELATED = 1.35
"""Gain of the logarithm of the likelihood from which on noise counts as correlated: a level of 10
%.
"""
INDEPENDENT = 1e-9
"""Share of the largest singular value below which a column follows from the others."""
ROUNDING = 1e-14
"""Share of a sum of squares that is rounding."""
REFUTING = 1e-3
"""Probability below which what a model leaves is no noise."""
PLAUSIBLE = 2.0
"""Loss of the logarithm of the likelihood up to which a correlation is plausible: a level of 95
%.
"""
TREND_DEGREES = 3, 8
"""Degrees of the polynomials over a record that a model may not leave: few see a weak trend, many
one that swings.
"""
HARMONICS, POINTS_PER_HARMONIC = 20, 6
"""Largest number of harmonics of what a model may leave, and least points of a revolution for
each.
"""


@dataclass(frozen=True)
class RhoLikelihood:
    """Restricted likelihood of residuals (m,) over correlations, after the fit of independent
    columns (m, p).

    `logs` are logarithms for `RHOS`, `sums` sums of squares of the white residuals there,
    `inverses` the inverses (p, p) of the normal equations' matrix, `shifts` the changes (p,) of the
    coefficients that a correlation brings.
    """

    logs: Array
    sums: Array
    inverses: Array
    shifts: Array
    free: int

    @classmethod
    def compute(cls, residuals: Array, columns: Array, gaps: Array) -> RhoLikelihood:
        """Return the likelihood; `gaps` (m - 1,) are the steps between neighbours."""
        count, size = columns.shape
        products = sum_white_products(np.column_stack([columns, residuals]), gaps)
        inner, side, corner = (
            products[:, :size, :size],
            products[:, :size, size],
            products[:, size, size],
        )
        inverses = np.linalg.inv(inner)
        shifts = np.einsum("gij,gj->gi", inverses, side)
        sums: Array = np.maximum(corner - np.einsum("gi,gi->g", shifts, side), ROUNDING * corner)
        log_dets = compute_log_determinants(gaps) + np.linalg.slogdet(inner)[1]
        logs = -((count - size) * np.log(np.maximum(sums, 1e-300)) + log_dets) / 2
        return cls(logs, sums, inverses.astype(float), shifts, count - size)

    @cached_property
    def best(self) -> int:
        """Index of the most likely correlation; 0 where the data do not tell it from none."""
        best = int(self.logs.argmax())
        return best if self.logs[best] - self.logs[0] > CORRELATED else 0

    @cached_property
    def weights(self) -> Array:
        """Probabilities of the correlations, for the prior (1 - rho^2)^-1/2; of the best alone if
        there is none.
        """
        if self.best == 0:
            return np.eye(len(RHOS))[0]
        density = np.exp(self.logs - self.logs.max()) * RHO_PRIOR
        weights: Array = density / density.sum()
        return weights

    def noise(self) -> ChannelNoise:
        """Return the most likely noise."""
        return ChannelNoise(
            float(np.sqrt(self.sums[self.best] / max(self.free, 1))), float(RHOS[self.best])
        )

    def widen(self, direction: Array, level: float) -> float:
        """Return by how much the interval of a combination (p,) of coefficients is wider as rho is
        not known.
        """
        deviations = np.sqrt(
            np.einsum("i,gij,j->g", direction, self.inverses, direction) * self.sums / self.free
        )
        if not deviations[self.best] > 0 or self.best == 0:
            return 1.0
        shifts = self.shifts @ direction - self.shifts[self.best] @ direction
        quantile = float(scipy.stats.t.ppf((1 + level) / 2, self.free))

        def miss(width: float) -> float:
            ends = (
                np.array([width, -width])[:, None] * deviations[self.best] * quantile - shifts
            ) / deviations
            inside = scipy.stats.t.cdf(ends[0], self.free) - scipy.stats.t.cdf(ends[1], self.free)
            return float(self.weights @ inside) - level

        high = 2.0
        while miss(high) < 0:
            high *= 2
        return (
            max(1.0, float(scipy.optimize.brentq(miss, 0.1, high, xtol=1e-4)))
            if miss(0.1) < 0
            else 1.0
        )


@dataclass(frozen=True)
class NoiseEstimate:
    """Noise of each quantity, from likelihoods over independent combinations (rank, n) of the
    inputs.
    """

    likelihoods: tuple[RhoLikelihood, ...]
    combinations: tuple[Array, ...]

    @property
    def noises(self) -> tuple[ChannelNoise, ...]:
        """The most likely noise of each quantity."""
        return tuple(likelihood.noise() for likelihood in self.likelihoods)

    def widen(self, direction: Array, level: float) -> float:
        """Return by how much the interval of a sum of inputs (n,) is wider as correlations are not
        known.
        """
        factors = [1.0]
        for likelihood, combinations in zip(self.likelihoods, self.combinations, strict=True):
            combined = direction @ combinations
            if np.any(combined):
                factors.append(likelihood.widen(combined, level))
        return (
            max(factors)
            if len(self.likelihoods) == 1
            else float(np.sqrt(np.mean(np.square(factors[1:] or [1.0]))))
        )


def estimate_noise(curve: MeasuredCurve, residuals: Array, slopes: Array) -> NoiseEstimate:
    """Return the noise of residuals (m,) of all quantities after a fit with a Jacobian (m, n)."""
    likelihoods, combinations = [], []
    for points, gaps in zip(curve.channels, curve.gaps, strict=True):
        columns, back = find_independent(slopes[points])
        likelihoods.append(RhoLikelihood.compute(residuals[points], columns, gaps))
        combinations.append(back)
    return NoiseEstimate(tuple(likelihoods), tuple(combinations))


def compute_log_determinants(gaps: Array) -> Array:
    """Return the logarithms (g,) of the determinants of the noise's covariance, of size 1, for each
    of `RHOS`.
    """
    return np.array([np.log1p(-(float(rho) ** (2 * gaps))).sum() for rho in RHOS])


def sum_white_products(rows: Array, gaps: Array) -> Array:
    """Return the products (g, j, j) of rows (m, j) that are white for each of `RHOS`."""
    products = np.repeat(np.outer(rows[0], rows[0])[None], len(RHOS), axis=0)
    for gap in np.unique(gaps):
        at = np.flatnonzero(gaps == gap)
        later, earlier = rows[at + 1], rows[at]
        squares, cross, earlier_squares = later.T @ later, later.T @ earlier, earlier.T @ earlier
        share = (RHOS**gap)[:, None, None]
        products += (squares - share * (cross + cross.T) + share**2 * earlier_squares) / (
            1 - share**2
        )
    return products


def find_independent(columns: Array) -> tuple[Array, Array]:
    """Return an orthonormal basis (m, p) of columns (m, n), and the map (n, p) from its
    coefficients to theirs.
    """
    if not columns.size:
        return columns[:, :0], np.zeros((columns.shape[1], 0))
    sizes = np.linalg.norm(columns, axis=0)
    sizes[sizes == 0] = 1.0
    left, values, right = np.linalg.svd(columns / sizes, full_matrices=False)
    good = values > INDEPENDENT * max(float(values[0]), 1e-300)
    return left[:, good], (right[good].T / values[good]) / sizes[:, None]


@dataclass(frozen=True)
class LackOfFit(Record):
    """F test of harmonics of a cycle in what a model leaves, with whitened noise.

    `probability` is that of at least this F for noise alone, the largest over all plausible
    correlations.
    """

    F: float
    probability: float
    harmonics: int


def assess_lack_of_fit(curve: MeasuredCurve, residuals: Array, slopes: Array) -> LackOfFit:
    """Return the test of residuals (m,) after a fit with a Jacobian (m, n), over all quantities.

    A record of several revolutions is also compared with its mean curve, which no model may miss by
    more than noise; and each record with polynomials over it: noise that is highly correlated could
    stand for a trend. Of what moves freely the harmonics are those of the record, and those around
    its oscillation.
    """
    worst, tests = LackOfFit(0.0, 1.0, 0), 0
    for points, gaps in zip(curve.channels, curve.gaps, strict=True):
        phi, part, records = curve.phi[points], residuals[points], curve.records[points]
        revolutions = max(float(np.ptp(phi)) / TURN, 0.25)
        count = int(min(HARMONICS, len(phi) / revolutions / POINTS_PER_HARMONIC, len(phi) / 5))
        if count < 1:
            continue
        both = np.column_stack([slopes[points], fourier_basis(phi, count)])
        results = [compare_nested(part, slopes[points], both, gaps)]
        if curve.duration is not None:  # a record has many oscillations, and a cycle is one
            first = find_first_order(phi, curve.values[points], count)
            both = np.column_stack([slopes[points], fourier_basis(phi, count, first)])
            results.append(compare_nested(part, slopes[points], both, gaps))
        for degree in TREND_DEGREES:
            trends = np.column_stack([slopes[points], build_trends(phi, records, degree)])
            results.append(compare_nested(part, slopes[points], trends, gaps))
        if revolutions >= TWO_REVOLUTIONS:
            results.append(
                _compare_with_mean_curve(curve.values[points], phi, part, slopes[points], gaps)
            )
        for test in results:
            tests += 1
            if test.probability < worst.probability or not worst.harmonics:
                worst = LackOfFit(test.F, test.probability, count)
    probability = min(1.0, worst.probability * max(tests, 1))
    return LackOfFit(worst.F, probability, worst.harmonics)


def find_first_order(phi: Array, values: Array, count: int) -> int:
    """Return the first of so many harmonics around the largest one of values (m,) at angles (m,)
    [rad].
    """
    orders = np.arange(1, max(len(phi) // 3, 2))
    waves = np.exp(-1j * np.outer(orders, phi)) @ (values - values.mean())
    largest = int(orders[np.abs(waves).argmax()])
    return max(1, largest - count // 2)


def build_trends(phi: Array, records: Integers, degree: int) -> Array:
    """Return polynomials (m, j) up to a degree over each record at angles (m,) [rad].

    They swing less often than the cycle, whose harmonics have a test of their own, but the cubic is
    always among them.
    """
    columns = []
    for record in np.unique(records):
        inside = records == record
        first, last = float(phi[inside].min()), float(phi[inside].max())
        share = np.clip(2 * (phi - first) / ((last - first) or 1.0) - 1, -1.0, 1.0)
        slower = max(TREND_DEGREES[0], int(2 * (last - first) / TURN) - 1)
        rows = legendre.legvander(share, min(degree, slower))
        columns.append(np.where(inside[:, None], rows, 0.0))
    return np.column_stack(columns)


def _compare_with_mean_curve(
    values: Array, phi: Array, residuals: Array, slopes: Array, gaps: Array
) -> LackOfFit:
    """Return the F test of the variance that a model leaves against that about the mean curve of
    all revolutions.
    """
    basis = fourier_basis(phi, count_mean_harmonics(phi))
    mean = RhoLikelihood.compute(values, basis, gaps)
    model = RhoLikelihood.compute(residuals, find_independent(slopes)[0], gaps)
    if min(mean.free, model.free) <= 0:
        return LackOfFit(0.0, 1.0, 0)
    ratios = model.sums / model.free / np.maximum(mean.sums / mean.free, 1e-300)
    return _find_least_refuting(
        mean, ratios, scipy.stats.f.sf(ratios, model.free, mean.free), basis.shape[1]
    )


def _find_least_refuting(
    likelihood: RhoLikelihood, statistics: Array, probabilities: Array, size: int
) -> LackOfFit:
    """Return the test with the largest probability over the plausible correlations."""
    plausible = likelihood.logs >= likelihood.logs.max() - PLAUSIBLE
    index = int(np.argmax(np.where(plausible, probabilities, -1.0)))
    return LackOfFit(float(statistics[index]), float(probabilities[index]), size)


def compare_nested(residuals: Array, small: Array, large: Array, gaps: Array) -> LackOfFit:
    """Return the F test of columns `large` (m, q), which contain `small` (m, p), for the noise of
    the large model.
    """
    inner, outer = find_independent(small)[0], find_independent(large)[0]
    return compare_likelihoods(
        RhoLikelihood.compute(residuals, inner, gaps), RhoLikelihood.compute(residuals, outer, gaps)
    )


def compare_likelihoods(small: RhoLikelihood, large: RhoLikelihood) -> LackOfFit:
    """Return the F test of a model against a smaller one: the largest probability over plausible
    correlations.
    """
    more = small.free - large.free
    if more <= 0 or large.free <= 0:
        return LackOfFit(0.0, 1.0, 0)
    statistics = (small.sums - large.sums) / more / np.maximum(large.sums / large.free, 1e-300)
    return _find_least_refuting(
        large, statistics, scipy.stats.f.sf(statistics, more, large.free), more
    )


def compute_log_evidence(curve: MeasuredCurve, residuals: Array, slopes: Array) -> float:
    """Return the logarithm of the probability of the data of one quantity, after a fit with a
    Jacobian (m, n).

    The posterior is taken as normal within the bounds, over which inputs are uniform (Laplace's
    method). The size of the noise, with the prior 1 / size, and its correlation, uniform over
    `RHOS`, are integrated. Combinations of inputs that the bounds hold better than the data count
    as fixed. A constant of the data is left out.
    """
    columns = slopes * (curve.chosen.upper - curve.chosen.lower)
    rows = curve.whiten(columns)
    _, values, directions = np.linalg.svd(rows, full_matrices=False)
    determined = columns @ directions[values > np.sqrt(TURN)].T
    likelihood = RhoLikelihood.compute(residuals, determined, curve.gaps[0])
    free = likelihood.free
    return (
        float(scipy.special.logsumexp(likelihood.logs))
        - np.log(len(RHOS))
        + float(scipy.special.gammaln(free / 2))
        - free / 2 * np.log(np.pi)
    )
