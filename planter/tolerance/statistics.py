"""Statistics of rows: bands by Monte Carlo, Sobol' indices of the variance, first-order bands by gradients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import sobol_indices

from planter.errors import ComputationError
from planter.kernels import Array
from planter.tolerance.results import Band, Share
from planter.tolerance.spread import Spread

RESAMPLES, CONFIDENCE = 60, 1.96
"""Number of bootstrap samples of an index, and standard deviations to either end of its 95 % interval."""
NO_EFFECT = 1e-9
"""Share of the range of an output below which a change by an input is rounding."""


def bands(
    names: Sequence[str], rows: Array, nominal: Array, slopes: Array | None, spreads: Sequence[Spread]
) -> dict[str, Band]:
    """Return the band of each output from rows (m, k); `nominal` (k,) and slopes (k, n) are those at the centre.

    Raises ComputationError if fewer than two rows have a result.
    """
    valid = rows[~np.isnan(rows).any(axis=1)]
    if len(valid) < 2:
        raise ComputationError(f"{len(rows) - len(valid)} of {len(rows)} machines have no cycle; narrow the "
                               "tolerances")  # fmt: skip
    low, high = np.percentile(valid, (5, 95), axis=0)
    mean, std = valid.mean(axis=0), valid.std(axis=0, ddof=1)
    first = None if slopes is None else first_order_std(slopes, spreads)
    return {
        name: Band(
            nominal=float(nominal[k]), mean=float(mean[k]), std=float(std[k]), p5=float(low[k]), p95=float(high[k]),
            mean_error=float(std[k] / np.sqrt(len(valid))), missing=len(rows) - len(valid),
            first_order_std=None if first is None else float(first[k]),
        )
        for k, name in enumerate(names)
    }  # fmt: skip


def first_order_std(slopes: Array, spreads: Sequence[Spread]) -> Array:
    """Return standard deviations (k,) to first order, from slopes (k, n) in independent inputs."""
    deviations: Array = np.sqrt((slopes**2) @ np.array([spread.std for spread in spreads]) ** 2)
    return deviations


def indices(
    names: Sequence[str], inputs: Sequence[str], rows: Array, base: int, seed: int
) -> dict[str, dict[str, Share]]:
    """Return the Sobol' indices of each output in each input, from the rows of `Saltelli`.

    Raises ComputationError if a row has no result.
    """
    if np.isnan(rows).any():
        lost = int(np.isnan(rows).any(axis=1).sum())
        raise ComputationError(f"{lost} of {len(rows)} machines have no cycle: there are no Sobol' indices")
    f_a, f_b, *mixed = rows.reshape(-1, base, len(names)).transpose(0, 2, 1)
    return {
        name: _shares(inputs, f_a[k], f_b[k], np.array([matrix[k] for matrix in mixed]), seed)
        for k, name in enumerate(names)
    }


def _shares(inputs: Sequence[str], f_a: Array, f_b: Array, f_ab: Array, seed: int) -> dict[str, Share]:
    """Return the indices of an output from its values on A, B (n,) and the mixed matrices (d, n); 0 without effect."""
    has_effect = np.ptp(f_ab - f_a, axis=1) > NO_EFFECT * np.ptp(f_a)
    shares = dict.fromkeys(inputs, Share(0.0, 0.0, 0.0, 0.0))
    if not has_effect.any():
        return shares
    rng = np.random.default_rng(seed)
    estimates = _indices(f_a, f_b, f_ab[has_effect])
    samples = (rng.integers(len(f_a), size=len(f_a)) for _ in range(RESAMPLES))
    errors = CONFIDENCE * np.std(
        [_indices(f_a[rows], f_b[rows], f_ab[has_effect][:, rows]) for rows in samples], axis=0
    )
    rows = np.vstack([estimates, errors]).T
    names = np.array(inputs)[has_effect].tolist()
    return shares | {name: Share(*map(float, row)) for name, row in zip(names, rows, strict=True)}


def _indices(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """Return first and total indices, (2, d)."""
    mixed = np.concatenate([f_ab, f_ab[:1]])[:, None]  # SciPy fails on the values of a single input
    result = sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": mixed}, n=len(f_a))
    return np.array([np.ravel(result.first_order)[:-1], np.ravel(result.total_order)[:-1]])


def rank_shares(shares: Mapping[str, Share]) -> list[tuple[str, Share]]:
    """Return the inputs in the order of their total index, largest first."""
    return sorted(shares.items(), key=lambda pair: -pair[1].total)
