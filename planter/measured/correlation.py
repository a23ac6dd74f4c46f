"""Whether residuals are white noise, or look like noise in which neighbours are correlated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array

LAGS = 10
"""Lags that a test looks at, and at most a fifth of the points."""
SIGNIFICANCE, REFUTING = 0.01, 1e-4
"""Probabilities of a false alarm: of the warning that residuals are correlated, and of the refutation of a model."""


@dataclass(frozen=True)
class Correlation:
    """Of residuals in the order of their angles: `rho` between neighbours; tests of Ljung and Box.

    `is_white`: no correlation is seen. `is_autoregressive`: what a first-order autoregression with `rho` leaves is
    white, as of slowly drifting noise; what a wrong model leaves is hardly ever so.
    """

    rho: float
    is_white: bool
    is_autoregressive: bool


def assess_correlation(residuals: Array) -> Correlation:
    """How residuals (m,) are correlated."""
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
    number of `fitted` coefficients. Equal residuals are correlated without doubt: 0.
    """
    from scipy import stats

    count, centred = len(residuals), residuals - residuals.mean()
    total = float(centred @ centred)
    if total == 0:
        return 0.0
    rho = np.array([centred[k:] @ centred[:-k] for k in range(1, lags + 1)]) / total
    statistic = count * (count + 2) * float(np.sum(rho**2 / (count - np.arange(1, lags + 1))))
    return float(stats.chi2.sf(statistic, lags - fitted))
