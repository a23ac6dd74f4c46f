"""Compute the chunks of a job that a store lacks: in this process, in worker processes or on a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass

from planter.errors import Interrupted
from planter.parallel.jobs import Jobs
from planter.parallel.task import AUTO, Means, count_cores
from planter.progress import Listener, ProgressPhase
from planter.sweeps import job
from planter.sweeps.job import Recipe
from planter.sweeps.store import Store

FEWEST = 20_000
"""Number of rows from which worker processes are started."""
Chunk = tuple[int, bytes]
"""Number and content."""


@dataclass(frozen=True)
class Run:
    """Outcome of a job: numbers of chunks reused and of workers started."""

    resumed: int
    workers: int


def run_job(recipe: Recipe, store: Store, means: Means = AUTO, progress: Listener | None = None) -> Run:
    """Compute every chunk that the store lacks.

    Raises ComputationError if a chunk cannot be computed, and Interrupted with the number of finished rows on Ctrl-C.
    """
    rows, done = store.rows, store.list_finished()
    todo = [number for number in range(job.count_chunks(rows)) if number not in done]
    resumed_rows = _rows(done, rows)
    phase = ProgressPhase("sweep", "row", rows, progress, resumed_rows)
    if resumed_rows:
        phase.report(resumed_rows, "done before")
    is_local = not todo or (means.cluster is None and rows < FEWEST)
    try:
        with nullcontext() if is_local else Jobs(recipe.task, todo, means) as jobs:
            for number, content in _evaluate(recipe, todo) if jobs is None else _read(jobs, todo):
                store.save(number, content)
                start, stop = job.chunk_limits(number, rows)
                phase.report(phase.done + stop - start)
    except KeyboardInterrupt:
        raise Interrupted({"rows": rows, "rows_done": phase.done}) from None
    return Run(len(done), 0 if jobs is None else jobs.workers)


def _rows(chunks: set[int], rows: int) -> int:
    return sum(stop - start for start, stop in (job.chunk_limits(number, rows) for number in chunks))


def _read(jobs: Jobs, todo: Sequence[int]) -> Iterator[Chunk]:
    for answer in jobs:
        yield todo[answer.job], answer.result


def _evaluate(recipe: Recipe, todo: Sequence[int]) -> Iterator[Chunk]:
    """Yield chunks that all cores of this process evaluate."""
    task = recipe.job() if todo else None
    for number in todo:
        assert task is not None
        yield number, job.evaluate_chunk(task, number, count_cores())
