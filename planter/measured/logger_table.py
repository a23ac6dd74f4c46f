"""Tables as data loggers write them: encoding, separator, decimal mark, preamble, header and units
are detected.

The separator and the decimal mark are those under which the most cells of the file are numbers.
Rows begin at the first line with numbers in the columns that hold numbers elsewhere; the header
stands above it, perhaps as a comment or with a line of units below. Lines without numbers among the
rows are left out and listed; other damage is refused.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter import paths
from planter.errors import InputError
from planter.files import csv_rows, units
from planter.files.record import Record
from planter.files.units import parse_unit
from planter.kernels import Array
from planter.measured.labview import is_labview, read_labview
from planter.text_files import read_text_in_any_encoding

ALIKE = (
    ("N", "kN", "daN", "mN"),
    ("N m", "kN m", "N mm", "N cm"),
    ("mm", "m", "cm", "um"),
    ("deg", "rad", "rev"),
    ("s", "ms", "us", "min", "h"),
    ("rad/s", "r/min", "deg/s"),
    ("rad/s2", "deg/s2"),
    ("m/s", "mm/s"),
    ("m/s2", "mm/s2"),
    ("W", "kW", "mW"),
    ("J", "kJ", "mJ"),
    ("1", "%"),
)
"""Units that a column may have, by their kinds."""

_NAME_AND_UNIT = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\)|/\s*(?P<c>[^/]+)|\sin\s(?P<d>\S+)|_(?P<e>[A-Za-z°]+))\s*"
)
_UNIT_SPELLINGS = {
    "u/min": "r/min",
    "1/min": "r/min",
    "rpm": "r/min",
    "min^-1": "r/min",
    "min-1": "r/min",
    "degree": "deg",
    "degrees": "deg",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "µm": "um",
    "μm": "um",
    "newton": "N",
    "newtons": "N",
    "radian": "rad",
    "radians": "rad",
    "turns": "rev",
    "°": "deg",
}


def list_units(unit: str) -> dict[str, float]:
    """Return the units that a column of a quantity may have, each in parts of the quantity's
    display unit.

    >>> list_units("mm")["m"], list_units("N")["daN"]
    (1000.0, 10.0)
    """
    alike = next((names for names in ALIKE if (unit or "1") in names), (unit,))
    return {name: parse_unit(name).factor / parse_unit(unit).factor for name in alike}


def find_factor(allowed: dict[str, float], unit: str) -> float | None:
    """Return the factor of a unit in any spelling, None if it is not allowed.

    >>> find_factor(list_units("N m"), "kN·m"), find_factor(list_units("s"), "sec")
    (1000.0, 1.0)
    >>> find_factor(list_units("s"), "N")
    """
    by_spelling = {normalise_unit(name): factor for name, factor in allowed.items()}
    return by_spelling.get(normalise_unit(unit))


def split_unit(name: str) -> tuple[str, str | None]:
    """Return a header's name and unit, None without a unit; an ending after `_` counts if it is
    one.

    >>> split_unit("Kraft [N]"), split_unit("F / kN"), split_unit("phi_rad"), split_unit("support_force")
    (('Kraft', 'N'), ('F', 'kN'), ('phi', 'rad'), ('support_force', None))
    """
    if suffix := units.unit_suffix(name):
        return name.removesuffix(suffix), units.display_unit(name)
    match = _NAME_AND_UNIT.fullmatch(name)
    if match is None or not match["name"]:
        return name, None
    unit = next(match[key] for key in "abcde" if match[key] is not None).strip()
    if (match["d"] or match["e"]) and normalise_unit(unit) not in KNOWN:
        return name, None
    return match["name"], unit or None


def normalise_unit(unit: str) -> str:
    """Return a unit without signs of multiplication and with one spelling.

    >>> normalise_unit("N·m"), normalise_unit("U/min"), normalise_unit("µm")
    ('Nm', 'r/min', 'um')
    """
    text = re.sub(r"[\s·⋅*_]", "", unit)
    return _UNIT_SPELLINGS.get(text.lower(), text)


KNOWN = frozenset(normalise_unit(name) for names in ALIKE for name in names) - {"1", "h"}
"""Spellings that count as units without brackets."""


LIMIT_BYTES = 50_000_000
SAMPLE = 400
"""Lines, evenly spread over the file, from which the layout is detected."""
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}
COMMENTS = ("#", "%", "//", "!")
MISSING = {"", "-", "--", "---", "nan", "na", "n/a", "#n/a", "null", "none", "missing"}
OVERFLOW = {
    "over",
    "overflow",
    "overload",
    "ovl",
    "ovld",
    "ol",
    "inf",
    "+inf",
    "-inf",
    "err",
    "error",
    "#error",
}
STATES = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0, "high": 1.0, "low": 0.0}
LISTED_LINES = 5
"""Number of lines that a record names."""
HALF = 0.5
"""Share of the rows in which a column of numbers holds a number."""
LONGEST_UNIT = 8
"""Characters of a unit in a line of units."""
DAY_S = 86_400.0
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_CLOCK = re.compile(
    r"(?:(?P<date>\d{4}-\d\d?-\d\d?|\d\d?\.\d\d?\.\d{4}|\d\d?/\d\d?/\d{4})[ T])?"
    r"(?P<h>\d\d?):(?P<m>\d\d)(?::(?P<s>\d\d(?:[.,]\d+)?))?"
)
_BRACKETED = re.compile(r"[\[(]([^\])]*)[\])]")
_SPACED_CELL = re.compile(r"\S+(?:\s+[\[(][^\])]*[\])])?")


@dataclass(frozen=True)
class DroppedRows(Record):
    """Rows of a file that were left out: why, how many, and the first lines of them."""

    reason: str
    count: int
    lines: list[int]

    @classmethod
    def at_lines(cls, reason: str, lines: Sequence[int]) -> DroppedRows:
        """Return the record of some lines."""
        return cls(reason, len(lines), [int(line) for line in lines[:LISTED_LINES]])


@dataclass(frozen=True)
class _Layout:
    separator: str
    decimal: str
    columns: int

    def split(self, line: str, strict: bool = False) -> list[str]:
        """Return the stripped cells of a line. Raises csv.Error for an open quote if `strict`."""
        if self.separator == " ":
            return line.split()
        return [cell.strip() for cell in next(self._open_reader(line, strict), [])]

    def _open_reader(self, line: str, strict: bool) -> Iterator[list[str]]:
        return csv.reader([line], delimiter=self.separator, skipinitialspace=True, strict=strict)

    def number(self, cell: str) -> float | None:
        """Return the number, the state or the time [s] in a cell, None for another text."""
        text = cell.replace("\u2212", "-")
        if self.decimal == ",":
            text = text.replace(",", ".") if "." not in text else ""
        if _NUMBER.fullmatch(text):
            return float(text)
        return STATES.get(cell.lower(), _read_clock(cell))


@dataclass(frozen=True)
class LoggerTable:
    """Rows of cells (n, k) with their lines in the file, under names and units (None if the file
    has none).

    `header_line` is None if columns are numbered from 1.
    """

    source: str
    encoding: str
    layout: _Layout
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    header_line: int | None
    preamble: int
    lines: tuple[int, ...]
    rows: tuple[tuple[str, ...], ...]
    dropped: tuple[DroppedRows, ...]
    form: str = ""
    """Name of the file's format, empty for a table of cells."""

    def describe(self) -> str:
        """Return a description of the file's form."""
        decimals = ", decimal commas" if self.layout.decimal == "," else ""
        head = (
            "no header: columns are numbered from 1"
            if self.header_line is None
            else f"header in line {self.header_line}"
        )
        above = f" below {self.preamble} other lines" if self.preamble else ""
        form = f"{self.form}, " if self.form else ""
        return (
            f"{form}{self.encoding}, columns separated by "
            f"{SEPARATORS[self.layout.separator]}{decimals}; {head}{above}"
        )

    def find_column(self, name: str, option: str) -> int:
        """Return the index of a column by its name, with or without its unit, by its number, or by
        a part of its name.

        Of columns of one name with the same numbers it is the first. Raises InputError if no column
        or several fit.
        """
        bare_names = [split_unit(each)[0] for each in self.names]
        for names in (self.names, bare_names):
            indices = [i for i, each in enumerate(names) if each == name]
            if indices and self._are_equal(indices):
                return indices[0]
            if indices:
                numbers = " or ".join(str(i + 1) for i in indices)
                raise InputError(
                    f"{self.source}: {option} = {name}: several columns have this name: use "
                    f"{numbers}"
                )
        if name.isdigit() and 1 <= int(name) <= len(self.names):
            return int(name) - 1
        folded = name.casefold()
        parts = [i for i, each in enumerate(bare_names) if name and folded in each.casefold()]
        if len(parts) == 1:
            return parts[0]
        if parts:
            candidates = " or ".join(repr(self.names[i]) for i in parts)
            raise InputError(
                f"{self.source}: {option} = {name}: several columns have this in their names: "
                f"{candidates}"
            )
        bare = dict(zip(bare_names, self.names, strict=True))
        close = paths.find_similar(name, [*self.names, *bare])
        hint = f"did you mean {bare.get(close[0], close[0])!r}? " if close else ""
        columns = ", ".join(map(repr, self.names))
        raise InputError(
            f"{self.source}: {option} = {name} is not a column: {hint}it must be one of {columns}"
        )

    def _are_equal(self, columns: Sequence[int]) -> bool:
        """Return whether columns hold the same numbers."""
        if len(columns) == 1:
            return True
        first, *later = (self.read_numbers(i)[0] for i in columns)
        return all(np.array_equal(first, other, equal_nan=True) for other in later)

    def read_numbers(self, column: int) -> tuple[Array, list[int]]:
        """Return the numbers (n,) of a column, NaN at gaps, and the indices of rows where the
        logger overflowed.

        Raises InputError, which names the line, for a cell with another text, and for a column
        without any number.
        """
        numbers, overflows = np.empty(len(self.rows)), []
        for i, row in enumerate(self.rows):
            value = self.layout.number(row[column])
            if value is None:
                word = row[column].lower()
                if word in OVERFLOW:
                    overflows.append(i)
                elif word not in MISSING:
                    raise self._refuse_cell(i, column)
                value = np.nan
            elif not abs(value) <= csv_rows.LARGEST:
                raise self._refuse_cell(i, column)
            numbers[i] = value
        if not np.isfinite(numbers).any():
            raise InputError(
                f"{self.source}: column {self.names[column]} holds no number in any of "
                f"{len(self.rows)} rows; name "
                "another column"
            )
        return numbers, overflows

    def survey_column(self, column: int) -> tuple[Array, str | None]:
        """Return the finite numbers (m,) of a column, and its first cell that is neither a number
        nor a gap, if any.
        """
        numbers, text = [], None
        for row in self.rows:
            value = self.layout.number(row[column])
            if value is not None and np.isfinite(value):
                numbers.append(value)
            elif value is None and text is None and row[column].lower() not in MISSING | OVERFLOW:
                text = row[column]
        return np.array(numbers), text

    def _refuse_cell(self, row: int, column: int) -> InputError:
        cell = row_text = self.rows[row][column]
        place = (
            f"{self.source}: line {self.lines[row]}, column {self.names[column]}: "
            f"{csv_rows.shorten_text(row_text)}"
        )
        other = "." if self.layout.decimal == "," else ","
        mark = "comma" if self.layout.decimal == "," else "point"
        if other in cell and any(character.isdigit() for character in cell):
            hint = (
                f"the decimal mark of this file is a {mark}: write the number with it and "
                f"without other marks"
            )
        else:
            hint = "correct the number, leave the cell empty, or leave the line out"
        return InputError(f"{place}: it must be a finite number; {hint}")


def read_logger_table(path: str | Path) -> LoggerTable:
    """Read a table.

    Raises InputError, which names file, line and remedy, for what is no table of numbers.
    """
    text, encoding = read_text_in_any_encoding(path, LIMIT_BYTES)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    source = str(path)
    if not any(line.strip() for line in lines):
        raise InputError(f"{source}: the file is empty, it must have a header and rows of numbers")
    if is_labview(lines):
        return _read_labview_table(lines, source, encoding)
    layout = _detect_layout(lines, source)
    numeric = _find_numeric_columns(lines, layout)
    first = _find_first_row(lines, layout, numeric, source)
    names, units, header_line = _find_header(lines[:first], layout)
    if header_line is None:
        _check_decimal_commas(lines, first, layout, source)
    rows, row_lines, dropped = _read_rows(lines, first, layout, numeric, names, source)
    width = layout.columns
    if header_line is None:
        names, units = tuple(str(i + 1) for i in range(width)), (None,) * width
    above = first if header_line is None else header_line - 1
    preamble = sum(bool(line.strip()) and not _is_comment(line) for line in lines[:above])
    return LoggerTable(
        source,
        encoding,
        layout,
        names,
        units,
        header_line,
        preamble,
        tuple(row_lines),
        tuple(rows),
        tuple(dropped),
    )


def _read_labview_table(lines: Sequence[str], source: str, encoding: str) -> LoggerTable:
    table = read_labview(lines, source)
    stated = [split_unit(name)[1] for name in table.names]
    # names such as Dev0/Ai0 have no unit behind the slash
    bare = [unit if unit and normalise_unit(unit) in KNOWN else None for unit in stated]
    units = [unit or other for unit, other in zip(table.units, bare, strict=True)]
    segments = f" of {table.segments} segments" if table.segments > 1 else ""
    return LoggerTable(
        source,
        encoding,
        _Layout(table.separator, table.decimal, len(table.names)),
        table.names,
        tuple(units),
        table.header_line,
        sum(bool(line.strip()) for line in lines[: table.header_line - 1]),
        table.lines,
        table.rows,
        (),
        f"LabVIEW measurement{segments}",
    )


def _read_clock(cell: str) -> float | None:
    """Return the time [s] of a clock, with the days of its date."""
    match = _CLOCK.fullmatch(cell)
    if match is None:
        return None
    seconds = (
        3600 * int(match["h"]) + 60 * int(match["m"]) + float((match["s"] or "0").replace(",", "."))
    )
    if match["date"] is None:
        return seconds
    numbers = [int(part) for part in re.split(r"[-./]", match["date"])]
    year, month, day = numbers if len(match["date"].split("-")) > 1 else numbers[::-1]
    try:
        days = (
            np.datetime64(f"{year:04d}-{month:02d}-{day:02d}") - np.datetime64("2000-01-01")
        ).astype(int)
    except ValueError:  # month before day
        return None
    return float(days) * DAY_S + seconds


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENTS)


def _detect_layout(lines: Sequence[str], source: str) -> _Layout:
    """Return separator and decimal mark under which most cells of a sample are numbers."""
    written = [line for line in lines if line.strip() and not _is_comment(line)]
    places = np.unique(np.linspace(0, len(written) - 1, min(SAMPLE, len(written))).astype(int))
    sample = [written[i] for i in places]
    longest = max(map(len, sample), default=0)
    if longest > 100 * csv_rows.LONGEST:
        raise InputError(f"{source}: a line has {longest} characters, which no row of a table has")
    best: tuple[int, _Layout] | None = None
    for separator in SEPARATORS:
        for decimal in (".", ","):
            trial = _Layout(separator, decimal, 0)
            try:
                rows = [trial.split(line) for line in sample]
            except csv.Error:
                continue
            rows = [row for row in rows if any(trial.number(cell) is not None for cell in row)]
            for columns in Counter(map(len, rows)):
                cells = [
                    cell
                    for row in rows
                    if len(row) == columns
                    for cell in row
                    if cell.lower() not in MISSING
                ]
                numbers = sum(trial.number(cell) is not None for cell in cells)
                score = 2 * numbers - len(cells)
                if columns > 1 and (best is None or score > best[0]):
                    best = score, _Layout(separator, decimal, columns)
    if best is None or best[0] <= 0:
        line = next(i for i, line in enumerate(lines, 1) if line.strip())
        raise InputError(
            f"{source}: line {line} is {csv_rows.shorten_text(lines[line - 1].strip())}, and no "
            f"rows of at least two "
            "numbers follow; save the measurement as a CSV with columns separated by semicolons, "
            "tabs or commas"
        )
    return best[1]


def _cells(layout: _Layout, line: str, strict: bool = False) -> list[str]:
    """Return the cells of a line, without empty ones beyond the columns."""
    cells = layout.split(line, strict)
    while len(cells) > layout.columns and not cells[-1]:
        cells.pop()
    return cells


def _find_numeric_columns(lines: Sequence[str], layout: _Layout) -> list[int]:
    """Return the columns that hold numbers in at least half of the rows."""
    counts, total = np.zeros(layout.columns), 0
    for line in lines:
        if not line.strip() or _is_comment(line):
            continue
        cells = _cells(layout, line)
        flags = [layout.number(cell) is not None for cell in cells]
        if len(cells) == layout.columns and any(flags):
            counts, total = counts + flags, total + 1
    numeric: list[int] = np.flatnonzero(counts >= HALF * total).tolist()
    return numeric


def _find_first_row(
    lines: Sequence[str], layout: _Layout, numeric: Sequence[int], source: str
) -> int:
    """Return the index of the first row that another one follows, else of the first one."""
    rows = (i for i, line in enumerate(lines) if _is_row(layout, numeric, line, lines[i + 1 :]))
    single = (i for i, line in enumerate(lines) if _has_numbers(layout, numeric, line))
    first = next(rows, None)
    first = next(single, None) if first is None else first
    if first is None:
        raise InputError(
            f"{source}: no row has numbers in all columns where most rows have them, columns "
            f"{', '.join(str(i + 1) for i in numeric)}; leave lines of other text out"
        )
    return first


def _is_row(layout: _Layout, numeric: Sequence[int], line: str, following: Sequence[str]) -> bool:
    """Return whether a line holds numbers, and so does the next one that is written, if any."""
    if not _has_numbers(layout, numeric, line):
        return False
    later = next((other for other in following if other.strip()), None)
    return (
        later is None
        or _has_numbers(layout, numeric, later)
        or len(_cells(layout, later)) != layout.columns
    )


def _has_numbers(layout: _Layout, numeric: Sequence[int], line: str) -> bool:
    if not line.strip() or _is_comment(line):
        return False
    cells = _cells(layout, line)
    if len(cells) != layout.columns:
        return False
    flags = [layout.number(cells[i]) is not None for i in numeric]
    blanks = [cells[i].lower() in MISSING or cells[i].lower() in OVERFLOW for i in numeric]
    return any(flags) and all(flag or blank for flag, blank in zip(flags, blanks, strict=True))


def _find_header(
    above: Sequence[str], layout: _Layout
) -> tuple[tuple[str, ...], tuple[str | None, ...], int | None]:
    """Return names, units and line of the header: the last line above the rows with a cell for each
    column.
    """
    candidates: list[tuple[int, list[str]]] = []
    for number in range(len(above), 0, -1):
        line = above[number - 1].strip(" ")
        if not line.strip():
            continue
        for mark in COMMENTS:
            line = line.removeprefix(mark).strip(" ")
        cells = _split_header(layout, line)
        if len(cells) == layout.columns and not all(
            layout.number(cell) is not None for cell in cells
        ):
            candidates.append((number, cells))
        if len(candidates) == 2 or not cells:
            break
    if not candidates:
        return (), (), None
    units: tuple[str | None, ...] = ()
    if len(candidates) > 1 and _are_units(candidates[0][1]):
        units = tuple(_BRACKETED.sub(r"\1", cell).strip() or None for cell in candidates[0][1])
        candidates = candidates[1:]
    number, cells = candidates[0]
    names = tuple(cell or str(i) for i, cell in enumerate(cells, 1))
    return names, units or tuple(split_unit(name)[1] for name in names), number


def _check_decimal_commas(lines: Sequence[str], first: int, layout: _Layout, source: str) -> None:
    """Raise InputError if the line above the rows has fewer cells because commas separate columns
    and decimals.
    """
    above = lines[first - 1].strip() if first else ""
    names = _cells(layout, above) if above and not _is_comment(above) else []
    if layout.separator == "," and 1 < len(names) < layout.columns:
        raise InputError(
            f"{source}: line {first} names {len(names)} columns, but the rows below have "
            f"{layout.columns}; are there "
            "decimal commas? separate columns by semicolons, or write 1.5, not 1,5"
        )


def _split_header(layout: _Layout, line: str) -> list[str]:
    if layout.separator != " ":
        return _cells(layout, line)
    return next(
        (
            cells
            for cells in (line.split(), re.split(r"\s{2,}", line), _SPACED_CELL.findall(line))
            if len(cells) == layout.columns
        ),
        [],
    )


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a line below the header holds units: at least half are known or in
    brackets.
    """
    is_unit = [bool(_BRACKETED.fullmatch(cell)) or normalise_unit(cell) in KNOWN for cell in cells]
    filled = sum(bool(cell) for cell in cells)
    return 0 < filled <= 2 * sum(is_unit) and max(map(len, cells)) <= LONGEST_UNIT


def _read_rows(
    lines: Sequence[str],
    first: int,
    layout: _Layout,
    numeric: Sequence[int],
    names: Sequence[str],
    source: str,
) -> tuple[list[tuple[str, ...]], list[int], list[DroppedRows]]:
    """Return the rows from a line on, with their lines, and which lines were left out."""
    rows: list[tuple[str, ...]] = []
    row_lines: list[int] = []
    texts: list[int] = []
    cut: list[int] = []
    last = max(i for i, line in enumerate(lines) if line.strip())
    for i in range(first, last + 1):
        line = lines[i]
        if not line.strip() or _is_comment(line):
            continue
        try:
            cells = _cells(layout, line, strict=True)
        except csv.Error as error:
            raise InputError(
                f"{source}: line {i + 1} is not valid CSV: {error}; close the quote or leave it out"
            ) from None
        if max(map(len, cells), default=0) > csv_rows.LONGEST:
            raise InputError(
                f"{source}: line {i + 1} has a cell of more than {csv_rows.LONGEST} characters"
            )
        is_number = [layout.number(cell) is not None for cell in cells]
        if len(cells) == layout.columns:
            if any(is_number[k] for k in numeric) or all(
                cells[k].lower() in MISSING for k in numeric
            ):
                rows.append(tuple(cells))
                row_lines.append(i + 1)
            else:
                texts.append(i + 1)
        elif not any(is_number):
            texts.append(i + 1)
        elif i == last and len(cells) < layout.columns:
            cut.append(i + 1)
        else:
            commas = layout.separator == "," and len(cells) > layout.columns
            hint = (
                "are there decimal commas? separate columns by semicolons, or write 1.5, not 1,5"
                if commas
                else "complete the line or leave it out"
            )
            raise InputError(
                f"{source}: line {i + 1} has {len(cells)} cells, but other rows have "
                f"{layout.columns}; {hint}"
            )
    dropped = []
    if texts:
        dropped.append(DroppedRows.at_lines("lines of text among the rows", texts))
    if cut:
        dropped.append(DroppedRows.at_lines("last line, which is cut off", cut))
    if names and rows and len(names) != layout.columns:
        raise InputError(
            f"{source}: the header names {len(names)} columns, but rows have {layout.columns}"
        )
    return rows, row_lines, dropped
