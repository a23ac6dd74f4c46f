"""A CSV of points of a path: lines that start with `#`, then the header x_mm,y_mm, then a point a line."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from decimal import Decimal

import numpy as np

from planter.errors import InputError
from planter.kernels import Array

HEADER = ("x_mm", "y_mm")
LEAST = 12
"""Points that a path needs."""


def parse_points(text: str, source: str) -> Array:
    """The points (n, 2) in m of a closed path; a last point that repeats the first is left out.

    Raises InputError that names the file, the line and what is allowed.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    header = tuple(name.strip() for name in lines[0][1].split(",")) if lines else ()
    if header != HEADER:
        raise InputError(f"{source}: the header {','.join(header)!r} is not allowed: it must be {','.join(HEADER)}")
    points = np.array(list(_rows(lines[1:], source))).reshape(-1, 2)
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if len(points) < LEAST:
        raise InputError(f"{source}: {len(points)} points are not enough: there must be at least {LEAST}")
    for i, step in enumerate(np.hypot(*(np.roll(points, -1, axis=0) - points).T), 1):
        if step == 0:
            raise InputError(f"{source}: point {i} is given twice in a row: neighbours must differ")
    return points / 1000


def resolution(text: str) -> float:
    """Last decimal place that the numbers of a CSV are given to [m]: that of the most exact one."""
    lines = [line for line in text.splitlines() if line.strip() and line[0] != "#"][1:]
    cells = (Decimal(cell.strip()).as_tuple().exponent for line in lines for cell in line.split(","))
    return 10.0 ** min((int(exponent) for exponent in cells), default=0) / 1000


def _rows(lines: list[tuple[int, str]], source: str) -> Iterator[tuple[float, float]]:
    for (number, line), cells in zip(lines, csv.reader(line for _, line in lines), strict=True):
        try:
            x, y = (float(cell) for cell in cells)
        except ValueError:
            raise InputError(f"{source}: line {number}: {line!r} is not allowed: it must be two numbers") from None
        if not math.isfinite(x + y) or max(abs(x), abs(y)) > 1e6:
            raise InputError(f"{source}: line {number}: {line!r} is not allowed: it must be finite and below 1e6 mm")
        yield x, y
