"""The points of an angle curve as a CSV file. Radians come out."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import examples
from planter.kernels import Array
from planter.mapping.curve import AngleCurve
from planter.mapping.linkage import TURN

HEADER = ["carrier_deg", "relative_deg"]
CLOSED = 1e-6
"""A turn is closed up to this [deg]."""
LEAST = 4
"""Fewest points, the closing one included: a periodic cubic needs as many."""
LARGEST = 1e6
"""Largest angle [deg]."""


def load_curve(source: str | Path) -> AngleCurve:
    """The angle curve of a CSV file, or of a built-in one by its name: one closed turn of the carrier.

    Raises InputError, naming file and line, for anything else.
    """
    lines = examples.text(source, "mapping", ".csv").splitlines()
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not numbered or [cell.strip() for cell in next(csv.reader([numbered[0][1]]))] != HEADER:
        given = numbered[0][1][:60] if numbered else ""
        raise InputError(f"{source}: the header {given!r} is not allowed: it must be {','.join(HEADER)}")
    points = np.array([_row(source, n, line) for n, line in numbered[1:]]).reshape(-1, 2)
    return _closed(str(source), [n for n, _ in numbered[1:]], points)


def _row(source: str | Path, number: int, line: str) -> tuple[float, float]:
    cells = next(csv.reader([line]))
    try:
        carrier, relative = (float(cell) for cell in cells)
        if not max(abs(carrier), abs(relative)) <= LARGEST:
            raise ValueError
    except ValueError:
        raise InputError(
            f"{source}: line {number} = {line[:60]!r} is not allowed: it must be two angles in deg"
        ) from None
    if not np.isfinite([carrier, relative]).all():
        raise InputError(f"{source}: line {number} = {line[:60]!r} is not allowed: its angles must be finite")
    return carrier, relative


def _closed(source: str, numbers: list[int], points: Array) -> AngleCurve:
    if len(points) < LEAST:
        raise InputError(f"{source}: {len(points)} points are not allowed: there must be at least {LEAST}")
    carrier, relative = points.T
    steps = np.diff(carrier)
    if steps.min() <= 0:
        k = int(np.argmin(steps)) + 1
        raise _refused(source, numbers[k], "carrier_deg", carrier[k], f"be above {carrier[k - 1]:g}, the one before")
    if abs(carrier[-1] - carrier[0] - 360) > CLOSED:
        raise _refused(
            source, numbers[-1], "carrier_deg", carrier[-1], f"be {carrier[0] + 360:g}, a turn after the first"
        )
    if abs(abs(relative[-1] - relative[0]) - 360) > CLOSED:
        allowed = f"be 360 less or more than the first, {relative[0]:g}"
        raise _refused(source, numbers[-1], "relative_deg", relative[-1], allowed)
    sense = 1 if relative[-1] > relative[0] else -1
    theta, y = np.radians(carrier), np.radians(relative)
    return AngleCurve(np.append(theta[:-1], theta[0] + TURN), np.append(y[:-1], y[0] + sense * TURN), sense)


def _refused(source: str, line: int, key: str, value: float, allowed: str) -> InputError:
    return InputError(f"{source}: line {line}: {key} = {value:.10g} is not allowed: it must {allowed}")
