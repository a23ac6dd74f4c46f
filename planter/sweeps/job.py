"""Jobs in chunks: each chunk is computed independently of the others, in any process, with the same bytes."""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Protocol

from planter.kernels import Array
from planter.parallel.task import Task
from planter.version import __version__

CHUNK = 10_000
"""Rows of a chunk; the last one has the remainder."""


class Job(Protocol):
    """A number of `rows`, of `width` numbers each."""

    rows: int
    width: int

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the rows from `start` to `stop`, (stop - start, width), independent of earlier calls.

        A row without a result is NaN.
        """


@dataclass(frozen=True)
class Recipe:
    """Recipe by which any process builds a job: a function "package.module:name" and its arguments, fit for JSON."""

    function: str
    arguments: Mapping[str, Any]

    @property
    def task(self) -> Task:
        """Task of a worker: the chunks of the job by number."""
        return Task(prepare_chunks, {"recipe": self}, is_thread_safe=True)

    def job(self) -> Job:
        """Build the job."""
        module, name = self.function.split(":")
        job: Job = getattr(importlib.import_module(module), name)(**self.arguments)
        return job

    @property
    def text(self) -> str:
        """Function and arguments as JSON, in the order of the arguments."""
        return json.dumps(asdict(self), allow_nan=False)

    @property
    def question(self) -> str:
        """Hash of recipe, chunk size and version of planter, by which a store identifies a job."""
        return hashlib.sha256(f"{__version__} {CHUNK} {self.text}".encode()).hexdigest()


def count_chunks(rows: int) -> int:
    """Return the number of chunks of a job."""
    return -(-rows // CHUNK)


def chunk_limits(number: int, rows: int) -> tuple[int, int]:
    """Return the first row of a chunk and the row after its last.

    >>> chunk_limits(0, 25_000), chunk_limits(2, 25_000)
    ((0, 10000), (20000, 25000))
    """
    return number * CHUNK, min((number + 1) * CHUNK, rows)


def evaluate_chunk(job: Job, number: int, threads: int = 1) -> bytes:
    """Return the bytes of a chunk as they are stored: row by row, little-endian numbers of eight bytes."""
    return job.chunk(*chunk_limits(number, job.rows), threads).astype("<f8").tobytes()


def prepare_chunks(recipe: Recipe) -> Callable[[int], bytes]:
    """Return the function that evaluates a chunk of a job by its number, as `evaluate_chunk`."""
    return partial(evaluate_chunk, recipe.job())
