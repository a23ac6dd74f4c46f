"""What a proof says of an optimum, key by key.

Branch and bound: boxes of designs, the one with the least bound first, halved where their bounds are loose.

A lower bound of an objective over the box of designs beside its incumbent, the best design that is known.

Boxes of a proof bounded by workers, in rounds that do not depend on their number.
"""

from __future__ import annotations

import heapq
import itertools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.enclosures import ObjectiveBounds
from planter.optimise.proof.intervals import Unbounded
from planter.parallel.jobs import Jobs
from planter.parallel.task import AUTO, Means, Task
from planter.progress import Listener, Progress
from planter.records import Record


@dataclass(frozen=True, kw_only=True)
class GlobalBound(Record):
    """No design of the box has an objective below `lower_bound`, which is null, with `gap`, if none was reached.

    `kind` is that of this objective: "sampled", over `samples` angles; nothing follows for true extremes then.
    `objective` is that of the incumbent `design`, the best that is known; `gap` is the difference.
    """

    kind: Literal["sampled", "true"]
    samples: int
    design: dict[str, float]
    objective: float
    lower_bound: float | None
    gap: float | None
    boxes: int
    seconds: float
    proved: bool
    statement: str


Bounding = Callable[[Array, Array], ObjectiveBounds]
"""(lower, upper) -> bounds of an objective over that box; raises Unbounded where there are none."""

BoundBoxes = Callable[[Sequence[tuple[Array, Array]]], Sequence[ObjectiveBounds | Unbounded]]
"""Boxes [lower, upper] -> for each, the bounds of an objective over it, or why there are none."""
BoundListener = Callable[[float, int, float], None]
"""Told the bound so far, the number of boxes and the seconds."""


@dataclass(frozen=True)
class BoundedBox:
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
        """Return the two halves of the box along its widest side, none for a point."""
        if self.widest is None:
            return []
        side = self.widest
        below, above = self.upper.copy(), self.lower.copy()
        below[side] = above[side] = self.lower[side] + (self.upper[side] - self.lower[side]) / 2
        return [(self.lower, below), (above, self.upper)]


@dataclass(frozen=True)
class BoundingResult:
    """No design of a box has an objective below `least`; `met` is the least that a box's centre was seen to have.

    `obstacle` says why the box that holds `least` has no bound of its own; it is empty if it has one.
    """

    least: float
    met: float
    boxes: int
    seconds: float
    obstacle: str = ""


SHRINK_SHARES = (0.25, 0.0625)
"""Shares of a box, about its centre, that are tried for where to halve one that has no bound of its own."""


class BranchAndBound:
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

    def run(self, goal: float, seconds: float, told: BoundListener | None = None) -> BoundingResult:
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
                return BoundingResult(least, float(self.met), self.boxes, spent, box.obstacle)
            halves: list[tuple[Array, Array, float]] = []
            while open_ and open_[0][0] < goal and open_[0][2].widest is not None and len(halves) < max(2, self.batch):
                least, _, box = heapq.heappop(open_)
                halves += [(lower, upper, least) for lower, upper in box.halves()]
            for half in self._bound(halves):
                heapq.heappush(open_, (half.least, next(order), half))

    def _bound(self, boxes: Sequence[tuple[Array, Array, float]]) -> list[BoundedBox]:
        """Return boxes [lower, upper] that no objective is below some number in, with their bounds.

        Directions along which the objective only rises or only falls are put on their side.
        """
        waiting, bounded, unbounded = list(boxes), list[BoundedBox](), list[BoundedBox]()
        while waiting:
            self.boxes += len(waiting)
            pairs, waiting = zip(waiting, self.bound_boxes([box[:2] for box in waiting]), strict=True), []
            for (lower, upper, least), result in pairs:
                if isinstance(result, Unbounded):
                    unbounded.append(BoundedBox(least, lower, upper, None, result.message))
                    continue
                least, self.met = max(least, result.least), min(self.met, result.reached)
                open_, slopes = upper > lower, result.slopes
                rising, falling = open_ & (slopes.low >= 0), open_ & (slopes.high <= 0) & (slopes.low < 0)
                if result.may_jump and least < np.inf and open_.any() and not result.looseness[open_].any():
                    unbounded.append(BoundedBox(least, lower, upper, None))
                elif result.may_jump or not (rising | falling).any():
                    loose = np.where(open_, result.looseness, -1)
                    bounded.append(BoundedBox(least, lower, upper, int(loose.argmax()) if open_.any() else None))
                else:
                    waiting.append((np.where(falling, upper, lower), np.where(rising, lower, upper), least))
        return bounded + self._find_sides(unbounded)

    def _bound_each(self, boxes: Sequence[tuple[Array, Array]]) -> list[ObjectiveBounds | Unbounded]:
        results: list[ObjectiveBounds | Unbounded] = []
        for lower, upper in boxes:
            try:
                results.append(self.bounding(lower, upper))
            except Unbounded as error:
                results.append(error)
        return results

    def _find_sides(self, boxes: Sequence[BoundedBox]) -> list[BoundedBox]:
        """Return boxes whose bounds tell nothing of their sides, with where to halve them.

        That is as a part of a box tells, or else along its relatively widest side.
        """
        sides: dict[int, int] = {}
        for share in SHRINK_SHARES:
            tried = [k for k in range(len(boxes)) if k not in sides]
            parts = [boxes[k].shrink(share) for k in tried]
            for k, result in zip(tried, self.bound_boxes(parts) if parts else [], strict=True):
                if not isinstance(result, Unbounded) and result.looseness.any():
                    sides[k] = int(result.looseness.argmax())
        return [replace(box, widest=sides.get(k, self._find_widest(box))) for k, box in enumerate(boxes)]

    def _find_widest(self, box: BoundedBox) -> int | None:
        whole = self.upper - self.lower
        share_of = np.divide(box.upper - box.lower, whole, out=np.zeros_like(whole), where=whole > 0)
        return int(share_of.argmax()) if share_of.any() else None


SECONDS = 480.0
"""Time for a proof, if nothing else is said [s]."""
GOAL = 1e-6
"""Gap of what counts as proved, as a share of the objective."""


class BoxObjective(Protocol):
    """An objective bounded over boxes of designs: over one, or over up to `batch` at once, which takes less time."""

    batch: int

    @property
    def floor(self) -> float:
        """What no objective is below."""

    def __call__(self, lower: Array, upper: Array) -> ObjectiveBounds:
        """Return the bounds over a box. Raises Unbounded where there are none."""

    def bound_boxes(self, boxes: Sequence[tuple[Array, Array]]) -> Sequence[ObjectiveBounds | Unbounded]:
        """Return the bounds over each of some boxes, or why there are none."""


@dataclass(frozen=True)
class Incumbent:
    """The best design that is known over samples: its point (p,), itself by names, its objective.

    `scope` says for which designs the bound is, in words.
    """

    x: Array
    design: dict[str, float]
    objective: float
    samples: int
    scope: str = "no design of the box"


class _Clock:
    """Tells every full second once."""

    def __init__(self, reached: float, limit: float, listener: Listener | None) -> None:
        self.reached, self.total, self.listener, self.next = reached, max(1, math.ceil(limit)), listener, 1

    def __call__(self, least: float, boxes: int, spent: float) -> None:
        for second in range(self.next, min(int(spent), self.total - 1) + 1):
            self._tell(second, boxes, least)
        self.next = max(self.next, int(spent) + 1)

    def end(self, result: BoundingResult) -> None:
        self._tell(self.total, result.boxes, result.least)

    def _tell(self, second: int, boxes: int, least: float) -> None:
        if self.listener is not None:
            self.listener(
                Progress("proof", "second", second, self.total, f"{boxes} boxes, gap {self.reached - least:.3g}")
            )


def prove_bound(
    bounding: BoxObjective, box: tuple[Array, Array], incumbent: Incumbent, seconds: float = SECONDS,
    listener: Listener | None = None,
) -> GlobalBound:  # fmt: skip
    """Return the bound over a box [lower, upper] (p,) that is reached in so many seconds.

    It is the floor of the objective if the incumbent itself cannot be enclosed.
    """
    try:
        reached = bounding(incumbent.x, incumbent.x).reached
    except Unbounded as error:
        reached, result = incumbent.objective, BoundingResult(bounding.floor, np.inf, 1, 0.0, error.message)
    else:
        reached = reached if np.isfinite(reached) else incumbent.objective
        clock = _Clock(reached, seconds, listener)
        search = BranchAndBound(bounding, *box, bounding.floor, bounding.batch, bounding.bound_boxes)
        result = search.run(reached - GOAL * abs(incumbent.objective), seconds, clock)
        clock.end(result)
    least = min(result.least, reached)  # every other design may be known to be worse, or to violate a limit
    gap, is_bounded = reached - least, bool(np.isfinite(least))
    is_proved = gap <= GOAL * abs(incumbent.objective)
    return GlobalBound(
        kind="sampled", samples=incumbent.samples, design=incumbent.design, objective=incumbent.objective,
        lower_bound=least if is_bounded else None, gap=gap if is_bounded else None, boxes=result.boxes,
        seconds=result.seconds, proved=is_proved, statement=_describe_bound(result, incumbent, gap, is_proved),
    )  # fmt: skip


def _describe_bound(result: BoundingResult, incumbent: Incumbent, gap: float, is_proved: bool) -> str:
    objective, over = incumbent.objective, f"over {incumbent.samples} samples"
    claim = "proved" if is_proved else f"not proved to {GOAL:g} of the objective in {result.seconds:.0f} s"
    if result.obstacle:
        claim += f", because parts of the box have no bound ({result.obstacle})"
    statement = f"{incumbent.scope} is better than {objective:.9g} {over} by more than {gap:.2g}"
    if not np.isfinite(gap):
        statement = f"nothing bounds the objective {objective:.9g} {over} from below"
    if result.met < objective - GOAL * abs(objective) and not is_proved:
        statement += f"; a design was met that is better: {result.met:.9g}"
    return f"{claim}: {statement}; of true extremes nothing is proved"


JOBS_PER_ROUND = 16
"""Jobs of a round. The next round begins when all of them are done, so that more workers than this do not help."""
Boxes = Sequence[tuple[Array, Array]]


class SharedObjective:
    """An objective of which workers bound many boxes at once. Implements `BoxObjective`."""

    def __init__(self, objective: BoxObjective, jobs: Jobs) -> None:
        self._objective, self._jobs = objective, jobs
        self.batch, self.floor = JOBS_PER_ROUND * objective.batch, objective.floor

    def __call__(self, lower: Array, upper: Array) -> ObjectiveBounds:
        """Return the bounds over a box. Raises Unbounded where there are none."""
        return self._objective(lower, upper)

    def bound_boxes(self, boxes: Boxes) -> list[ObjectiveBounds | Unbounded]:
        """Return the bounds over each of some boxes, or why there are none."""
        size = self._objective.batch
        self._jobs.add([boxes[k : k + size] for k in range(0, len(boxes), size)])
        return [result for results in self._jobs.in_order() for result in results]


@contextmanager
def share_boxes(objective: BoxObjective, build: Callable[[], BoxObjective], means: Means) -> Iterator[BoxObjective]:
    """Yield an objective whose boxes workers bound if `means` says which; its bounds do not depend on their number.

    `build`, of which pickles can be made, returns the objective in a worker.
    """
    if means == AUTO:
        yield objective
        return
    with Jobs(Task(prepare_boxes, {"build": build}), means=means) as jobs:
        yield SharedObjective(objective, jobs)


def prepare_boxes(build: Callable[[], BoxObjective]) -> Callable[[Boxes], Sequence[ObjectiveBounds | Unbounded]]:
    """Return the function that bounds an objective over boxes."""
    return build().bound_boxes
