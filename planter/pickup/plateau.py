"""Where the tip keeps its distance from the sun's centre: the arm dwells, and the tip moves on a circle."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.kernels import Array

LEAST_SWEEP = np.radians(5)
"""Angle at the sun's centre that a run of equal distances must cover: near an extreme they are nearly equal, too."""
LEAST_POINTS = 3


@dataclass(frozen=True)
class Plateau:
    """Indices of the points in the dwell, in order, and of the others, from the dwell's end round to its start."""

    members: Any
    toothed: Any


def plateau(points: Array, tolerance: float) -> Plateau | None:
    """The longest run of points (n, 2) of a closed path whose distances from the origin are equal."""
    distance = np.hypot(*points.T)
    if np.ptp(distance) <= tolerance:
        return None
    begin, count = _longest(distance, tolerance)
    members = (begin + np.arange(count)) % len(points)
    if count < LEAST_POINTS or _sweep(points[members]) < LEAST_SWEEP:
        return None
    return Plateau(members, (begin + count + np.arange(len(points) - count)) % len(points))


def _sweep(places: Array) -> float:
    """Angle that a run of places covers at the origin."""
    directions = np.unwrap(np.arctan2(places[:, 1], places[:, 0]))
    return float(abs(directions[-1] - directions[0]))


def _longest(distance: Array, tolerance: float) -> tuple[int, int]:
    """Start and length of the longest cyclic run whose values differ by the tolerance at most.

    `highs` and `lows` hold the places in the run that may yet be its greatest or its least value, in order.
    """
    values = [*distance.tolist(), *distance.tolist()]
    highs: deque[int] = deque()
    lows: deque[int] = deque()
    begin, best = 0, (0, 0)
    for end, value in enumerate(values):
        for run, sign in ((highs, 1), (lows, -1)):
            while run and sign * values[run[-1]] <= sign * value:
                run.pop()
            run.append(end)
        while values[highs[0]] - values[lows[0]] > tolerance:
            begin += 1
            for run in (highs, lows):
                if run[0] < begin:
                    run.popleft()
        if end + 1 - begin > best[1]:
            best = begin, end + 1 - begin
    return best
