"""Gaps in tables over one closed turn: a curve through the points on both sides of a gap is a guess."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array

WIDEST = 5.0
"""Largest step between neighbouring rows, in medians of all steps: the tables of gear trains, which are dense where
their slope is steep, reach 3; an eighth of a turn that is missing from forty rows makes it 6."""


def find_gap(steps: Array) -> int | None:
    """Return the number of the largest of the steps (n,) > 0 between neighbouring rows if it is a gap, else None.

    >>> find_gap(np.array([10.0, 10.0, 162.0, 10.0]))
    2
    """
    largest = int(np.argmax(steps))
    return largest if steps[largest] > WIDEST * np.median(steps) else None
