"""Tests of residuals for white noise and for noise with correlated neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array

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
