"""Moments at which a drawing's lines are sampled: as many as it takes for straight pieces to follow the curves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

TOLERANCE = 5e-4
"""How far a straight piece may be from its curve, in parts of the curve's range: less than can be seen."""
ROUNDS = 7
"""How often a piece is halved at most: a jump is drawn within 1/128 of the first moments' distance."""
Rows = Callable[[Array], Sequence[Array] | Array]
"""Series (n,) that are drawn, at places (n,) in order; angles must be unwrapped along these."""


def refine_places(rows: Rows, places: Array) -> Array:
    """Return places (m,), those in order (n,) and others between them, at which straight pieces follow all rows.

    A piece is halved as long as the middle of it is off by more than TOLERANCE of a row's range. What lies wholly
    between two of the first places is missed, so that zeros and corners that are known belong among these.
    """
    whole = np.ones(len(places) - 1, dtype=bool)
    for _ in range(ROUNDS):
        cells = np.flatnonzero(whole)
        if not len(cells):
            break
        middles = (places[cells] + places[cells + 1]) / 2
        both = np.insert(places, cells + 1, middles)
        at = cells + 1 + np.arange(len(cells))
        bad = _strayed(np.array([np.asarray(row, dtype=float) for row in rows(both)]), at)
        # Good middles go again; pieces beside a bad one are looked at once more.
        keep = np.ones(len(both), dtype=bool)
        keep[at[~bad]] = False
        fresh = np.zeros(len(both), dtype=bool)
        fresh[at[bad]] = True
        fresh = fresh[keep]
        places = both[keep]
        whole = fresh[1:] | fresh[:-1]
    return places


def _strayed(values: Array, at: Integers) -> Flags:
    """Which of the middles `at` (k,) of pieces are off the straight line between their neighbours, in any row."""
    sizes = np.ptp(values, axis=1)
    off = np.abs(values[:, at] - (values[:, at - 1] + values[:, at + 1]) / 2)
    found: Flags = (off > TOLERANCE * sizes[:, None]).any(axis=0)
    return found
