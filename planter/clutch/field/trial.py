"""The runs of a field test: factors with levels, responses, blank columns."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from planter.errors import InputError
from planter.files import csv_rows

if TYPE_CHECKING:
    from planter.kernels import Array


Level = int | float | str

_RESPONSE = re.compile(r"[Yy]($|[^A-Za-z])")
_BLANK = re.compile(r"(blank|empty|error)[\s_]*\d*", re.IGNORECASE)
RESERVED = {"total": "factor", "error": "factor", "both": "response", "levels": "response"}
"""Names that results use for something else, and what may not have them."""


@dataclass(frozen=True)
class FieldColumns:
    """Roles that the user assigns to columns, beyond those by their names."""

    responses: tuple[str, ...] = ()
    blanks: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()

    def role(self, name: str) -> str:
        """`response`, `blank`, `run`, `ignored` or `factor`.

        >>> [FieldColumns().role(name) for name in ("Y1", "Yard", "blank2", "run", "A")]
        ['response', 'factor', 'blank', 'run', 'factor']
        """
        if name in self.ignored:
            return "ignored"
        if name in self.blanks:
            return "blank"
        if name in self.responses or (not self.responses and _RESPONSE.match(name)):
            return "response"
        if name.lower() == "run":
            return "run"
        return "blank" if _BLANK.fullmatch(name) else "factor"


@dataclass(frozen=True)
class Factor:
    """A column of levels: `codes` (n,) count from 0 into `levels`; `values` are what numbered
    levels stand for.
    """

    name: str
    levels: tuple[Level, ...]
    codes: NDArray[np.intp]
    label: str = ""
    values: tuple[float, ...] | None = None

    @property
    def scale(self) -> tuple[float, ...] | None:
        """Levels as numbers, for the axis of a figure; None for words."""
        if self.values is not None:
            return self.values
        numbers = tuple(float(level) for level in self.levels if not isinstance(level, str))
        return numbers if len(numbers) == len(self.levels) else None


@dataclass(frozen=True)
class FieldResponse:
    """A measured column (n,)."""

    name: str
    values: Array
    label: str = ""


@dataclass(frozen=True)
class Trial:
    """A field test: n runs."""

    source: str
    factors: tuple[Factor, ...]
    responses: tuple[FieldResponse, ...]
    blanks: tuple[Factor, ...] = field(default=())

    @property
    def runs(self) -> int:
        return len(self.responses[0].values)


def read_trial(text: str, source: str, columns: FieldColumns | None = None) -> Trial:
    """Return the field test in a CSV text; `planter.clutch.field` says how it is written.

    Raises InputError, naming source, line and column, for any other text.
    """
    columns = columns or FieldColumns()
    table = csv_rows.read_table(text, source)
    _check_named(table, columns)
    by_role: dict[str, list[str]] = {
        role: [] for role in ("factor", "response", "blank", "run", "ignored")
    }
    for name in table.header:
        by_role[columns.role(name)].append(name)
    _check_roles(table, by_role)
    legend = Legend.from_table(table)
    responses = tuple(_response(table, name, legend) for name in by_role["response"])
    factors, blanks = (
        tuple(_factor(table, name, legend) for name in by_role[role])
        for role in ("factor", "blank")
    )
    legend.check({name: role for role, names in by_role.items() for name in names})
    for name in by_role["run"]:
        _check_runs(table, name, factors)
    return Trial(source, factors, responses, blanks)


def _check_named(table: csv_rows.CsvTable, columns: FieldColumns) -> None:
    options = {
        "--response": columns.responses,
        "--blank": columns.blanks,
        "--ignore": columns.ignored,
    }
    for option, names in options.items():
        for name in names:
            if name not in table.header:
                raise InputError(
                    f"{option} {name}: {table.source} has no such column, it must be one of "
                    f"{', '.join(table.header)}"
                )


def _check_roles(table: csv_rows.CsvTable, by_role: Mapping[str, Sequence[str]]) -> None:
    listing = ", ".join(table.header)
    if not by_role["response"]:
        raise InputError(
            f"{table.source}: no column is a response (columns: {listing}), it must be called Y, "
            f"Y1, Y2, ..., "
            f"or be named with --response"
        )
    if not by_role["factor"]:
        raise InputError(
            f"{table.source}: no column is a factor (columns: {listing}), there must be at least "
            f"one"
        )
    for name, role in RESERVED.items():
        if name in by_role[role]:
            raise InputError(
                f"{table.source}: the column {name} is a {role}, but results use this name for "
                f"something else, "
                f"so it must have another"
            )


def _response(table: csv_rows.CsvTable, name: str, legend: Legend) -> FieldResponse:
    values = np.array(table.numbers(name))
    if np.ptp(values) == 0:
        raise InputError(
            f"{table.source}: column {name} is {values[0]:g} in every run, but a response must "
            f"vary to be analysed"
        )
    return FieldResponse(name, values, legend.label(name))


def _factor(table: csv_rows.CsvTable, name: str, legend: Legend) -> Factor:
    cells = table.column(name)
    numeric = [csv_rows.parse_number(cell) is not None for cell in cells]
    if any(numeric) and not all(numeric):
        row = numeric.index(False)
        raise InputError(
            f"{table.place(row, name)}: {cells[row]!r} is not a number, but other levels of "
            f"{name} are: "
            f"levels must be all numbers or all words"
        )
    seen: list[Level] = (
        [_plain(value) for value in table.numbers(name)] if all(numeric) else list(cells)
    )
    levels = sorted(set(seen), key=float) if all(numeric) else list(dict.fromkeys(seen))
    if len(levels) == 1:
        raise InputError(
            f"{table.source}: column {name} is {levels[0]} in every run, but a factor must have "
            f"at least two levels"
        )
    levels, values = legend.sort_levels(name, levels)
    code = {level: index for index, level in enumerate(levels)}
    codes = np.array([code[level] for level in seen])
    return Factor(name, tuple(levels), codes, legend.label(name), values)


def _plain(value: float) -> int | float:
    return int(value) if value.is_integer() and abs(value) < 1e15 else value


def _check_runs(table: csv_rows.CsvTable, name: str, factors: Sequence[Factor]) -> None:
    """Runs that are counted leave none out, and those of one number have the same levels."""
    counts = table.numbers(name)
    first: dict[float, int] = {}
    for row, count in enumerate(counts):
        if not count.is_integer():
            raise InputError(f"{table.place(row, name)}: {count!r}: it must be a whole number")
        before = first.setdefault(count, row)
        if any(factor.codes[before] != factor.codes[row] for factor in factors):
            raise InputError(
                f"{table.place(row, name)}: run {int(count)} is in line {table.lines[before]} "
                f"already with other "
                f"levels, but a repetition must have the same"
            )
    low, high = int(min(counts)), int(max(counts))
    missing = next((count for count in range(low, high) if count not in first), None)
    if missing is not None:
        raise InputError(
            f"{table.source}: run {missing} is missing between {low} and {high}, every run must "
            f"be there (to evaluate "
            f"the rest as the unbalanced design that it is, leave the column {name} out with "
            f"--ignore {name})"
        )


_ENTRY = re.compile(r"(factor|response)\s+([^:]+?)\s*:\s*([^=]*?)\s*(?:=\s*(.*))?")


@dataclass(frozen=True)
class LegendEntry:
    """One comment: the line, what it is about, its text, the values of the levels."""

    line: int
    role: str
    label: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class Legend:
    """The comments of a table that are about columns."""

    source: str
    entries: Mapping[str, LegendEntry]

    @classmethod
    def from_table(cls, table: csv_rows.CsvTable) -> Legend:
        """Return the legend of a table from its comments."""
        entries: dict[str, LegendEntry] = {}
        for line, comment in table.comments:
            if match := _ENTRY.fullmatch(comment):
                role, name, label, values = match.groups()
                split = tuple(value.strip() for value in values.split(",")) if values else ()
                entries[name] = LegendEntry(line, role, label, split)
        return cls(table.source, entries)

    def check(self, roles: Mapping[str, str]) -> None:
        """Raise InputError for a comment about a missing column or one of another role."""
        for name, entry in self.entries.items():
            if roles.get(name) != entry.role:
                allowed = ", ".join(column for column, role in roles.items() if role == entry.role)
                raise InputError(
                    f"{self.source}: line {entry.line} explains the {entry.role} {name}, which "
                    f"does not exist, "
                    f"it must be one of {allowed}"
                )

    def label(self, name: str) -> str:
        """Return the meaning of a column, or its name if no comment explains it."""
        return (self.entries[name].label if name in self.entries else "") or name

    def sort_levels(
        self, name: str, levels: list[Any]
    ) -> tuple[list[Any], tuple[float, ...] | None]:
        """Return the levels in their order, and their values if they are numbers.

        Raises InputError for values that do not fit the levels.
        """
        entry = self.entries.get(name)
        if entry is None or not entry.values:
            return levels, None
        words = isinstance(levels[0], str)
        if words and sorted(entry.values) == sorted(levels):
            return list(entry.values), None
        numbers = [float(value) for value in entry.values if csv_rows.is_finite_number(value)]
        if not words and len(numbers) == len(entry.values) == len(set(numbers)) == len(levels):
            return levels, tuple(numbers)
        stated, counted = ", ".join(entry.values), ", ".join(map(str, levels))
        raise InputError(
            f"{self.source}: line {entry.line} gives {name} the values {stated}, but its levels "
            f"are {counted}: "
            f"{'these must stand there, in any order' if words else 'there must be one number for each'}"
        )
