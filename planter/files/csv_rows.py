"""CSV text read as rows with line numbers for messages, and rows formatted as CSV text.

Lines that start with `#` are comments, and empty lines are skipped. The first other line is the
header. Columns are separated by commas, or by semicolons or tabs, if there are more of them in the
header; decimals then may have a comma too, as spreadsheets write them in many countries.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from planter import safe_text
from planter.errors import InputError
from planter.files.fields import Positive, Real, value_error
from planter.text_files import read_text

LARGEST = 1e100
"""Default limit of the size of numbers, whose squares stay finite."""
LONGEST = 1000
"""Maximum number of characters of a cell."""
SEPARATORS = ",;\t"
"""Marks between columns; the first of those that the header has most of counts."""
_SHOWN = 60
_OTHER_KIND = re.compile(r"\s*(\[[^\],]*\]\s*(#.*)?|\[\[.*|[\w.-]+\s*=.*|\{.*)")
"""The first line of a TOML or JSON file."""


def format_csv(
    comments: Iterable[str], head: Iterable[str], rows: Iterable[Iterable[object]]
) -> str:
    """Return CSV text with comment lines that start with `#`, the header and rows; None is an empty
    cell.
    """
    text = io.StringIO()
    for comment in comments:
        text.writelines(
            f"# {line}".rstrip() + "\n" for line in safe_text.sanitise_text(comment).split("\n")
        )
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(safe_text.sanitise_line, head))
    writer.writerows(rows)
    return text.getvalue()


@dataclass(frozen=True)
class CsvTable:
    """Comments with their lines, a header, and rows of stripped cells with their lines."""

    source: str
    comments: tuple[tuple[int, str], ...]
    header: tuple[str, ...]
    lines: tuple[int, ...]
    rows: tuple[tuple[str, ...], ...]

    def column(self, name: str) -> list[str]:
        """Return the cells of a column. Raises InputError for the first empty one."""
        index = self.header.index(name)
        cells = [row[index] for row in self.rows]
        if "" in cells:
            raise InputError(
                f"{self.place(cells.index(''), name)}: it is empty: fill it in, or leave the line "
                f"out"
            )
        return cells

    def numbers(self, name: str, largest: float = LARGEST) -> list[float]:
        """Return the cells of a column as numbers of at most `largest` in size.

        Raises InputError for other cells.
        """
        return [
            self._number(row, name, cell, largest) for row, cell in enumerate(self.column(name))
        ]

    def place(self, row: int, name: str) -> str:
        """Return the file, line and column of a cell, for messages."""
        return f"{self.source}: line {self.lines[row]}, column {name}"

    def _number(self, row: int, name: str, cell: str, largest: float) -> float:
        value = parse_number(cell)
        if value is None or not abs(value) <= largest:
            pointed = cell.replace(",", ".")
            hint = (
                f" (with a decimal point: {pointed})"
                if pointed != cell and is_finite_number(pointed)
                else ""
            )
            allowed = f"it must be a finite number of at most {largest:g} in size{hint}"
            raise InputError(f"{self.place(row, name)}: {shorten_text(cell)}: {allowed}")
        return value


def parse_number(cell: str) -> float | None:
    """Return the number in a cell, NaN and infinities included; None if the cell is not a number.

    >>> parse_number("1.5"), parse_number("1_5"), parse_number("high")
    (1.5, None, None)
    """
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return None


def is_finite_number(cell: str) -> bool:
    """Return whether a cell is a finite number."""
    value = parse_number(cell)
    return value is not None and math.isfinite(value)


def shorten_text(text: str) -> str:
    """Return text in quotes, cut to a reasonable length."""
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}...")


def read_table(text: str, source: str, columns: Sequence[str] = ()) -> CsvTable:
    """Read the table of a CSV text, which must have exactly the `columns`, if any are named, in any
    order.

    Raises InputError, which names source and line, if the header or the rows are missing, column
    names are empty, occur twice or differ from `columns`, a row and the header differ in length, or
    the text is not CSV.
    """
    expected = f"the header {','.join(columns)}" if columns else "a header"
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    comments = tuple(
        (i, line.lstrip()[1:].strip()) for i, line in enumerate(lines, 1) if _is_comment(line)
    )
    records = _records(["" if _is_comment(line) else line for line in lines], source)
    first = next(records, None)
    if first is None:
        raise InputError(f"{source}: the file is empty, it must have {expected} and rows")
    line, header = first
    if _OTHER_KIND.fullmatch(lines[line - 1]):
        raise InputError(
            f"{source}: line {line} is {shorten_text(lines[line - 1])}, as in a file of another "
            f"kind, but it must be a CSV file: {expected}, then rows"
        )
    _check_header(header, f"{source}: line {line}", columns)
    rows = list(records)
    if not rows:
        raise InputError(
            f"{source}: there is nothing below the header in line {line}, at least one row must "
            f"follow"
        )
    for at, row in rows:
        if len(row) != len(header):
            raise InputError(
                f"{source}: line {at} has {len(row)} cells, but it must have {len(header)} as the "
                f"header "
                f"has{_cut_by_commas(row, len(header))}"
            )
    return CsvTable(
        source, comments, header, tuple(n for n, _ in rows), tuple(row for _, row in rows)
    )


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def _records(lines: Sequence[str], source: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    header = next(filter(str.strip, lines), "")
    separator = max(SEPARATORS, key=header.count)
    reader = csv.reader(lines, strict=True, delimiter=separator)
    try:
        for record in reader:
            longest = max(map(len, record), default=0)
            if longest > LONGEST:
                raise InputError(_too_long(source, reader.line_num))
            if any(cell.strip() for cell in record):
                yield reader.line_num, tuple(_read_cell(cell, separator) for cell in record)
    except csv.Error as error:
        if "field larger" in str(error):
            raise InputError(_too_long(source, reader.line_num)) from None
        raise InputError(f"{source}: line {reader.line_num} is not valid CSV: {error}") from None


def _read_cell(cell: str, separator: str) -> str:
    """Return a stripped cell; decimals have a comma where it does not separate columns."""
    text = cell.strip()
    return text if separator == "," else safe_text.replace_decimal_comma(text) or text


def _too_long(source: str, line: int) -> str:
    return (
        f"{source}: line {line} has a cell of more than {LONGEST} characters, but it must not "
        f"have (is a quote open?)"
    )


def _check_header(header: Sequence[str], place: str, columns: Sequence[str]) -> None:
    if columns and set(header) != set(columns):
        raise InputError(
            f"{place}: the header {shorten_text(','.join(header))}: it must be {','.join(columns)}"
            f"{' (the line holds numbers, the names of the columns must stand above)' if _all_numbers(header) else ''}"
        )
    if "" in header:
        raise InputError(
            f"{place}: column {header.index('') + 1} has no name, but every column must have one"
        )
    twice = next((name for i, name in enumerate(header) if name in header[:i]), None)
    if twice is not None:
        raise InputError(
            f"{place}: the header names {twice} twice, but the names of columns must differ"
        )
    if _all_numbers(header):
        raise InputError(f"{place}: the header holds numbers, but it must name the columns")


def _all_numbers(header: Sequence[str]) -> bool:
    return all(parse_number(cell) is not None for cell in header)


def _cut_by_commas(row: Sequence[str], length: int) -> str:
    """Return a hint for a row that decimal commas have split."""
    if len(row) > length and all(cell.lstrip("+-").isdigit() for cell in row):
        return " (are there decimal commas? write 1.5, not 1,5)"
    return ""


COLUMNS = ("x_mm", "y_mm", "tube_mm")
"""Position of a point in the frame of the machine, and maximum distance of the path from it."""
MOST = 200
Point = tuple[Real, Real, Positive]
Points = Annotated[list[Point], Field(min_length=1, max_length=MOST)]


def inline_points(table: Mapping[str, Any], section: str, source: str) -> dict[str, Any]:
    """Return the table of a file with `points_mm` in a section instead of its `points_csv`.

    Raises InputError, which names file and line, if the CSV is invalid or the section has both
    keys.
    """
    values, entries = dict(table), table.get(section)
    if not isinstance(entries, Mapping) or not isinstance(entries.get("points_csv"), str):
        return values
    rest = {key: value for key, value in entries.items() if key != "points_csv"}
    if "points_mm" in rest:
        allowed = "points stand in points_mm or in a CSV, not in both"
        raise value_error(f"{section}.points_csv", entries["points_csv"], allowed, source)
    return values | {
        section: rest | {"points_mm": read_points(Path(source).parent / entries["points_csv"])}
    }


def read_points(path: Path) -> list[list[float]]:
    """Read the points of a CSV with the header `x_mm,y_mm,tube_mm`.

    Raises InputError for other files.
    """
    rows = read_table(read_text(path), str(path), COLUMNS)
    return [list(row) for row in zip(*(rows.numbers(name) for name in COLUMNS), strict=True)]
