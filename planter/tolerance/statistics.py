"""What the rows say: bands by Monte Carlo, shares of the variance by Sobol' indices, first-order bands by gradients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import sobol_indices

from planter.errors import ComputationError
from planter.kernels import Array
from planter.tolerance.results import Band, Share
from planter.tolerance.spread import Spread

RESAMPLES, SURE = 60, 1.96
"""Of the bootstrap that says how sure an index is: how often, and standard deviations to either end of 95 %."""
UNFELT = 1e-9
"""An output does not feel an input that moves it by less than this share of its range."""


def bands(
    names: Sequence[str], rows: Array, nominal: Array, slopes: Array | None, spreads: Sequence[Spread]
) -> dict[str, Band]:
    """The band of each output from rows (m, k); `nominal` (k,) and slopes (k, n) are those at the centre.

    Raises ComputationError where no row has a result.
    """
    there = rows[~np.isnan(rows).any(axis=1)]
    if len(there) < 2:
        raise ComputationError(f"{len(rows) - len(there)} of {len(rows)} machines have no turn: their tolerances are "
                               "too wide")  # fmt: skip
    low, high = np.percentile(there, (5, 95), axis=0)
    mean, std = there.mean(axis=0), there.std(axis=0, ddof=1)
    first = None if slopes is None else first_order(slopes, spreads)
    return {
        name: Band(
            nominal=float(nominal[k]), mean=float(mean[k]), std=float(std[k]), p5=float(low[k]), p95=float(high[k]),
            mean_error=float(std[k] / np.sqrt(len(there))), missing=len(rows) - len(there),
            first_order_std=None if first is None else float(first[k]),
        )
        for k, name in enumerate(names)
    }  # fmt: skip


def first_order(slopes: Array, spreads: Sequence[Spread]) -> Array:
    """Standard deviations (k,) to first order, from slopes (k, n) in independent inputs."""
    found: Array = np.sqrt((slopes**2) @ np.array([one.std for one in spreads]) ** 2)
    return found


def indices(
    names: Sequence[str], inputs: Sequence[str], rows: Array, base: int, seed: int
) -> dict[str, dict[str, Share]]:
    """Sobol' indices of each output in each input, from the rows of `Saltelli`.

    Raises ComputationError where a row has no result.
    """
    if np.isnan(rows).any():
        lost = int(np.isnan(rows).any(axis=1).sum())
        raise ComputationError(f"{lost} of {len(rows)} machines have no turn: there are no Sobol' indices")
    f_a, f_b, *mixed = rows.reshape(-1, base, len(names)).transpose(0, 2, 1)
    return {
        name: _shares(inputs, f_a[k], f_b[k], np.array([one[k] for one in mixed]), seed) for k, name in enumerate(names)
    }


def _shares(inputs: Sequence[str], f_a: Array, f_b: Array, f_ab: Array, seed: int) -> dict[str, Share]:
    """Indices of an output from its values on A, B (n,) and on the mixed matrices (d, n); 0 of what is not felt."""
    felt = np.ptp(f_ab - f_a, axis=1) > UNFELT * np.ptp(f_a)
    found = dict.fromkeys(inputs, Share(0.0, 0.0, 0.0, 0.0))
    if not felt.any():
        return found
    rng = np.random.default_rng(seed)
    told = _indices(f_a, f_b, f_ab[felt])
    again = (rng.integers(len(f_a), size=len(f_a)) for _ in range(RESAMPLES))
    errors = SURE * np.std([_indices(f_a[rows], f_b[rows], f_ab[felt][:, rows]) for rows in again], axis=0)
    named = [name for name, is_felt in zip(inputs, felt, strict=True) if is_felt]
    return found | {name: Share(*map(float, row)) for name, row in zip(named, np.vstack([told, errors]).T, strict=True)}


def _indices(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """First and total indices, (2, d)."""
    mixed = np.concatenate([f_ab, f_ab[:1]])[:, None]  # SciPy fails on the values of a single input
    found = sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": mixed}, n=len(f_a))
    return np.array([np.ravel(found.first_order)[:-1], np.ravel(found.total_order)[:-1]])


def ranked(shares: Mapping[str, Share]) -> list[tuple[str, Share]]:
    """Inputs by their total index, largest first."""
    return sorted(shares.items(), key=lambda pair: -pair[1].total)
