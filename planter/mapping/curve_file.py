"""The points of an angle curve as a CSV file. Angles are returned in radians."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.kernels import Array
from planter.mapping.curve import AngleCurve
from planter.numerics.arrays import MAX_GAP_RATIO, TURN, find_gap

HEADER = ("carrier_deg", "relative_deg")
CLOSED = 1e-6
"""A turn is closed up to this [deg]."""
_ROUNDED = 0.01
LEAST = 4
"""Fewest points, the closing one included: a periodic cubic needs as many."""
LARGEST = 1e6
"""Largest angle [deg]."""


def load_curve(source: str | Path) -> AngleCurve:
    """The angle curve of a CSV file, or of a built-in one by its name: one closed turn of the carrier.

    Raises InputError, naming file and line, for anything else.
    """
    table = csv_rows.read(examples.text(source, "mapping", ".csv"), str(source), HEADER)
    places = [f"line {line}" for line in table.lines]
    return close_curve(str(source), places, np.column_stack([table.numbers(name, LARGEST) for name in HEADER]))


def close_curve(source: str, places: Sequence[str], points: Array) -> AngleCurve:
    """Return the curve through points (n, 2) [deg] of one closed turn, with their places in a file.

    Raises InputError, naming file and place, for points that are none.
    """
    if len(points) < LEAST:
        raise InputError(f"{source}: {len(points)} points are not allowed: there must be at least {LEAST}")
    carrier, relative = points.T
    steps = np.diff(carrier)
    if steps.min() <= 0:
        k = int(np.argmin(steps)) + 1
        raise _refused(source, places[k], "carrier_deg", carrier[k], f"be above {carrier[k - 1]:g}, the one before")
    if abs(carrier[-1] - carrier[0] - 360) > CLOSED:
        hint = " (are these radians?)" if abs(carrier[-1] - carrier[0] - TURN) < _ROUNDED else ""
        allowed = f"be {carrier[0] + 360:g}, a turn after the first{hint}"
        raise _refused(source, places[-1], "carrier_deg", carrier[-1], allowed)
    if abs(abs(relative[-1] - relative[0]) - 360) > CLOSED:
        same = abs(relative[-1] - relative[0]) <= CLOSED
        hint = " (is this the arm's own angle? then the carrier's must be taken from it)" if same else ""
        allowed = f"be 360 less or more than the first, {relative[0]:g}{hint}"
        raise _refused(source, places[-1], "relative_deg", relative[-1], allowed)
    gap = find_gap(steps)
    if gap is not None:
        allowed = (
            f"be at most {MAX_GAP_RATIO:g} times the median step, {np.median(steps):.4g} deg, beyond {carrier[gap]:g}, "
            "the one before: a curve over a gap is a guess"
        )
        raise _refused(source, places[gap + 1], "carrier_deg", carrier[gap + 1], allowed)
    sense = 1 if relative[-1] > relative[0] else -1
    theta, y = np.radians(carrier), np.radians(relative)
    return AngleCurve(np.append(theta[:-1], theta[0] + TURN), np.append(y[:-1], y[0] + sense * TURN), sense)


def _refused(source: str, place: str, key: str, value: float, allowed: str) -> InputError:
    return InputError(f"{source}: {place}: {key} = {value:.10g} is not allowed: it must {allowed}")
