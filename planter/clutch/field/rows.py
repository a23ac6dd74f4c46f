"""CSV text as rows that know their lines, so that every complaint can name its place."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from planter.errors import InputError

LARGEST = 1e100
"""Numbers beyond this are refused: their squares would not be finite."""


@dataclass(frozen=True)
class Table:
    """Comments with their lines, a header, and rows of stripped cells with their lines."""

    source: str
    comments: tuple[tuple[int, str], ...]
    header: tuple[str, ...]
    lines: tuple[int, ...]
    rows: tuple[tuple[str, ...], ...]

    def column(self, name: str) -> list[str]:
        """The cells of a column. Raises InputError for the first empty one."""
        index = self.header.index(name)
        cells = [row[index] for row in self.rows]
        if "" in cells:
            raise InputError(f"{self.place(cells.index(''), name)}: nothing stands there, but a value is missing")
        return cells

    def numbers(self, name: str) -> list[float]:
        """The cells of a column as finite numbers. Raises InputError for the first that is none."""
        return [self._number(row, name, cell) for row, cell in enumerate(self.column(name))]

    def place(self, row: int, name: str) -> str:
        """Where a cell stands, in words."""
        return f"{self.source}: line {self.lines[row]}, column {name}"

    def _number(self, row: int, name: str, cell: str) -> float:
        value = number(cell)
        if value is None or not abs(value) <= LARGEST:
            allowed = f"it must be a finite number of at most {LARGEST:g} in size"
            raise InputError(f"{self.place(row, name)}: {cell!r} is not allowed, {allowed}")
        return value


def number(cell: str) -> float | None:
    """The number that a cell holds, NaN and infinities included; None if it holds none.

    >>> number("1.5"), number("1_5"), number("high")
    (1.5, None, None)
    """
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return None


def finite(cell: str) -> bool:
    """Whether a cell holds a finite number."""
    value = number(cell)
    return value is not None and math.isfinite(value)


def read(text: str, source: str) -> Table:
    """The table of a CSV text; lines that start with `#` may stand above the header, empty lines anywhere.

    Raises InputError, naming source and line, for a text without header or rows, column names that are empty or occur
    twice, rows that are not as long as the header, and what is no CSV.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
    comments = tuple((i, line[1:].strip()) for i, line in enumerate(lines[:first], 1) if line.startswith("#"))
    records = list(_records(lines[first:], first, source))
    if not records:
        raise InputError(f"{source}: the file is empty, it must have a header and rows")
    (line, header), *rows = records
    _check_header(header, f"{source}: line {line}")
    if not rows:
        raise InputError(f"{source}: there is nothing below the header in line {line}, at least one row must follow")
    for line, row in rows:
        if len(row) != len(header):
            raise InputError(
                f"{source}: line {line} has {len(row)} cells, but it must have {len(header)} as the header has"
            )
    return Table(source, comments, header, tuple(line for line, _ in rows), tuple(row for _, row in rows))


def _records(lines: Sequence[str], skipped: int, source: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    reader = csv.reader(lines, strict=True)
    try:
        for record in reader:
            if any(cell.strip() for cell in record):
                yield reader.line_num + skipped, tuple(cell.strip() for cell in record)
    except csv.Error as error:
        raise InputError(f"{source}: line {reader.line_num + skipped} is not valid CSV: {error}") from None


def _check_header(header: Sequence[str], place: str) -> None:
    if "" in header:
        raise InputError(f"{place}: column {header.index('') + 1} has no name, but every column must have one")
    twice = next((name for i, name in enumerate(header) if name in header[:i]), None)
    if twice is not None:
        raise InputError(f"{place}: the header names {twice} twice, but every column must have a name of its own")
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        raise InputError(f"{place}: the header is {header[0]!r}, but columns must be separated by commas")
