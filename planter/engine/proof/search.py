"""Branch and bound: a lower bound of an objective over a box of designs, compared with the
incumbent.

The box with the lowest bound is bisected first, along the parameter which contributes most to the
looseness of its bound. Workers may bound the boxes, in rounds which do not depend on the number of
workers.
"""

from __future__ import annotations

import heapq
import itertools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from decimal import ROUND_CEILING, Context
from typing import Protocol, Self

import numpy as np

from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.objective import Box, Evidence, ObjectiveBounds
from planter.engine.proof.proof_results import GlobalBound
from planter.jobs import MIN_PARALLEL_S, Jobs
from planter.kernels import Array, Flags
from planter.progress import Listener, Progress
from planter.task import AUTO, Means, Task, count_cores

BoundListener = Callable[[float, int, float], None]
"""(bound so far, number of boxes, elapsed time [s]) -> None."""

MARGIN, SPARE = 1e-9, 0.01
"""Shares of a bound, and of the looseness of bounds and slopes, by which a bound is stated lower,
or higher at the incumbent, and a slope must be off zero: what others compute is rounded otherwise,
and may be a little wider.
"""


@dataclass(eq=False)
class BoxNode:
    """Designs between `lower` and `upper` (p,), a box of the tree that branch and bound builds.

    `bound` is its own bound, with the `evidence` from which it was computed, `inherited` that of
    the boxes around it. Its children are two halves along the parameter `widest`, or the one side
    of it that has the least objectives. A leaf has none, and is halved along `widest` next, if that
    is not None. `obstacle` is the reason if it has no bound, `domain` a box around it to all of
    which roots were followed.
    """

    lower: Array
    upper: Array
    inherited: float
    bound: float = -np.inf
    evidence: Evidence | None = None
    widest: int | None = None
    obstacle: str = ""
    children: list[BoxNode] = field(default_factory=list)
    domain: Box | None = None

    @property
    def lower_bound(self) -> float:
        """The best bound of the designs in the box."""
        return max(self.inherited, self.bound)

    def shrink(self, share: float) -> Box:
        """Return a share of the box about its centre."""
        centre, half = self.lower + (self.upper - self.lower) / 2, (self.upper - self.lower) / 2
        return centre - share * half, centre + share * half

    def halve(self) -> list[BoxNode]:
        """Return its halves along its widest side as new children."""
        side = self.widest
        assert side is not None
        below, above = self.upper.copy(), self.lower.copy()
        below[side] = above[side] = self.lower[side] + (self.upper[side] - self.lower[side]) / 2
        return self.divide((self.lower, below), (above, self.upper))

    def divide(self, *boxes: Box) -> list[BoxNode]:
        """Return parts of the box as new children."""
        self.children = [BoxNode(*box, self.lower_bound, domain=self.domain) for box in boxes]
        return self.children

    def list_nodes(self) -> Iterator[BoxNode]:
        """Yield the node and all below it, each before its children."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting += reversed(node.children)

    def prune(self, bound: float) -> BoxNode:
        """Return the tree without what no bound of at least `bound` of all designs needs."""
        if self.bound >= bound:
            return replace(self, children=[], widest=None)
        children = [child.prune(bound) for child in self.children]
        is_needed = len(children) == 1 or not children
        return replace(
            self, children=children, bound=-np.inf, evidence=self.evidence if is_needed else None
        )


SHRINK_SHARES = (0.25, 0.0625)
"""Shares of a box, about its centre, whose bounds determine where to bisect a box that cannot be
bounded.
"""


class BoxObjective(Protocol):
    """An objective with its a priori lower bound `floor`, bounded over up to `batch` boxes in a
    single call.
    """

    batch: int

    @property
    def floor(self) -> float: ...

    def bound_boxes(
        self, boxes: Sequence[Box], domains: Sequence[Box | None]
    ) -> Sequence[ObjectiveBounds | Unbounded]:
        """Return the bounds over each box, or the error that explains their absence.

        To all of each of the `domains`, which hold the boxes, roots were followed, unless it is
        None.
        """


class BranchAndBound:
    """Branch and bound of an objective over a box [lower, upper] (p,).

    `root` continues an earlier search. `clock` gives the CPU time that was spent [s], of which the
    search took `seconds`; `met` is the smallest value at the centre of a part.
    """

    def __init__(
        self,
        objective: BoxObjective,
        lower: Array,
        upper: Array,
        root: BoxNode | None = None,
        clock: Callable[[], float] = time.process_time,
    ) -> None:
        self.objective, self.clock = objective, clock
        self.root = root or BoxNode(lower, upper, objective.floor)
        self.boxes, self.met, self.seconds = 0, float(np.inf), 0.0

    def list_leaves(self) -> list[BoxNode]:
        """Return the boxes that are not divided."""
        return [node for node in self.root.list_nodes() if not node.children]

    @property
    def weakest(self) -> BoxNode:
        """The box whose bound is that of all designs."""
        return min(self.list_leaves(), key=lambda node: node.lower_bound)

    def run(self, goal: float, seconds: float, listener: BoundListener | None = None) -> float:
        """Bisect boxes until the bound, which is returned, reaches `goal` or the CPU time [s] is
        over.
        """
        begun, order = self.clock(), itertools.count()
        self.boxes = sum(node.evidence is not None for node in self.root.list_nodes())
        leaves = self.list_leaves()
        pending = [leaf for leaf in leaves if leaf.widest is None and leaf.evidence is None]
        leaves = [leaf for leaf in leaves if leaf not in pending] + self._bound(pending)
        open_ = [(leaf.lower_bound, next(order), leaf) for leaf in leaves]
        heapq.heapify(open_)
        while True:
            bound, _, node = open_[0]
            self.seconds = self.clock() - begun
            if listener is not None:
                listener(bound, self.boxes, self.seconds)
            if bound >= goal or self.seconds >= seconds or node.widest is None:
                return bound
            halves: list[BoxNode] = []
            while (
                open_
                and open_[0][0] < goal
                and open_[0][2].widest is not None
                and len(halves) < max(2, self.objective.batch)
            ):
                halves += heapq.heappop(open_)[2].halve()
            for half in self._bound(halves):
                heapq.heappush(open_, (half.lower_bound, next(order), half))

    def _bound(self, nodes: Sequence[BoxNode]) -> list[BoxNode]:
        """Return the leaves below some boxes, bounded.

        A parameter in which the objective is monotonic is fixed at the bound with the smaller
        values.
        """
        waiting, bounded, unbounded = list(nodes), list[BoxNode](), list[BoxNode]()
        while waiting:
            self.boxes += len(waiting)
            results = self.objective.bound_boxes(
                [(node.lower, node.upper) for node in waiting], [node.domain for node in waiting]
            )
            pairs, waiting = list(zip(waiting, results, strict=True)), []
            for node, result in pairs:
                if isinstance(result, Unbounded):
                    node.obstacle = result.message
                    unbounded.append(node)
                    continue
                node.bound, node.evidence = state_bound(result), result.evidence
                node.domain = result.domain
                self.met = min(self.met, result.reached)
                open_ = node.upper > node.lower
                rising = open_ & find_rising(result.slopes)
                falling = open_ & find_rising(-result.slopes) & ~rising
                if not result.may_jump and (rising | falling).any():
                    lower = np.where(falling, node.upper, node.lower)
                    waiting += node.divide((lower, np.where(rising, node.lower, node.upper)))
                    continue
                loose = np.where(open_, result.looseness, -1)
                is_loose = loose.max(initial=0) > 0
                if result.may_jump and node.lower_bound < np.inf and open_.any() and not is_loose:
                    unbounded.append(node)
                    continue
                node.widest = int(loose.argmax()) if open_.any() else None
                bounded.append(node)
        return bounded + self._find_sides(unbounded)

    def _find_sides(self, nodes: Sequence[BoxNode]) -> list[BoxNode]:
        """Return boxes without looseness by parameter, with the parameter along which to bisect
        each.

        That is the loosest parameter of a part about the centre, or else the relatively widest.
        """
        sides: dict[int, int] = {}
        for share in SHRINK_SHARES:
            unsettled = [k for k in range(len(nodes)) if k not in sides]
            parts = [nodes[k].shrink(share) for k in unsettled]
            domains = [nodes[k].domain for k in unsettled]
            results = self.objective.bound_boxes(parts, domains) if parts else []
            for k, result in zip(unsettled, results, strict=True):
                if not isinstance(result, Unbounded) and result.looseness.any():
                    sides[k] = int(result.looseness.argmax())
        for k, node in enumerate(nodes):
            node.widest = sides.get(k, self._find_widest(node))
        return list(nodes)

    def _find_widest(self, node: BoxNode) -> int | None:
        width = self.root.upper - self.root.lower
        share_of = np.divide(
            node.upper - node.lower, width, out=np.zeros_like(width), where=width > 0
        )
        return int(share_of.argmax()) if share_of.any() else None


def state_bound(bounds: ObjectiveBounds) -> float:
    """Return the lower bound of a box as it is stated, unless it is infinite lower than it was
    computed.
    """
    bound = bounds.lower_bound
    if not np.isfinite(bound):
        return bound
    return bound - MARGIN * abs(bound) - SPARE * float(bounds.looseness.sum())


def find_rising(slopes: Ball) -> Flags:
    """Return in which parameters an objective with slopes (p,) does not fall, by so much that it is
    to be stated.
    """
    is_zero = (slopes.mid == 0) & (slopes.rad == 0)
    rising: Flags = is_zero | (slopes.low > MARGIN * slopes.magnitude + SPARE * slopes.rad)
    return rising


SECONDS = 480.0
"""Default limit of the CPU time of a proof [s]."""
GOAL = 1e-6
"""Largest gap of a proved optimum, as a share of the objective."""


@dataclass(frozen=True)
class Incumbent:
    """Best known design: its point `x` (p,), its values by name, its objective, over `samples` or
    true if None.

    `scope` states for which designs the bound holds, as the subject of a sentence.
    """

    x: Array
    design: dict[str, float]
    objective: float
    samples: int | None
    scope: str = "no design of the box"


@dataclass(frozen=True)
class Proof:
    """A bound with the tree of boxes from which it follows.

    `reached` is above the objective of the incumbent, with its `evidence`, None if it was not
    enclosed.
    """

    result: GlobalBound
    incumbent: Incumbent
    root: BoxNode
    reached: float | None
    evidence: Evidence | None


def prove_bound(
    objective: BoxObjective,
    box: Box,
    incumbent: Incumbent,
    seconds: float = SECONDS,
    listener: Listener | None = None,
    root: BoxNode | None = None,
    clock: Callable[[], float] = time.process_time,
    keep: Callable[[Proof], None] | None = None,
) -> Proof:
    """Return the bound over a box that is reached within a CPU time limit [s], as a continuation of
    `root` if given.

    It is the floor of the objective if the incumbent cannot be enclosed. An interrupted proof is
    handed to `keep`.
    """
    search = BranchAndBound(objective, *box, root, clock)
    evidence, reached = None, incumbent.objective
    limit, reported = max(1, math.ceil(seconds)), 0

    def report(bound: float, boxes: int, spent: float, is_over: bool = False) -> None:
        """Report progress once for every full second."""
        nonlocal reported
        last = limit if is_over else min(int(spent), limit - 1)
        for second in range(limit if is_over else reported + 1, last + 1):
            if listener is not None:
                text = f"{boxes} boxes, gap {incumbent.objective - bound:.3g}"
                listener(Progress("proof", "second", second, limit, text))
        reported = max(reported, last)

    def conclude(lower_bound: float, obstacle: str = "") -> Proof:
        # all other designs may be excluded as worse or infeasible
        lower_bound = min(lower_bound, reached)
        gap, is_bounded = reached - lower_bound, bool(np.isfinite(lower_bound))
        is_proved = bool(np.isfinite(gap)) and gap <= GOAL * abs(incumbent.objective)
        bound = GlobalBound(
            kind="true" if incumbent.samples is None else "sampled",
            samples=incumbent.samples,
            design=incumbent.design,
            objective=incumbent.objective,
            lower_bound=lower_bound if is_bounded else None,
            gap=gap if is_bounded else None,
            boxes=search.boxes,
            seconds=search.seconds,
            proved=is_proved,
            statement=_describe_bound(search, incumbent, gap, is_proved, obstacle),
        )
        tree = search.root.prune(lower_bound) if is_proved else search.root
        return Proof(bound, incumbent, tree, None if evidence is None else reached, evidence)

    (bounds,) = objective.bound_boxes([(incumbent.x, incumbent.x)], [None])
    if isinstance(bounds, Unbounded):
        search.boxes = 1
        return conclude(objective.floor, bounds.message)
    if np.isfinite(bounds.reached):
        spare = MARGIN * abs(bounds.reached) + SPARE * (bounds.reached - bounds.lower_bound)
        reached, evidence = bounds.reached + spare, bounds.evidence
    begun = clock()
    try:
        bound = search.run(reached - GOAL * abs(incumbent.objective), seconds, report)
    except KeyboardInterrupt:
        if keep is not None:
            search.seconds = clock() - begun
            keep(conclude(search.weakest.lower_bound))
        raise
    report(bound, search.boxes, search.seconds, is_over=True)
    return conclude(bound, search.weakest.obstacle)


def _round_up(gap: float) -> str:
    """Return a gap with two digits that is not less."""
    return f"{float(Context(prec=2, rounding=ROUND_CEILING).create_decimal_from_float(gap)):.2g}"


def _describe_bound(
    search: BranchAndBound, incumbent: Incumbent, gap: float, is_proved: bool, obstacle: str
) -> str:
    objective, samples = incumbent.objective, incumbent.samples
    over = "over the whole cycle" if samples is None else f"over {samples} samples"
    claim = (
        "proved"
        if is_proved
        else f"not proved to {GOAL:g} of the objective in {search.seconds:.0f} CPU s"
    )
    if obstacle:
        claim += f", because parts of the box have no bound ({obstacle})"
    statement = (
        f"{incumbent.scope} is better than {objective:.9g} {over} by more than {_round_up(gap)}"
    )
    if not np.isfinite(gap):
        statement = f"nothing bounds the objective {objective:.9g} {over} from below"
    if search.met < objective - GOAL * abs(objective) and not is_proved:
        statement += f"; a design was met that is better: {search.met:.9g}"
    return f"{claim}: {statement}" + (
        "" if samples is None else "; of true extremes nothing is proved"
    )


JOBS_PER_ROUND = 16
"""Jobs of a round.

The next round begins after all of them, so that more workers than this have no effect.
"""


class SharedObjective:
    """An objective whose boxes are bounded by the workers of `means`; the bounds do not depend on
    their number. Implements `BoxObjective`.

    Without explicit `means`, workers are started for what is left after `MIN_PARALLEL_S` in this
    process. `build` is picklable and returns the objective in a worker.
    """

    def __init__(
        self, objective: BoxObjective, build: Callable[[], BoxObjective], means: Means
    ) -> None:
        self._objective, self._means = objective, means
        self._task = Task(prepare_boxes, {"build": build})
        self.batch, self.floor = JOBS_PER_ROUND * objective.batch, objective.floor
        self._begun, self._seconds = time.perf_counter(), 0.0
        self._jobs: Jobs | None = None

    def clock(self) -> float:
        """Return the CPU time of this process, and of the workers for their boxes [s]."""
        return time.process_time() + self._seconds

    def bound_boxes(
        self, boxes: Sequence[Box], domains: Sequence[Box | None]
    ) -> Sequence[ObjectiveBounds | Unbounded]:
        """Return the bounds over each box, or the error that explains their absence."""
        is_early = time.perf_counter() - self._begun < MIN_PARALLEL_S or count_cores() == 1
        if self._jobs is None and self._means == AUTO and is_early:
            return self._objective.bound_boxes(boxes, domains)
        if self._jobs is None:
            self._jobs = Jobs(self._task, means=self._means)
        size = self._objective.batch
        parts = [slice(k, k + size) for k in range(0, len(boxes), size)]
        self._jobs.add([(boxes[part], domains[part]) for part in parts])
        answers = list(self._jobs.in_order())
        self._seconds += sum(seconds for _, seconds in answers)
        return [result for results, _ in answers for result in results]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """End the workers."""
        if self._jobs is not None:
            self._jobs.__exit__()


TimedBounds = tuple[Sequence[ObjectiveBounds | Unbounded], float]
"""Bounds of boxes, and the CPU time that they took [s]."""


Job = tuple[Sequence[Box], Sequence[Box | None]]
"""Boxes, and boxes around them to all of which roots were followed."""


def prepare_boxes(build: Callable[[], BoxObjective]) -> Callable[[Job], TimedBounds]:
    """Return the function that bounds an objective over boxes."""
    objective = build()

    def bound(job: Job) -> TimedBounds:
        begun = time.process_time()
        results = objective.bound_boxes(*job)
        return results, time.process_time() - begun

    return bound
