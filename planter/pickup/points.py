"""A CSV of points of a path: lines that start with `#`, then the header x_mm,y_mm, then a point a line."""

from __future__ import annotations

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows
from planter.kernels import Array
from planter.numerics.spacing import WIDEST, find_gap

HEADER = ("x_mm", "y_mm")
LEAST = 12
"""Points that a path needs."""
LARGEST = 1e6
"""Largest coordinate [mm]."""
_FINEST = 300


def parse_points(text: str, source: str) -> tuple[Array, float]:
    """The points (n, 2) in m of a closed path, and the last decimal place that they are given to [m].

    A last point that repeats the first is left out. Raises InputError, naming file, line and what is allowed.
    """
    table = csv_rows.read(text, source, HEADER)
    points = np.column_stack([table.numbers(name, LARGEST) for name in HEADER])
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if len(points) < LEAST:
        raise InputError(f"{source}: {len(points)} points are not enough: there must be at least {LEAST}")
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    for i, step in enumerate(steps, 1):
        if step == 0:
            raise InputError(f"{source}: point {i} is given twice in a row: neighbours must differ")
    gap = find_gap(steps)
    if gap is not None:
        raise InputError(
            f"{source}: points {gap + 1} and {(gap + 1) % len(points) + 1} are {steps[gap]:.4g} mm apart, which is not "
            f"allowed: on a closed path neighbours must be within {WIDEST:g} times the median distance, "
            f"{np.median(steps):.4g} mm"
        )
    return points / 1000, 10.0 ** -max(_places(cell) for row in table.rows for cell in row) / 1000


def _places(cell: str) -> int:
    """Decimal places of a number.

    >>> _places("1.250"), _places("2"), _places("1.5e-3")
    (3, 0, 4)
    """
    digits, _, power = cell.lower().partition("e")
    return min(len(digits.partition(".")[2]) - int(power or 0), _FINEST)
