"""Simultaneous equations without a root in a domain: it is divided, and parts that can hold none are left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.balls import Ball, Unbounded

Equations = Callable[[Sequence[Ball], Integers], tuple[Sequence[Ball], Sequence[Sequence[Ball]]]]
"""Balls (k,) of unknowns in some lanes -> f (k,) and its Jacobian (k, k) there, enclosed."""
DIVISIONS = 12
"""So often the parts of a domain are halved."""
MOST_PARTS = 4096
"""Parts of all lanes that are divided further: those of the lanes that have the fewest."""


def has_rootless_lane(equations: Equations, low: Array, high: Array, lanes: int) -> bool:
    """Return whether equations have certainly no root between `low` and `high` (k,) in at least one of some lanes."""
    lane, open_lanes = np.arange(lanes), np.arange(lanes)
    below, above = (np.repeat(side[:, None], lanes, axis=1) for side in (low, high))
    for _ in range(DIVISIONS):
        with np.errstate(all="ignore"):  # parts without a root have no points
            below, above = _contract(equations, below, above, lane)
        kept = np.flatnonzero((below <= above).all(axis=0))
        counts = np.bincount(lane[kept], minlength=lanes)[open_lanes]
        if not counts.all():
            return True
        order = np.argsort(counts, kind="stable")
        open_lanes = open_lanes[order[np.cumsum(counts[order]) <= MOST_PARTS]]
        kept = kept[np.isin(lane[kept], open_lanes)]
        if not len(kept):
            return False
        below, above, lane = below[:, kept], above[:, kept], lane[kept]
        widest = ((above - below) / (high - low)[:, None]).argmax(axis=0)
        here, middle = np.arange(len(lane)), below + (above - below) / 2
        ends, starts = above.copy(), below.copy()
        ends[widest, here] = starts[widest, here] = middle[widest, here]
        below, above = np.concatenate([below, starts], axis=1), np.concatenate([ends, above], axis=1)
        lane = np.concatenate([lane, lane])
    return False


def _contract(equations: Equations, low: Array, high: Array, lane: Integers) -> tuple[Array, Array]:
    """Return parts (k, n) without margins that hold no root; where one holds none, `low` is above `high`.

    By the mean value theorem a root is at m - f(m) / f' in each unknown, m a point in it, all others anywhere.
    """
    low, high = low.copy(), high.copy()
    values, slopes = equations([Ball.between(*side) for side in zip(low, high, strict=True)], lane)
    for value in values:
        rootless = (value.low > 0) | (value.high < 0)
        low[:, rootless], high[:, rootless] = np.inf, -np.inf
    for j in range(len(low)):
        point = [Ball.between(*side) for side in zip(low, high, strict=True)]
        point[j] = Ball.exact(point[j].mid)
        values, _ = equations(point, lane)
        for value, row in zip(values, slopes, strict=True):
            try:
                root = point[j] - value / row[j]
            except Unbounded:
                continue
            low[j], high[j] = np.fmax(low[j], root.low), np.fmin(high[j], root.high)
    return low, high
