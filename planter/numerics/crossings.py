"""Angles of a cycle at which functions cross zero, or whole numbers of their periods."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.kernels import Array
from planter.numerics import roots
from planter.numerics.arrays import Integers


def find_crossings(
    values: Callable[[Array], Array], derivatives: Callable[[Array], tuple[Array, Array]], periods: Array, count: int,
    cycle: float,
) -> tuple[Array, Integers]:  # fmt: skip
    """Return the angles (s,) in [0, cycle) at which functions (m,) cross, in order, and the rows of these functions.

    `values` (m, n) at angles (n,) are scanned in `count` steps of a cycle, `derivatives` gives them with their slopes;
    `periods` (m,) are infinite for functions that cross zero alone. Two crossings of a function in one step are missed.
    Steps begin half a step before the angle zero: functions often cross at whole steps, where rounding would decide in
    which of two steps they do.
    """
    grid = cycle * (np.arange(count + 1) - 0.5) / count
    scanned, endless = values(grid), np.isinf(periods)[:, None]
    turns = np.where(endless, np.where(scanned < 0, -1.0, 0.0), np.floor(scanned / periods[:, None]))
    rows, cells = np.nonzero(turns[:, 1:] != turns[:, :-1])
    if not len(rows):
        return np.empty(0), rows
    levels = np.maximum(turns[rows, cells], turns[rows, cells + 1]) * np.where(np.isinf(periods), 0.0, periods)[rows]
    lanes = np.arange(len(rows))

    def function(phi: Array) -> tuple[Array, Array]:
        found, slopes = derivatives(phi)
        return found[rows, lanes] - levels, slopes[rows, lanes]

    ends = scanned[rows, cells] - levels, scanned[rows, cells + 1] - levels
    angles = np.mod(roots.newton(function, grid[cells], grid[cells + 1], ends), cycle)
    order = np.argsort(angles, kind="stable")
    return angles[order], rows[order]
