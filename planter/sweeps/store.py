"""Finished chunks in one SQLite file, each with a transaction and a hash, so that a kill leaves no partial chunk."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.report import folder
from planter.sweeps import job

PATIENCE_S = 60.0
"""Time for which another process may lock the file [s]."""
APPLICATION_ID = 0x706C6E74
"""Mark of databases of planter, "plnt" (PRAGMA application_id of SQLite)."""
_MARK = f"PRAGMA application_id = {APPLICATION_ID}"
_QUESTION = "CREATE TABLE asked (question TEXT NOT NULL)"
_CHUNKS = (
    "CREATE TABLE chunks (question TEXT NOT NULL, number INTEGER NOT NULL, sha256 TEXT NOT NULL, "
    "content BLOB NOT NULL, PRIMARY KEY (question, number)) WITHOUT ROWID"
)


def open_store(path: Path | None, question: str, rows: int, width: int) -> Store:
    """Open a store; within `overwriting(True)`, replace a file that `Store` refuses. Raises as `Store`."""
    try:
        return Store(path, question, rows, width)
    except InputError:
        if path is None or not folder.is_overwriting():
            raise
    for ending in ("", "-wal", "-shm"):
        path.with_name(path.name + ending).unlink(missing_ok=True)
    return Store(path, question, rows, width)


class Store:
    """Stored chunks of a job, `rows` of `width` numbers in all; in memory if `path` is None. Use as a context manager.

    `question` is the hash that identifies the job. A chunk is valid if its hash fits its content, its number and the
    question. Raises InputError if the file belongs to another question or if planter did not write it, and
    ComputationError if it cannot be used.
    """

    def __init__(self, path: Path | None, question: str, rows: int, width: int) -> None:
        self._name, self._question = str(path or ":memory:"), question
        self.rows, self.width = rows, width
        with self._reporting_errors():
            self._file = sqlite3.connect(self._name, timeout=PATIENCE_S, isolation_level=None, check_same_thread=False)
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
            if self._has_earlier_layout():
                self._check_question()
                self._convert()
            (mark,) = self._file.execute("PRAGMA application_id").fetchone()
            if mark != APPLICATION_ID:
                raise self._refusal("this version of planter did not write this file")
            self._check_question()

    def _check_question(self) -> None:
        if self._file.execute("SELECT question FROM asked").fetchall() != [(self._question,)]:
            raise self._refusal("it contains the rows of another plan, machine or version of planter")

    def _has_earlier_layout(self) -> bool:
        """Return whether the file has the layout before 0.2.0: no question in the chunks, and no mark."""
        columns = [column[1] for column in self._file.execute("PRAGMA table_info(chunks)")]
        return columns == ["number", "sha256", "content"]

    def _convert(self) -> None:
        """Convert the valid chunks of the earlier layout."""
        chunks = self._file.execute("SELECT number, sha256, content FROM chunks").fetchall()
        self._file.execute("DROP TABLE chunks")
        for statement in (_MARK, _CHUNKS):
            self._file.execute(statement)
        for number, sha256, content in chunks:
            if _sha256(content) == sha256 and self._fits(number, content):
                row = (self._question, number, self._hash(number, content), content)
                self._file.execute("INSERT INTO chunks VALUES (?, ?, ?, ?)", row)

    def _refusal(self, reason: str) -> InputError:
        return InputError(f"{self._name}: {reason}; choose another --out, or add --overwrite")

    def list_finished(self) -> set[int]:
        """Return the numbers of the valid chunks; delete all others."""
        with self._reporting_errors():
            stored = self._file.execute("SELECT question, number FROM chunks").fetchall()
            sound = {number for question, number in stored if question == self._question and self._is_sound(number)}
            for question, number in stored:
                if question != self._question or number not in sound:
                    self._file.execute("DELETE FROM chunks WHERE question = ? AND number = ?", (question, number))
        return sound

    def save(self, number: int, content: bytes) -> None:
        """Store a chunk in one transaction. Raises as the class."""
        if not self._fits(number, content):
            raise ComputationError(f"{self._name}: chunk {number} has {len(content)} bytes, not those of its rows")
        row = (self._question, number, self._hash(number, content), content)
        with self._reporting_errors(), self._transaction():
            self._check_question()
            self._file.execute("INSERT OR REPLACE INTO chunks VALUES (?, ?, ?, ?)", row)

    def blocks(self) -> Iterator[Array]:
        """Yield the chunks in order, (m, width) each. Raises ComputationError if a chunk is missing or damaged."""
        for content in self._contents():
            yield np.frombuffer(content, dtype="<f8").reshape(-1, self.width)

    def digest(self) -> str:
        """Return the hash of all numbers, read again in order. Raises ComputationError as `blocks`."""
        return _sha256("".join(_sha256(content) for content in self._contents()).encode())

    def _contents(self) -> Iterator[bytes]:
        numbers = range(job.count_chunks(self.rows))
        with self._reporting_errors():
            stored = [row[0] for row in self._file.execute("SELECT number FROM chunks ORDER BY question, number")]
            if stored != list(numbers):
                raise ComputationError(f"{self._name}: the stored chunks are not those of the {self.rows} rows; "
                                       "something else has changed this file, run the command again")  # fmt: skip
            for number in numbers:
                if not self._is_sound(number):
                    raise ComputationError(f"{self._name}: chunk {number} is damaged; run the command again")
                yield self._row(number)[1]

    def _is_sound(self, number: int) -> bool:
        sha256, content = self._row(number)
        return self._fits(number, content) and self._hash(number, content) == sha256

    def _row(self, number: int) -> tuple[str, bytes]:
        row = self._file.execute(
            "SELECT sha256, content FROM chunks WHERE question = ? AND number = ?", (self._question, number)
        ).fetchone()
        return row or ("", b"")

    def _fits(self, number: int, content: bytes) -> bool:
        if number not in range(job.count_chunks(self.rows)) or not isinstance(content, bytes):
            return False
        start, stop = job.chunk_limits(number, self.rows)
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
            raise ComputationError(f"{self._name}: chunks cannot be stored in it ({error})") from error


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
