"""A lower bound of an objective over the box of designs beside its incumbent, the best design that is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.balls import Unbounded
from planter.optimise.proof.objective import Bounds
from planter.optimise.proof.results import GlobalBound
from planter.optimise.proof.search import Bounded, Search
from planter.progress import Listener, Progress

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

    def __call__(self, lower: Array, upper: Array) -> Bounds:
        """Return the bounds over a box. Raises Unbounded where there are none."""

    def bound_boxes(self, boxes: Sequence[tuple[Array, Array]]) -> Sequence[Bounds | Unbounded]:
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

    def end(self, result: Bounded) -> None:
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
        reached, result = incumbent.objective, Bounded(bounding.floor, np.inf, 1, 0.0, error.message)
    else:
        reached = reached if np.isfinite(reached) else incumbent.objective
        clock = _Clock(reached, seconds, listener)
        search = Search(bounding, *box, bounding.floor, bounding.batch, bounding.bound_boxes)
        result = search.run(reached - GOAL * abs(incumbent.objective), seconds, clock)
        clock.end(result)
    least = min(result.least, reached)  # every other design may be known to be worse, or to violate a limit
    gap, is_bounded = reached - least, bool(np.isfinite(least))
    is_proved = gap <= GOAL * abs(incumbent.objective)
    return GlobalBound(
        kind="sampled", samples=incumbent.samples, design=incumbent.design, objective=incumbent.objective,
        lower_bound=least if is_bounded else None, gap=gap if is_bounded else None, boxes=result.boxes,
        seconds=result.seconds, proved=is_proved, statement=_describe(result, incumbent, gap, is_proved),
    )  # fmt: skip


def _describe(result: Bounded, incumbent: Incumbent, gap: float, is_proved: bool) -> str:
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
