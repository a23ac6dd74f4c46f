"""The angle curve and its file: rotation of the arm relative to the carrier over a cycle, a
periodic C2 cubic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy

from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.kernels import Array
from planter.numerics.arrays import MAX_GAP_RATIO, TURN, find_gap
from planter.numerics.extrema import ExtremePoint, index_first_extremum


@dataclass(frozen=True)
class AngleCurve:
    """Points (n,) [rad] of a turn, the last one a turn of the carrier after the first.

    `sense` is -1 where the arm falls behind by a turn, as two external meshes have it, +1 where it
    gains one. Slopes are d(relative rotation)/d(carrier angle), taken positive along `sense`.
    """

    carrier: Array
    relative: Array
    sense: int = -1

    @cached_property
    def _periodic(self) -> scipy.interpolate.CubicSpline:
        """The rotation less that of a uniform turn."""
        rest = self.relative - self.sense * self.carrier
        return scipy.interpolate.CubicSpline(
            self.carrier, np.append(rest[:-1], rest[0]), bc_type="periodic"
        )

    def at(self, theta: Array) -> Array:
        """Relative rotation [rad] at any carrier angles [rad]."""
        return self._periodic(theta) + self.sense * np.asarray(theta)

    def slopes(self, theta: Array) -> Array:
        """Slope and its first two derivatives (3, n); at a point of the curve, the last is that to
        the right.
        """
        uniform = np.array([[1.0], [0.0], [0.0]])
        orders = (self.sense * self._periodic(np.atleast_1d(theta), order) for order in (1, 2, 3))
        return np.array(list(orders)) + uniform

    @cached_property
    def extremes(self) -> tuple[ExtremePoint, ExtremePoint]:
        """Least and largest slope [-] with their carrier angles [rad], the first of equal ones:
        parabolas have them at the points or at a vertex.
        """
        starts, widths = self.carrier[:-1], np.diff(self.carrier)
        slope, first, second = self.slopes(starts)
        inside = np.clip(
            np.divide(-first, second, out=np.zeros_like(first), where=second != 0), 0, widths
        )
        angles = np.concatenate([starts, starts + inside])
        values = np.concatenate([slope, slope + first * inside + second * inside**2 / 2])
        low, high = (index_first_extremum(angles, values, sign) for sign in (-1, 1))
        return (
            ExtremePoint(float(angles[low]), float(values[low])),
            ExtremePoint(float(angles[high]), float(values[high])),
        )

    @property
    def monotone(self) -> bool:
        return self.extremes[0].value > 0

    def find_zero_slope(self) -> float:
        """The first carrier angle [rad] at which the slope is not positive."""
        theta = np.unique(
            np.concatenate([np.linspace(self.carrier[0], self.carrier[-1], 7201), self.carrier])
        )
        slope = self.slopes(theta)[0]
        stopped = np.flatnonzero(slope <= 0)
        return float(theta[stopped[0]]) if len(stopped) else self.extremes[0].place


def unwrap_rotations(relative: Array) -> Array:
    """Relative rotations [rad] with whole turns added so that each lies less than a turn on from
    the one before.
    """
    angles = [float(relative[0])]
    for value in relative[1:]:
        angles.append(angles[-1] - float(np.mod(angles[-1] - value, TURN)))
    return np.array(angles)


def closed_turn(carrier: Array, relative: Array, sense: int = -1) -> AngleCurve:
    """The curve through points (n,) within a turn of the carrier, ordered by its angle, and the
    first one again.
    """
    order = np.argsort(carrier)
    theta, y = carrier[order], relative[order]
    return AngleCurve(np.append(theta, theta[0] + TURN), np.append(y, y[0] + sense * TURN), sense)


HEADER = ("carrier_deg", "relative_deg")
CLOSED = 1e-6
"""A turn is closed up to this [deg]."""
_ROUNDED = 0.01
LEAST = 4
"""Fewest points, the closing one included: a periodic cubic needs as many."""
LARGEST = 1e6
"""Largest angle [deg]."""


def load_curve(source: str | Path) -> AngleCurve:
    """The angle curve of a CSV file, or of a built-in one by its name: one closed turn of the
    carrier.

    Raises InputError, naming file and line, for anything else.
    """
    table = csv_rows.read_table(
        examples.read_source(source, "mapping", ".csv"), str(source), HEADER
    )
    places = [f"line {line}" for line in table.lines]
    return close_curve(
        str(source), places, np.column_stack([table.numbers(name, LARGEST) for name in HEADER])
    )


def close_curve(source: str, places: Sequence[str], points: Array) -> AngleCurve:
    """Return the curve through points (n, 2) [deg] of one closed turn, with their places in a file.

    Raises InputError, naming file and place, for points that are none.
    """
    if len(points) < LEAST:
        raise InputError(f"{source}: {len(points)} points: there must be at least {LEAST}")
    carrier, relative = points.T
    steps = np.diff(carrier)
    if steps.min() <= 0:
        k = int(np.argmin(steps)) + 1
        raise _refused(
            source,
            places[k],
            "carrier_deg",
            carrier[k],
            f"be above {carrier[k - 1]:g}, the one before",
        )
    if abs(carrier[-1] - carrier[0] - 360) > CLOSED:
        hint = " (are these radians?)" if abs(carrier[-1] - carrier[0] - TURN) < _ROUNDED else ""
        allowed = f"be {carrier[0] + 360:g}, a turn after the first{hint}"
        raise _refused(source, places[-1], "carrier_deg", carrier[-1], allowed)
    if abs(abs(relative[-1] - relative[0]) - 360) > CLOSED:
        same = abs(relative[-1] - relative[0]) <= CLOSED
        hint = (
            " (is this the arm's own angle? then the carrier's must be taken from it)"
            if same
            else ""
        )
        allowed = f"be 360 less or more than the first, {relative[0]:g}{hint}"
        raise _refused(source, places[-1], "relative_deg", relative[-1], allowed)
    gap = find_gap(steps)
    if gap is not None:
        allowed = (
            f"be at most {MAX_GAP_RATIO:g} times the median step, {np.median(steps):.4g} deg, "
            f"beyond {carrier[gap]:g}, the one before: a curve over a gap is a guess"
        )
        raise _refused(source, places[gap + 1], "carrier_deg", carrier[gap + 1], allowed)
    sense = 1 if relative[-1] > relative[0] else -1
    theta, y = np.radians(carrier), np.radians(relative)
    return AngleCurve(
        np.append(theta[:-1], theta[0] + TURN), np.append(y[:-1], y[0] + sense * TURN), sense
    )


def _refused(source: str, place: str, key: str, value: float, allowed: str) -> InputError:
    return InputError(f"{source}: {place}: {key} = {value:.10g}: it must {allowed}")
