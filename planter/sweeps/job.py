"""Work in chunks: any chunk is found alone, anywhere, with the same bytes."""

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
"""Rows of a chunk; the last has what is left."""


class Job(Protocol):
    """Rows of `width` numbers each."""

    rows: int
    width: int

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Rows from `start` to `stop`, (stop - start, width): the same numbers whatever was asked for before.

        A row that has no result holds NaN.
        """


@dataclass(frozen=True)
class Recipe:
    """How any process makes a job: a function, as "package.module:name", and its arguments, fit for JSON."""

    function: str
    arguments: Mapping[str, Any]

    @property
    def task(self) -> Task:
        """The chunks of the job, by their numbers, for workers."""
        return Task(prepare_chunks, {"recipe": self}, is_thread_safe=True)

    def job(self) -> Job:
        module, name = self.function.split(":")
        made: Job = getattr(importlib.import_module(module), name)(**self.arguments)
        return made

    @property
    def text(self) -> str:
        """As JSON: the same for the same question, in the order in which it is asked."""
        return json.dumps(asdict(self), allow_nan=False)

    @property
    def question(self) -> str:
        """A hash of what is asked, of the chunks that it is asked in and of the version that answers."""
        return hashlib.sha256(f"{__version__} {CHUNK} {self.text}".encode()).hexdigest()


def count(rows: int) -> int:
    """Chunks of so many rows."""
    return -(-rows // CHUNK)


def ends(number: int, rows: int) -> tuple[int, int]:
    """First row of a chunk, and the one after its last.

    >>> ends(0, 25_000), ends(2, 25_000)
    ((0, 10000), (20000, 25000))
    """
    return number * CHUNK, min((number + 1) * CHUNK, rows)


def found(job: Job, number: int, threads: int = 1) -> bytes:
    """A chunk as it is kept: its rows one after another, numbers of eight bytes, least significant first."""
    return job.chunk(*ends(number, job.rows), threads).astype("<f8").tobytes()


def prepare_chunks(recipe: Recipe) -> Callable[[int], bytes]:
    """Return the function that evaluates a chunk of a job by its number, as `found`."""
    return partial(found, recipe.job())
