"""Branch and bound: boxes of designs, the one with the least bound first, halved where their bounds are loose."""

from __future__ import annotations

import heapq
import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.balls import Unbounded
from planter.optimise.proof.objective import Bounds

Bounding = Callable[[Array, Array], Bounds]
"""(lower, upper) -> bounds of an objective over that box; raises Unbounded where there are none."""

BoundBoxes = Callable[[Sequence[tuple[Array, Array]]], Sequence[Bounds | Unbounded]]
"""Boxes [lower, upper] -> for each, the bounds of an objective over it, or why there are none."""
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

    def shrink(self, share: float) -> tuple[Array, Array]:
        """Return a share of the box about its centre."""
        centre, half = self.lower + (self.upper - self.lower) / 2, (self.upper - self.lower) / 2
        return centre - share * half, centre + share * half

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
    """Bounds an objective over a box [lower, upper] (p,) from below; `floor` is a bound known beforehand.

    `bound_boxes` bounds it over up to `batch` boxes at once, where that takes less time than one after another.
    """

    def __init__(
        self, bounding: Bounding, lower: Array, upper: Array, floor: float = -np.inf, batch: int = 1,
        bound_boxes: BoundBoxes | None = None,
    ) -> None:  # fmt: skip
        self.bounding, self.floor = bounding, floor
        self.lower, self.upper = lower, upper
        self.batch, self.bound_boxes = batch, bound_boxes or self._bound_each
        self.boxes, self.met = 0, np.inf

    def run(self, goal: float, seconds: float, told: Told | None = None) -> Bounded:
        """Until the bound is at `goal`, or the time is up."""
        begun, order = time.perf_counter(), itertools.count()
        (whole,) = self._bound([(self.lower, self.upper, self.floor)])
        open_ = [(whole.least, next(order), whole)]
        while True:
            least, _, box = open_[0]
            spent = time.perf_counter() - begun
            if told is not None:
                told(least, self.boxes, spent)
            if least >= goal or spent >= seconds or box.widest is None:
                return Bounded(least, float(self.met), self.boxes, spent, box.obstacle)
            halves: list[tuple[Array, Array, float]] = []
            while open_ and open_[0][0] < goal and open_[0][2].widest is not None and len(halves) < max(2, self.batch):
                least, _, box = heapq.heappop(open_)
                halves += [(lower, upper, least) for lower, upper in box.halves()]
            for half in self._bound(halves):
                heapq.heappush(open_, (half.least, next(order), half))

    def _bound(self, boxes: Sequence[tuple[Array, Array, float]]) -> list[Box]:
        """Return boxes [lower, upper] that no objective is below some number in, with their bounds.

        Directions along which the objective only rises or only falls are put on their side.
        """
        waiting, bounded, unbounded = list(boxes), list[Box](), list[Box]()
        while waiting:
            self.boxes += len(waiting)
            pairs, waiting = zip(waiting, self.bound_boxes([box[:2] for box in waiting]), strict=True), []
            for (lower, upper, least), result in pairs:
                if isinstance(result, Unbounded):
                    unbounded.append(Box(least, lower, upper, None, result.message))
                    continue
                least, self.met = max(least, result.least), min(self.met, result.reached)
                open_, slopes = upper > lower, result.slopes
                rising, falling = open_ & (slopes.low >= 0), open_ & (slopes.high <= 0) & (slopes.low < 0)
                if result.may_jump and least < np.inf and open_.any() and not result.looseness[open_].any():
                    unbounded.append(Box(least, lower, upper, None))
                elif result.may_jump or not (rising | falling).any():
                    loose = np.where(open_, result.looseness, -1)
                    bounded.append(Box(least, lower, upper, int(loose.argmax()) if open_.any() else None))
                else:
                    waiting.append((np.where(falling, upper, lower), np.where(rising, lower, upper), least))
        return bounded + self._find_sides(unbounded)

    def _bound_each(self, boxes: Sequence[tuple[Array, Array]]) -> list[Bounds | Unbounded]:
        results: list[Bounds | Unbounded] = []
        for lower, upper in boxes:
            try:
                results.append(self.bounding(lower, upper))
            except Unbounded as error:
                results.append(error)
        return results

    def _find_sides(self, boxes: Sequence[Box]) -> list[Box]:
        """Return boxes whose bounds tell nothing of their sides, with where to halve them.

        That is as a part of a box tells, or else along its relatively widest side.
        """
        sides: dict[int, int] = {}
        for share in SHRUNK:
            tried = [k for k in range(len(boxes)) if k not in sides]
            parts = [boxes[k].shrink(share) for k in tried]
            for k, result in zip(tried, self.bound_boxes(parts) if parts else [], strict=True):
                if not isinstance(result, Unbounded) and result.looseness.any():
                    sides[k] = int(result.looseness.argmax())
        return [replace(box, widest=sides.get(k, self._find_widest(box))) for k, box in enumerate(boxes)]

    def _find_widest(self, box: Box) -> int | None:
        whole = self.upper - self.lower
        share_of = np.divide(box.upper - box.lower, whole, out=np.zeros_like(whole), where=whole > 0)
        return int(share_of.argmax()) if share_of.any() else None
