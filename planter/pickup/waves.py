"""Which maxima and minima of a wavy course stand out."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers


def prominent(values: Array, tolerance: float, closed: bool) -> Integers:
    """Places of the maxima and minima, which take turns in `values` (m,), that no ripple makes.

    As long as two neighbours differ by less than the tolerance, the least such pair goes, and those beside it become
    neighbours; in a `closed` course the last is the first's.
    """
    count = len(values)
    ring = count if closed else count + 1
    after, before = [(i + 1) % ring for i in range(ring)], [(i - 1) % ring for i in range(ring)]
    stands = np.ones(ring, dtype=bool)
    stands[count:] = False
    ends = [(i, after[i]) for i in range(count) if after[i] < count]
    waiting = [(abs(values[i] - values[j]), i, j) for i, j in ends]
    heapify(waiting)
    while waiting and waiting[0][0] < tolerance and count > 1:
        _, i, j = heappop(waiting)
        if not (stands[i] and stands[j]):
            continue
        stands[[i, j]], count = False, count - 2
        low, high = before[i], after[j]
        after[low], before[high] = high, low
        if stands[low] and stands[high]:
            heappush(waiting, (abs(values[low] - values[high]), low, high))
    return np.flatnonzero(stands)
