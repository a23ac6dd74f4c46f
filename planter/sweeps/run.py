"""All chunks of a job: what a store has is not done again, the rest is found here, by processes or by a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass

from planter.errors import Interrupted
from planter.parallel.jobs import Jobs
from planter.parallel.task import HERE, Means, count_cores
from planter.progress import Listener, Phase
from planter.sweeps import job
from planter.sweeps.job import Recipe
from planter.sweeps.store import Store

FEWEST = 20_000
"""Rows from which on processes are started for them."""
Chunk = tuple[int, bytes]
"""Number and content."""


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
    here = not todo or (means.cluster is None and rows < FEWEST)
    try:
        with nullcontext() if here else Jobs(recipe.task, todo, means) as jobs:
            for number, content in _evaluate(recipe, todo) if jobs is None else _read(jobs, todo):
                store.save(number, content)
                start, stop = job.ends(number, rows)
                phase.reached(phase.done + stop - start)
    except KeyboardInterrupt:
        raise Interrupted({"rows": rows, "rows_done": phase.done}) from None
    return Run(len(done), 0 if jobs is None else jobs.workers)


def _rows(chunks: set[int], rows: int) -> int:
    return sum(stop - start for start, stop in (job.ends(number, rows) for number in chunks))


def _read(jobs: Jobs, todo: Sequence[int]) -> Iterator[Chunk]:
    for answer in jobs:
        yield todo[answer.job], answer.result


def _evaluate(recipe: Recipe, todo: Sequence[int]) -> Iterator[Chunk]:
    """Yield chunks that all cores of this process evaluate."""
    task = recipe.job() if todo else None
    for number in todo:
        assert task is not None
        yield number, job.found(task, number, count_cores())
