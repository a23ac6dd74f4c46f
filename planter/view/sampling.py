"""Adaptive sampling of curves, so that straight segments follow them closely enough for a drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

TOLERANCE = 5e-4
"""Maximum deviation of a segment from its curve, relative to the range of the curve; it is invisible."""
ROUNDS = 7
"""Maximum number of bisections of a segment: a jump is drawn within 1/128 of the initial spacing."""
Rows = Callable[[Array], Sequence[Array] | Array]
"""Function that returns series (n,) at ordered positions (n,); angles must be unwrapped."""


def refine_places(rows: Rows, places: Array) -> Array:
    """Return the ordered places (n,) with more places between them, (m,), where straight segments follow all rows.

    A segment is bisected as long as its middle deviates by more than TOLERANCE of the range of a row. A detail between
    two of the initial places can be missed, so that these must include known zeros and corners.
    """
    unresolved = np.ones(len(places) - 1, dtype=bool)
    for _ in range(ROUNDS):
        cells = np.flatnonzero(unresolved)
        if not len(cells):
            break
        middles = (places[cells] + places[cells + 1]) / 2
        both = np.insert(places, cells + 1, middles)
        at = cells + 1 + np.arange(len(cells))
        bad = _deviates(np.array([np.asarray(row, dtype=float) for row in rows(both)]), at)
        # Good middles are removed; segments next to a bad one are checked again.
        keep = np.ones(len(both), dtype=bool)
        keep[at[~bad]] = False
        fresh = np.zeros(len(both), dtype=bool)
        fresh[at[bad]] = True
        fresh = fresh[keep]
        places = both[keep]
        unresolved = fresh[1:] | fresh[:-1]
    return places


def _deviates(values: Array, at: Integers) -> Flags:
    """Return whether the points at indices `at` (k,) deviate from the chord of their neighbours in any row, (k,)."""
    sizes = np.ptp(values, axis=1)
    off = np.abs(values[:, at] - (values[:, at - 1] + values[:, at + 1]) / 2)
    is_off: Flags = (off > TOLERANCE * sizes[:, None]).any(axis=0)
    return is_off
