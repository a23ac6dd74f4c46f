"""Angles and directions, gaps in tables, and a cache of the last call of a function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

from planter.kernels import Array

TURN = 2 * np.pi
"""One revolution [rad]."""
MAX_GAP_RATIO = 5.0
"""Largest step between neighbouring rows, in medians of all steps: the tables of gear trains, which
are dense where their slope is steep, reach 3; an eighth of a turn that is missing from forty rows
makes it 6.
"""
Angle = TypeVar("Angle", float, Array)
T = TypeVar("T")


def wrap_angle(angle: Angle, period: float = TURN) -> Angle:
    """Return an angle, or difference of angles, reduced to [-period/2, period/2) [rad]."""
    wrapped: Angle = np.mod(angle + period / 2, period) - period / 2
    return wrapped


def unit_vector(angle: float | Array) -> Array:
    """Return the unit vector of an angle [rad], (2,) or (2, n)."""
    return np.array([np.cos(angle), np.sin(angle)])


def rotation_matrix(angle: float) -> Array:
    """Return the matrix (2, 2) of an anticlockwise rotation [rad].

    >>> rotation_matrix(np.pi).round() @ [3.0, 1.0]
    array([-3., -1.])
    """
    c, s = unit_vector(angle)
    return np.array([[c, -s], [s, c]])


def double_area(a: Any, b: Any, c: Any) -> Any:
    """Return twice the signed area of the triangle a, b, c, positive if anticlockwise.

    Points are pairs of numbers, of arrays (n,) or of graphs.
    """
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def to_degrees(angle: float) -> float:
    """Return an angle [rad] in degrees for display, in [0, 360)."""
    degrees = float(np.degrees(angle % TURN))
    return degrees if degrees < 360 else 0.0


def find_gap(steps: Array) -> int | None:
    """Return the index of the largest of the steps (n,) > 0 between neighbouring rows if it is a
    gap, else None.

    A curve through the points on both sides of a gap would be a guess.

    >>> find_gap(np.array([10.0, 10.0, 162.0, 10.0]))
    2
    """
    largest = int(np.argmax(steps))
    return largest if steps[largest] > MAX_GAP_RATIO * np.median(steps) else None


class LastCallCache(Generic[T]):
    """Function of an array with the result of the last call cached: solvers ask for value, slope,
    curvature in turn.
    """

    def __init__(self, function: Callable[[Array], T]) -> None:
        self._function = function
        self._last: tuple[bytes, T] | None = None

    def __call__(self, x: Array) -> T:
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._function(x)
        return self._last[1]
