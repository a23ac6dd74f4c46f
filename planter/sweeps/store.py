"""Finished chunks in one SQLite file: a transaction and a hash for each, so that a kill loses none and tears none."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array

PATIENCE_S = 60.0
"""How long another process may hold the file."""
_TABLES = (
    "CREATE TABLE IF NOT EXISTS asked (question TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS chunks (number INTEGER PRIMARY KEY, sha256 TEXT NOT NULL, content BLOB NOT NULL)",
)


class Store:
    """Chunks of the answer to a question, by their numbers; in memory where there is no path.

    What the file holds of another question is dropped, and so is a chunk whose bytes do not fit its hash.
    Raises ComputationError where the file cannot be used. Use as a context.
    """

    def __init__(self, path: Path | None, question: str) -> None:
        self._name = str(path or ":memory:")
        with self._told():
            self._file = sqlite3.connect(self._name, timeout=PATIENCE_S, isolation_level=None, check_same_thread=False)
            self._file.execute("PRAGMA journal_mode=WAL")
            self._file.execute("PRAGMA synchronous=NORMAL")
            self._ask(question)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _ask(self, question: str) -> None:
        with self._transaction():
            for table in _TABLES:
                self._file.execute(table)
            if self._file.execute("SELECT question FROM asked").fetchall() != [(question,)]:
                self._file.execute("DELETE FROM chunks")
                self._file.execute("DELETE FROM asked")
                self._file.execute("INSERT INTO asked VALUES (?)", (question,))

    def done(self) -> set[int]:
        """Numbers of the chunks that are there, whole."""
        with self._told():
            rows = self._file.execute("SELECT number, sha256, content FROM chunks")
            kept = {number: _hash(content) == told for number, told, content in rows}
            for number in (number for number, sound in kept.items() if not sound):
                self._file.execute("DELETE FROM chunks WHERE number = ?", (number,))
        return {number for number, sound in kept.items() if sound}

    def save(self, number: int, content: bytes) -> None:
        """Keep a chunk: whole, whatever happens to this process afterwards."""
        with self._told(), self._transaction():
            self._file.execute("INSERT OR REPLACE INTO chunks VALUES (?, ?, ?)", (number, _hash(content), content))

    def blocks(self, width: int) -> Iterator[Array]:
        """The chunks in their order, (rows, width) each."""
        with self._told():
            for (content,) in self._file.execute("SELECT content FROM chunks ORDER BY number"):
                yield np.frombuffer(content, dtype="<f8").reshape(-1, width)

    def digest(self) -> str:
        """A hash of all chunks in their order: that of the whole answer."""
        with self._told():
            hashes = self._file.execute("SELECT sha256 FROM chunks ORDER BY number")
            return _hash("".join(told for (told,) in hashes).encode())

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
    def _told(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            with suppress(AttributeError, sqlite3.Error):
                self._file.close()
            raise ComputationError(f"{self._name}: this cannot be used to keep chunks ({error})") from error


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
