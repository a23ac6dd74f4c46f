"""All chunks of a job: what a store has is not done again, the rest is found here, by processes or by a cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from planter.errors import ComputationError, Interrupted
from planter.progress import Listener, Phase
from planter.sweeps import cluster, job, pool
from planter.sweeps.job import Recipe
from planter.sweeps.pool import Answer
from planter.sweeps.store import Store

FEWEST = 20_000
"""Rows from which on processes are started for them."""


@dataclass(frozen=True)
class Means:
    """What finds the chunks: processes of this machine (None: one a core), or the Dask cluster at an address."""

    processes: int | None = None
    cluster: str | None = None


HERE = Means()


@dataclass(frozen=True)
class Run:
    """What became of a job: chunks that were there before, workers that were started."""

    resumed: int
    workers: int


def run(recipe: Recipe, store: Store, means: Means = HERE, progress: Listener | None = None) -> Run:
    """Compute every chunk that the store does not have: all of its rows are there afterwards.

    Raises ComputationError where a chunk cannot be found; Interrupted, saying how many rows are there, on Ctrl-C.
    """
    rows, done = store.rows, store.done()
    todo = [number for number in range(job.count(rows)) if number not in done]
    kept = _rows(done, rows)
    phase = Phase("sweep", "row", rows, progress, kept)
    if kept:
        phase.reached(kept, "done before")
    count = _workers(means, rows) if todo else 0
    try:
        for number, content in _answers(recipe, todo, means, count):
            if isinstance(content, str):
                raise ComputationError(content)
            store.save(number, content)
            start, stop = job.ends(number, rows)
            phase.reached(phase.done + stop - start)
    except KeyboardInterrupt:
        raise Interrupted({"rows": rows, "rows_done": phase.done}) from None
    return Run(len(done), count)


def _rows(chunks: set[int], rows: int) -> int:
    return sum(stop - start for start, stop in (job.ends(number, rows) for number in chunks))


def _workers(means: Means, rows: int) -> int:
    if means.cluster is not None:
        return cluster.workers(means.cluster)
    return (means.processes or cores()) if rows >= FEWEST else 0


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _answers(recipe: Recipe, todo: Sequence[int], means: Means, count: int) -> Iterator[Answer]:
    if means.cluster is not None:
        return cluster.answers(recipe, todo, means.cluster)
    return pool.answers(recipe, todo, count) if count else _here(recipe, todo)


def _here(recipe: Recipe, todo: Sequence[int]) -> Iterator[Answer]:
    task = recipe.job() if todo else None
    for number in todo:
        assert task is not None
        yield number, job.found(task, number, cores())
