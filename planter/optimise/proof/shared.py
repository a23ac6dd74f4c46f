"""Boxes of a proof bounded by workers, in rounds that do not depend on their number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from planter.kernels import Array
from planter.optimise.proof.balls import Unbounded
from planter.optimise.proof.bound import BoxObjective
from planter.optimise.proof.objective import Bounds
from planter.parallel.jobs import Jobs
from planter.parallel.task import AUTO, Means, Task

ROUND = 16
"""Jobs of a round. The next round begins when all of them are done, so that more workers than this do not help."""
Boxes = Sequence[tuple[Array, Array]]


class SharedObjective:
    """An objective of which workers bound many boxes at once. Implements `BoxObjective`."""

    def __init__(self, objective: BoxObjective, jobs: Jobs) -> None:
        self._objective, self._jobs = objective, jobs
        self.batch, self.floor = ROUND * objective.batch, objective.floor

    def __call__(self, lower: Array, upper: Array) -> Bounds:
        """Return the bounds over a box. Raises Unbounded where there are none."""
        return self._objective(lower, upper)

    def bound_boxes(self, boxes: Boxes) -> list[Bounds | Unbounded]:
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


def prepare_boxes(build: Callable[[], BoxObjective]) -> Callable[[Boxes], Sequence[Bounds | Unbounded]]:
    """Return the function that bounds an objective over boxes."""
    return build().bound_boxes
