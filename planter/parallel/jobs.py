"""The jobs of a task under way, and their results: in the order in which they come, or in that of the jobs."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from planter.parallel.cluster import ClusterWorkers
from planter.parallel.local import LocalWorkers
from planter.parallel.task import HERE, Answer, Means, Task, count_cores

POLL_S = 0.2
"""Time between two calls of who wants to know that the jobs go on."""
WORTH_S = 10.0
"""Time that the jobs left would take in this process from which on worker processes are started for them."""
Result = TypeVar("Result")


class Jobs:
    """The jobs of a task, run by worker processes or a cluster from now on. Leaving the context ends what is left.

    Raises InputError as `ClusterWorkers`.
    """

    def __init__(self, task: Task, jobs: Sequence[Any] = (), means: Means = HERE) -> None:
        self._answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        self._kept: dict[int, Answer] = {}
        self.count = self._taken = 0
        text, processes = task.to_bytes(), means.processes or count_cores()
        self._workers: LocalWorkers | ClusterWorkers
        if means.cluster is not None:
            self._workers = ClusterWorkers(text, means.cluster, self._answers)
        else:
            self._workers = LocalWorkers(text, min(processes, len(jobs)) if jobs else processes, self._answers)
        self.add(jobs)

    def add(self, jobs: Sequence[Any]) -> None:
        """Have more jobs run, after those before."""
        for job in jobs:
            self._workers.add(self.count, job)
            self.count += 1

    @property
    def workers(self) -> int:
        """Number of worker processes, or of workers of the cluster."""
        return self._workers.count

    def __enter__(self) -> Jobs:
        return self

    def __exit__(self, *_: object) -> None:
        self._workers.end()

    def __iter__(self) -> Iterator[Answer]:
        """Yield the answers as they come."""
        for _ in range(self.count):
            yield self._answers.get()

    def in_order(self, waiting: Callable[[], None] | None = None) -> Iterator[Any]:
        """Yield each result once, in the order of the jobs; `waiting` is called time and again until the next is there.

        Raises the error of the first job that has one.
        """
        while self._taken < self.count:
            while self._taken not in self._kept:
                self._collect(POLL_S)
                if waiting is not None:
                    waiting()
            answer = self._kept.pop(self._taken)
            self._taken += 1
            yield answer.result

    def results(self) -> list[Any]:
        """Return the results so far of the jobs that `in_order` has not passed yet, in their order."""
        self._collect(0)
        answers = (self._kept[number] for number in sorted(self._kept))
        return [answer.result for answer in answers if not answer.is_error]

    def _collect(self, seconds: float) -> None:
        """Take the answers that are there; wait for the first of them so long."""
        try:
            while True:
                answer = self._answers.get(timeout=seconds) if seconds else self._answers.get_nowait()
                self._kept[answer.job], seconds = answer, 0
        except queue.Empty:
            return


def run_in_order(
    task: Task | None, jobs: Sequence[Any], means: Means, here: Callable[[Any], Result], take: Callable[[Any], Result],
    waiting: Callable[[], None] | None = None,
) -> Iterator[Result]:  # fmt: skip
    """Yield what becomes of jobs, in their order: `here` runs one in this process, `take` takes a worker's result.

    Unless `means` says what runs them, workers are started if the rest would take longer than `WORTH_S` here. Without a
    task there are none.
    """
    done, begun = 0, time.perf_counter()
    while done < len(jobs) and (task is None or means == HERE):
        left = len(jobs) - done
        seconds = (time.perf_counter() - begun) / max(done, 1) * left
        if task is not None and done and left > 1 and seconds > WORTH_S and count_cores() > 1:
            break
        yield here(jobs[done])
        done += 1
    if task is not None and done < len(jobs):
        with Jobs(task, jobs[done:], means) as under_way:
            yield from map(take, under_way.in_order(waiting))
