"""The runs of a field test: factors with levels, responses, blank columns."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from planter.clutch.field.legend import Legend
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
class Columns:
    """What the user says about columns, beyond what their names say."""

    responses: tuple[str, ...] = ()
    blanks: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()

    def role(self, name: str) -> str:
        """`response`, `blank`, `run`, `ignored` or `factor`.

        >>> [Columns().role(name) for name in ("Y1", "Yard", "blank2", "run", "A")]
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
    """A column of levels: `codes` (n,) count from 0 into `levels`; `values` are what numbered levels stand for."""

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
class Response:
    """A measured column (n,)."""

    name: str
    values: Array
    label: str = ""


@dataclass(frozen=True)
class Trial:
    """A field test: n runs."""

    source: str
    factors: tuple[Factor, ...]
    responses: tuple[Response, ...]
    blanks: tuple[Factor, ...] = field(default=())

    @property
    def runs(self) -> int:
        return len(self.responses[0].values)


def read(text: str, source: str, columns: Columns | None = None) -> Trial:
    """The field test in a CSV text; `planter.clutch.field` says how it is written.

    Raises InputError, naming source, line and column, for anything that is not so.
    """
    columns = columns or Columns()
    table = csv_rows.read(text, source)
    _check_named(table, columns)
    by_role: dict[str, list[str]] = {role: [] for role in ("factor", "response", "blank", "run", "ignored")}
    for name in table.header:
        by_role[columns.role(name)].append(name)
    _check_roles(table, by_role)
    legend = Legend.of(table)
    responses = tuple(_response(table, name, legend) for name in by_role["response"])
    factors, blanks = (tuple(_factor(table, name, legend) for name in by_role[role]) for role in ("factor", "blank"))
    legend.check({name: role for role, names in by_role.items() for name in names})
    for name in by_role["run"]:
        _check_runs(table, name, factors)
    return Trial(source, factors, responses, blanks)


def _check_named(table: csv_rows.Table, columns: Columns) -> None:
    options = {"--response": columns.responses, "--blank": columns.blanks, "--ignore": columns.ignored}
    for option, names in options.items():
        for name in names:
            if name not in table.header:
                raise InputError(
                    f"{option} {name}: {table.source} has no such column, it must be one of {', '.join(table.header)}"
                )


def _check_roles(table: csv_rows.Table, by_role: Mapping[str, Sequence[str]]) -> None:
    found = ", ".join(table.header)
    if not by_role["response"]:
        raise InputError(
            f"{table.source}: no column is a response (columns: {found}), it must be called Y, Y1, Y2, ..., "
            f"or be named with --response"
        )
    if not by_role["factor"]:
        raise InputError(f"{table.source}: no column is a factor (columns: {found}), there must be at least one")
    for name, role in RESERVED.items():
        if name in by_role[role]:
            raise InputError(
                f"{table.source}: the column {name} is a {role}, but results use this name for something else, "
                f"so it must have another"
            )


def _response(table: csv_rows.Table, name: str, legend: Legend) -> Response:
    values = np.array(table.numbers(name))
    if np.ptp(values) == 0:
        raise InputError(
            f"{table.source}: column {name} is {values[0]:g} in every run, but a response must vary to be analysed"
        )
    return Response(name, values, legend.label(name))


def _factor(table: csv_rows.Table, name: str, legend: Legend) -> Factor:
    cells = table.column(name)
    numeric = [csv_rows.number(cell) is not None for cell in cells]
    if any(numeric) and not all(numeric):
        row = numeric.index(False)
        raise InputError(
            f"{table.place(row, name)}: {cells[row]!r} is not a number, but other levels of {name} are: "
            f"levels must be all numbers or all words"
        )
    seen: list[Level] = [_plain(value) for value in table.numbers(name)] if all(numeric) else list(cells)
    levels = sorted(set(seen), key=float) if all(numeric) else list(dict.fromkeys(seen))
    if len(levels) == 1:
        raise InputError(
            f"{table.source}: column {name} is {levels[0]} in every run, but a factor must have at least two levels"
        )
    levels, values = legend.ordered(name, levels)
    code = {level: index for index, level in enumerate(levels)}
    codes = np.array([code[level] for level in seen])
    return Factor(name, tuple(levels), codes, legend.label(name), values)


def _plain(value: float) -> int | float:
    return int(value) if value.is_integer() and abs(value) < 1e15 else value


def _check_runs(table: csv_rows.Table, name: str, factors: Sequence[Factor]) -> None:
    """Runs that are counted leave none out, and those of one number have the same levels."""
    counts = table.numbers(name)
    first: dict[float, int] = {}
    for row, count in enumerate(counts):
        if not count.is_integer():
            raise InputError(f"{table.place(row, name)}: {count!r} is not allowed, it must be a whole number")
        before = first.setdefault(count, row)
        if any(factor.codes[before] != factor.codes[row] for factor in factors):
            raise InputError(
                f"{table.place(row, name)}: run {int(count)} stands in line {table.lines[before]} already with other "
                f"levels, but a repetition must have the same"
            )
    low, high = int(min(counts)), int(max(counts))
    missing = next((count for count in range(low, high) if count not in first), None)
    if missing is not None:
        raise InputError(
            f"{table.source}: run {missing} is missing between {low} and {high}, every run must be there (to evaluate "
            f"the rest as the unbalanced design that it is, leave the column {name} out with --ignore {name})"
        )
