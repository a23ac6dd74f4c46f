"""Branch and bound: a lower bound of an objective over a box of designs, compared with the incumbent.

The box with the lowest bound is bisected first, along the parameter which contributes most to the looseness of its
bound. Workers may bound the boxes, in rounds which do not depend on the number of workers.
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
from planter.parallel.jobs import MIN_PARALLEL_S, Jobs
from planter.parallel.task import AUTO, Means, Task, count_cores
from planter.progress import Listener, Progress
from planter.records import Record


@dataclass(frozen=True, kw_only=True)
class GlobalBound(Record):
    """No design of the box has an objective below `lower_bound`, which is null, with `gap`, if none was reached.

    `kind` is that of this objective: "true", of true extremes and integrals, or "sampled", over `samples` angles, from
    which nothing follows for true extremes. `objective` is that of the incumbent `design`, the best that is known;
    `gap` is the difference.
    """

    kind: Literal["sampled", "true"]
    samples: int | None
    design: dict[str, float]
    objective: float
    lower_bound: float | None
    gap: float | None
    boxes: int
    seconds: float
    proved: bool
    statement: str


Bounding = Callable[[Array, Array], ObjectiveBounds]
"""(lower, upper) -> bounds of an objective over that box; raises Unbounded if it has no bounds there."""

BoundBoxes = Callable[[Sequence[tuple[Array, Array]]], Sequence[ObjectiveBounds | Unbounded]]
"""Boxes [lower, upper] -> for each, the bounds of an objective over it, or the reason for their absence."""
BoundListener = Callable[[float, int, float], None]
"""(bound so far, number of boxes, elapsed time [s]) -> None."""


@dataclass(frozen=True)
class BoundedBox:
    """Designs between `lower` and `upper` (p,) with objectives of at least `lower_bound`.

    The box is bisected along the parameter `widest`, None for a point. `obstacle` is the reason if its bound is that of
    the enclosing box.
    """

    lower_bound: float
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
    """Lower bound `lower_bound` of an objective over a box, and the smallest value `met` at the centre of a part.

    `obstacle` is the reason if the part with `lower_bound` has only the bound of its enclosing box, else empty.
    """

    lower_bound: float
    met: float
    boxes: int
    seconds: float
    obstacle: str = ""


SHRINK_SHARES = (0.25, 0.0625)
"""Shares of a box, about its centre, whose bounds determine where to bisect a box that cannot be bounded."""


class BranchAndBound:
    """Branch and bound of an objective over a box [lower, upper] (p,), from an a priori bound `floor`.

    `bound_boxes` bounds the objective over up to `batch` boxes in a single call, if that is faster.
    """

    def __init__(
        self, bounding: Bounding, lower: Array, upper: Array, floor: float = -np.inf, batch: int = 1,
        bound_boxes: BoundBoxes | None = None,
    ) -> None:  # fmt: skip
        self.bounding, self.floor = bounding, floor
        self.lower, self.upper = lower, upper
        self.batch, self.bound_boxes = batch, bound_boxes or self._bound_each
        self.boxes, self.met = 0, np.inf

    def run(self, goal: float, seconds: float, listener: BoundListener | None = None) -> BoundingResult:
        """Bisect boxes until the bound reaches `goal` or the time [s] is over."""
        begun, order = time.perf_counter(), itertools.count()
        (root,) = self._bound([(self.lower, self.upper, self.floor)])
        open_ = [(root.lower_bound, next(order), root)]
        while True:
            bound, _, box = open_[0]
            spent = time.perf_counter() - begun
            if listener is not None:
                listener(bound, self.boxes, spent)
            if bound >= goal or spent >= seconds or box.widest is None:
                return BoundingResult(bound, float(self.met), self.boxes, spent, box.obstacle)
            halves: list[tuple[Array, Array, float]] = []
            while open_ and open_[0][0] < goal and open_[0][2].widest is not None and len(halves) < max(2, self.batch):
                bound, _, box = heapq.heappop(open_)
                halves += [(lower, upper, bound) for lower, upper in box.halves()]
            for half in self._bound(halves):
                heapq.heappush(open_, (half.lower_bound, next(order), half))

    def _bound(self, boxes: Sequence[tuple[Array, Array, float]]) -> list[BoundedBox]:
        """Return boxes (lower, upper, bound of the enclosing box) with their own bounds.

        A parameter in which the objective is monotonic is fixed at the bound with the smaller values.
        """
        waiting, bounded, unbounded = list(boxes), list[BoundedBox](), list[BoundedBox]()
        while waiting:
            self.boxes += len(waiting)
            pairs, waiting = zip(waiting, self.bound_boxes([box[:2] for box in waiting]), strict=True), []
            for (lower, upper, bound), result in pairs:
                if isinstance(result, Unbounded):
                    unbounded.append(BoundedBox(bound, lower, upper, None, result.message))
                    continue
                bound, self.met = max(bound, result.lower_bound), min(self.met, result.reached)
                open_, slopes = upper > lower, result.slopes
                rising, falling = open_ & (slopes.low >= 0), open_ & (slopes.high <= 0) & (slopes.low < 0)
                if result.may_jump and bound < np.inf and open_.any() and not result.looseness[open_].any():
                    unbounded.append(BoundedBox(bound, lower, upper, None))
                elif result.may_jump or not (rising | falling).any():
                    loose = np.where(open_, result.looseness, -1)
                    bounded.append(BoundedBox(bound, lower, upper, int(loose.argmax()) if open_.any() else None))
                else:
                    waiting.append((np.where(falling, upper, lower), np.where(rising, lower, upper), bound))
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
        """Return boxes without looseness by parameter, with the parameter along which to bisect each.

        That is the loosest parameter of a part about the centre, or else the relatively widest.
        """
        sides: dict[int, int] = {}
        for share in SHRINK_SHARES:
            unsettled = [k for k in range(len(boxes)) if k not in sides]
            parts = [boxes[k].shrink(share) for k in unsettled]
            for k, result in zip(unsettled, self.bound_boxes(parts) if parts else [], strict=True):
                if not isinstance(result, Unbounded) and result.looseness.any():
                    sides[k] = int(result.looseness.argmax())
        return [replace(box, widest=sides.get(k, self._find_widest(box))) for k, box in enumerate(boxes)]

    def _find_widest(self, box: BoundedBox) -> int | None:
        width = self.upper - self.lower
        share_of = np.divide(box.upper - box.lower, width, out=np.zeros_like(width), where=width > 0)
        return int(share_of.argmax()) if share_of.any() else None


SECONDS = 480.0
"""Default time limit of a proof [s]."""
GOAL = 1e-6
"""Largest gap of a proved optimum, as a share of the objective."""


class BoxObjective(Protocol):
    """An objective that is bounded over a box of designs, or over up to `batch` boxes in a single call."""

    batch: int

    @property
    def floor(self) -> float:
        """A priori lower bound of the objective."""

    def __call__(self, lower: Array, upper: Array) -> ObjectiveBounds:
        """Return the bounds over a box [lower, upper] (p,). Raises Unbounded if it has no bounds there."""

    def bound_boxes(self, boxes: Sequence[tuple[Array, Array]]) -> Sequence[ObjectiveBounds | Unbounded]:
        """Return the bounds over each box, or the error that explains their absence."""


@dataclass(frozen=True)
class Incumbent:
    """Best known design: its point `x` (p,), its values by name, its objective, over `samples` or true if None.

    `scope` states for which designs the bound holds, as the subject of a sentence.
    """

    x: Array
    design: dict[str, float]
    objective: float
    samples: int | None
    scope: str = "no design of the box"


class _Clock:
    """Report progress once for every full second."""

    def __init__(self, reached: float, limit: float, listener: Listener | None) -> None:
        self.reached, self.total, self.listener, self.next = reached, max(1, math.ceil(limit)), listener, 1

    def __call__(self, bound: float, boxes: int, spent: float) -> None:
        for second in range(self.next, min(int(spent), self.total - 1) + 1):
            self._tell(second, boxes, bound)
        self.next = max(self.next, int(spent) + 1)

    def end(self, result: BoundingResult) -> None:
        self._tell(self.total, result.boxes, result.lower_bound)

    def _tell(self, second: int, boxes: int, lower_bound: float) -> None:
        if self.listener is not None:
            self.listener(
                Progress("proof", "second", second, self.total, f"{boxes} boxes, gap {self.reached - lower_bound:.3g}")
            )


def prove_bound(
    bounding: BoxObjective, box: tuple[Array, Array], incumbent: Incumbent, seconds: float = SECONDS,
    listener: Listener | None = None,
) -> GlobalBound:  # fmt: skip
    """Return the bound over a box [lower, upper] (p,) that is reached within a time limit [s].

    It is the floor of the objective if the incumbent cannot be enclosed.
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
    lower_bound = min(result.lower_bound, reached)  # all other designs may be excluded as worse or infeasible
    gap, is_bounded = reached - lower_bound, bool(np.isfinite(lower_bound))
    is_proved = gap <= GOAL * abs(incumbent.objective)
    return GlobalBound(
        kind="true" if incumbent.samples is None else "sampled", samples=incumbent.samples, design=incumbent.design,
        objective=incumbent.objective,
        lower_bound=lower_bound if is_bounded else None, gap=gap if is_bounded else None, boxes=result.boxes,
        seconds=result.seconds, proved=is_proved, statement=_describe_bound(result, incumbent, gap, is_proved),
    )  # fmt: skip


def _describe_bound(result: BoundingResult, incumbent: Incumbent, gap: float, is_proved: bool) -> str:
    objective, samples = incumbent.objective, incumbent.samples
    over = "over the whole cycle" if samples is None else f"over {samples} samples"
    claim = "proved" if is_proved else f"not proved to {GOAL:g} of the objective in {result.seconds:.0f} s"
    if result.obstacle:
        claim += f", because parts of the box have no bound ({result.obstacle})"
    statement = f"{incumbent.scope} is better than {objective:.9g} {over} by more than {gap:.2g}"
    if not np.isfinite(gap):
        statement = f"nothing bounds the objective {objective:.9g} {over} from below"
    if result.met < objective - GOAL * abs(objective) and not is_proved:
        statement += f"; a design was met that is better: {result.met:.9g}"
    return f"{claim}: {statement}" + ("" if samples is None else "; of true extremes nothing is proved")


JOBS_PER_ROUND = 16
"""Jobs of a round. The next round begins after all of them, so that more workers than this have no effect."""
Boxes = Sequence[tuple[Array, Array]]


class SharedObjective:
    """An objective whose boxes are bounded by workers. Implements `BoxObjective`.

    Without explicit `means`, workers are started for what is left after `MIN_PARALLEL_S` in this process.
    """

    def __init__(self, objective: BoxObjective, task: Task, means: Means) -> None:
        self._objective, self._task, self._means = objective, task, means
        self.batch, self.floor = JOBS_PER_ROUND * objective.batch, objective.floor
        self._begun = time.perf_counter()
        self._jobs: Jobs | None = None

    def __call__(self, lower: Array, upper: Array) -> ObjectiveBounds:
        """Return the bounds over a box [lower, upper] (p,). Raises Unbounded if it has no bounds there."""
        return self._objective(lower, upper)

    def bound_boxes(self, boxes: Boxes) -> Sequence[ObjectiveBounds | Unbounded]:
        """Return the bounds over each box, or the error that explains their absence."""
        is_early = time.perf_counter() - self._begun < MIN_PARALLEL_S or count_cores() == 1
        if self._jobs is None and self._means == AUTO and is_early:
            return self._objective.bound_boxes(boxes)
        if self._jobs is None:
            self._jobs = Jobs(self._task, means=self._means)
        size = self._objective.batch
        self._jobs.add([boxes[k : k + size] for k in range(0, len(boxes), size)])
        return [result for results in self._jobs.in_order() for result in results]

    def end(self) -> None:
        """End the workers."""
        if self._jobs is not None:
            self._jobs.__exit__()


@contextmanager
def share_boxes(objective: BoxObjective, build: Callable[[], BoxObjective], means: Means) -> Iterator[BoxObjective]:
    """Yield an objective whose boxes are bounded by the workers of `means`; the bounds do not depend on their number.

    `build` is picklable and returns the objective in a worker.
    """
    shared = SharedObjective(objective, Task(prepare_boxes, {"build": build}), means)
    try:
        yield shared
    finally:
        shared.end()


def prepare_boxes(build: Callable[[], BoxObjective]) -> Callable[[Boxes], Sequence[ObjectiveBounds | Unbounded]]:
    """Return the function that bounds an objective over boxes."""
    return build().bound_boxes
