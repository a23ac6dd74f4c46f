"""Branch and bound: boxes of designs, the one with the least bound first, halved where their bounds are loose."""

from __future__ import annotations

import heapq
import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.balls import Unbounded
from planter.optimise.proof.objective import Bounds

Bounding = Callable[[Array, Array], Bounds]
"""(lower, upper) -> bounds of an objective over that box; raises Unbounded where there are none."""
Told = Callable[[float, int, float], None]
"""Told the bound so far, the number of boxes and the seconds."""


@dataclass(frozen=True)
class Box:
    """Designs between `lower` and `upper` (p,): no objective below `least`; halved along `widest`, None: a point.

    `obstacle` says why it has no bound of its own.
    """

    least: float
    lower: Array
    upper: Array
    widest: int | None
    obstacle: str = ""

    def halves(self) -> list[tuple[Array, Array]]:
        if self.widest is None:
            return []
        side = self.widest
        below, above = self.upper.copy(), self.lower.copy()
        below[side] = above[side] = self.lower[side] + (self.upper[side] - self.lower[side]) / 2
        return [(self.lower, below), (above, self.upper)]


@dataclass(frozen=True)
class Bounded:
    """No design of a box has an objective below `least`; `met` is the least that a box's centre was seen to have.

    `obstacle` says why the box that holds `least` has no bound of its own; it is empty if it has one.
    """

    least: float
    met: float
    boxes: int
    seconds: float
    obstacle: str = ""


SHRUNK = (0.25, 0.0625)
"""Shares of a box, about its centre, that are tried for where to halve one that has no bound of its own."""


class Search:
    """Bounds an objective over a box [lower, upper] (p,) from below; `floor` is a bound known beforehand."""

    def __init__(self, bounding: Bounding, lower: Array, upper: Array, floor: float = -np.inf) -> None:
        self.bounding, self.floor = bounding, floor
        self.lower, self.upper = lower, upper
        self.boxes, self.met = 0, np.inf

    def run(self, goal: float, seconds: float, told: Told | None = None) -> Bounded:
        """Until the bound is at `goal`, or the time is up."""
        begun, order = time.perf_counter(), itertools.count()
        whole = self._bounded(self.lower, self.upper, self.floor)
        open_ = [(whole.least, next(order), whole)]
        while True:
            least, _, box = open_[0]
            spent = time.perf_counter() - begun
            if told is not None:
                told(least, self.boxes, spent)
            if least >= goal or spent >= seconds or box.widest is None:
                return Bounded(least, float(self.met), self.boxes, spent, box.obstacle)
            heapq.heappop(open_)
            for lower, upper in box.halves():
                half = self._bounded(lower, upper, least)
                heapq.heappush(open_, (half.least, next(order), half))

    def _bounded(self, lower: Array, upper: Array, least: float) -> Box:
        """A box with its bound; directions along which the objective only rises or only falls put on their side."""
        while True:
            self.boxes += 1
            try:
                found = self.bounding(lower, upper)
            except Unbounded as error:
                return Box(least, lower, upper, self._widest(lower, upper), error.message)
            least, self.met = max(least, found.least), min(self.met, found.reached)
            open_ = upper > lower
            rising, falling = open_ & (found.slopes.low >= 0), open_ & (found.slopes.high <= 0) & (found.slopes.low < 0)
            if found.may_jump or not (rising | falling).any():
                loose = np.where(open_, found.looseness, -1)
                return Box(least, lower, upper, int(loose.argmax()) if open_.any() else None)
            lower, upper = np.where(falling, upper, lower), np.where(rising, lower, upper)

    def _widest(self, lower: Array, upper: Array) -> int | None:
        """Where to halve a box without bounds: as a part of it tells, or else along its relatively widest side."""
        centre, half = lower + (upper - lower) / 2, (upper - lower) / 2
        for share in SHRUNK:
            try:
                loose = self.bounding(centre - share * half, centre + share * half).looseness
            except Unbounded:
                continue
            return int(loose.argmax())
        whole = self.upper - self.lower
        share_of = np.divide(upper - lower, whole, out=np.zeros_like(lower), where=whole > 0)
        return int(share_of.argmax()) if share_of.any() else None
