"""Jobs in chunks, computed in any process with the same bytes, and the SQLite store of finished
chunks.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from planter.errors import ComputationError, InputError, Interrupted
from planter.jobs import Jobs
from planter.kernels import Array
from planter.progress import Listener, ProgressPhase
from planter.report import folder
from planter.task import AUTO, Means, Task, count_cores
from planter.version import __version__

CHUNK = 10_000
"""Rows of a chunk; the last one has the remainder."""


class Job(Protocol):
    """A number of `rows`, of `width` numbers each."""

    rows: int
    width: int

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the rows from `start` to `stop`, (stop - start, width), independent of earlier
        calls.

        A row without a result is NaN.
        """


@dataclass(frozen=True)
class Recipe:
    """Recipe by which any process builds a job: a function "package.module:name" and its arguments,
    fit for JSON.
    """

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
    """Return the bytes of a chunk as they are stored: row by row, little-endian numbers of eight
    bytes.
    """
    return job.chunk(*chunk_limits(number, job.rows), threads).astype("<f8").tobytes()


def prepare_chunks(recipe: Recipe) -> Callable[[int], bytes]:
    """Return the function that evaluates a chunk of a job by its number, as `evaluate_chunk`."""
    return partial(evaluate_chunk, recipe.job())


PATIENCE_S = 60.0
"""Time for which another process may lock the file [s]."""
APPLICATION_ID = 0x706C6E74
"""Mark of databases of planter, "plnt" (PRAGMA application_id of SQLite)."""
_MARK = f"PRAGMA application_id = {APPLICATION_ID}"
_QUESTION = "CREATE TABLE asked (question TEXT NOT NULL)"
_CHUNKS = (
    "CREATE TABLE chunks (number INTEGER NOT NULL PRIMARY KEY, sha256 TEXT NOT NULL, "
    "content BLOB NOT NULL) WITHOUT ROWID"
)
_NUMBERS = "SELECT number FROM chunks ORDER BY number"


def open_store(path: Path | None, question: str, rows: int, width: int) -> Store:
    """Open a store; within `overwriting(True)`, replace a file that `Store` refuses.

    Raises as `Store`.
    """
    try:
        return Store(path, question, rows, width)
    except InputError:
        if path is None or not folder.is_overwriting():
            raise
    for ending in ("", "-wal", "-shm"):
        path.with_name(path.name + ending).unlink(missing_ok=True)
    return Store(path, question, rows, width)


class Store:
    """Stored chunks of a job, `rows` of `width` numbers in all; in memory if `path` is None.

    Use as a context manager.

    `question` is the hash that identifies the job. A chunk is valid if its hash fits its content,
    its number and the question. Raises InputError if the file belongs to another question or if
    planter did not write it, and ComputationError if it cannot be used.
    """

    def __init__(self, path: Path | None, question: str, rows: int, width: int) -> None:
        self._name, self._question = str(path or ":memory:"), question
        self.rows, self.width = rows, width
        with self._reporting_errors():
            self._file = sqlite3.connect(
                self._name, timeout=PATIENCE_S, isolation_level=None, check_same_thread=False
            )
            try:
                self._prepare()
            except BaseException:
                self._file.close()
                raise
            self._file.execute("PRAGMA journal_mode=WAL")
            self._file.execute("PRAGMA synchronous=NORMAL")

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _prepare(self) -> None:
        with self._transaction():
            if not self._file.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                for statement in (_MARK, _QUESTION, _CHUNKS):
                    self._file.execute(statement)
                self._file.execute("INSERT INTO asked VALUES (?)", (self._question,))
            (mark,) = self._file.execute("PRAGMA application_id").fetchone()
            if mark != APPLICATION_ID:
                raise self._refusal("this version of planter did not write this file")
            self._check_question()

    def _check_question(self) -> None:
        if self._file.execute("SELECT question FROM asked").fetchall() != [(self._question,)]:
            raise self._refusal(
                "it contains the rows of another plan, machine or version of planter"
            )

    def _refusal(self, reason: str) -> InputError:
        return InputError(f"{self._name}: {reason}; choose another --out, or add --overwrite")

    def list_finished(self) -> set[int]:
        """Return the numbers of the valid chunks; delete all others."""
        with self._reporting_errors():
            stored = [number for (number,) in self._file.execute(_NUMBERS)]
            sound = set(filter(self._is_sound, stored))
            for number in stored:
                if number not in sound:
                    self._file.execute("DELETE FROM chunks WHERE number = ?", (number,))
        return sound

    def save(self, number: int, content: bytes) -> None:
        """Store a chunk in one transaction. Raises as the class."""
        if not self._fits(number, content):
            raise ComputationError(
                f"{self._name}: chunk {number} has {len(content)} bytes, not those of its rows"
            )
        row = (number, self._hash(number, content), content)
        with self._reporting_errors(), self._transaction():
            self._check_question()
            self._file.execute("INSERT OR REPLACE INTO chunks VALUES (?, ?, ?)", row)

    def blocks(self) -> Iterator[Array]:
        """Yield the chunks in order, (m, width) each.

        Raises ComputationError if a chunk is missing or damaged.
        """
        for content in self._contents():
            yield np.frombuffer(content, dtype="<f8").reshape(-1, self.width)

    def digest(self) -> str:
        """Return the hash of all numbers, read again in order.

        Raises ComputationError as `blocks`.
        """
        return _sha256("".join(_sha256(content) for content in self._contents()).encode())

    def _contents(self) -> Iterator[bytes]:
        numbers = range(count_chunks(self.rows))
        with self._reporting_errors():
            stored = [number for (number,) in self._file.execute(_NUMBERS)]
            if stored != list(numbers):
                raise ComputationError(
                    f"{self._name}: the stored chunks are not those of the {self.rows} rows; "
                    "something else has changed this file, run the command again"
                )
            for number in numbers:
                if not self._is_sound(number):
                    raise ComputationError(
                        f"{self._name}: chunk {number} is damaged; run the command again"
                    )
                yield self._row(number)[1]

    def _is_sound(self, number: int) -> bool:
        sha256, content = self._row(number)
        return self._fits(number, content) and self._hash(number, content) == sha256

    def _row(self, number: int) -> tuple[str, bytes]:
        row = self._file.execute(
            "SELECT sha256, content FROM chunks WHERE number = ?", (number,)
        ).fetchone()
        return row or ("", b"")

    def _fits(self, number: int, content: bytes) -> bool:
        if number not in range(count_chunks(self.rows)) or not isinstance(content, bytes):
            return False
        start, stop = chunk_limits(number, self.rows)
        return len(content) == 8 * self.width * (stop - start)

    def _hash(self, number: int, content: bytes) -> str:
        return _sha256(f"{self._question} {number} ".encode() + content)

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._file.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._file.execute("ROLLBACK")
            raise
        self._file.execute("COMMIT")

    @contextmanager
    def _reporting_errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            with suppress(AttributeError, sqlite3.Error):
                self._file.close()
            if error.sqlite_errorname == "SQLITE_NOTADB":
                raise self._refusal("planter did not write this file") from None
            raise ComputationError(
                f"{self._name}: chunks cannot be stored in it ({error})"
            ) from error


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


FEWEST = 20_000
"""Number of rows from which worker processes are started."""


@dataclass(frozen=True)
class JobRun:
    """Outcome of a job: numbers of chunks reused and of workers started."""

    resumed: int
    workers: int


def run_job(
    recipe: Recipe, store: Store, means: Means = AUTO, progress: Listener | None = None
) -> JobRun:
    """Compute every chunk that the store lacks.

    Raises ComputationError if a chunk cannot be computed, and Interrupted with the number of
    finished rows on Ctrl-C.
    """
    rows, done = store.rows, store.list_finished()
    todo = [number for number in range(count_chunks(rows)) if number not in done]
    resumed_rows = sum(stop - start for start, stop in (chunk_limits(n, rows) for n in done))
    phase = ProgressPhase("sweep", "row", rows, progress, resumed_rows)
    if resumed_rows:
        phase.report(resumed_rows, "done before")
    is_local = not todo or (means.cluster is None and rows < FEWEST)
    try:
        with nullcontext() if is_local else Jobs(recipe.task, todo, means) as jobs:
            for number, content in _compute_chunks(recipe, todo, jobs):
                store.save(number, content)
                start, stop = chunk_limits(number, rows)
                phase.report(phase.done + stop - start)
    except KeyboardInterrupt:
        raise Interrupted({"rows": rows, "rows_done": phase.done}) from None
    return JobRun(len(done), 0 if jobs is None else jobs.workers)


def _compute_chunks(
    recipe: Recipe, todo: Sequence[int], jobs: Jobs | None
) -> Iterator[tuple[int, bytes]]:
    """Yield numbers and contents of chunks: those of jobs, else those that all cores of this
    process evaluate.
    """
    if jobs is not None:
        for answer in jobs:
            yield todo[answer.job], answer.result
    elif todo:
        job = recipe.job()
        for number in todo:
            yield number, evaluate_chunk(job, number, count_cores())
