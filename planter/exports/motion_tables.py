"""Motions and forces over time as files of other programs, each with a dictionary of its columns.

Adams: a command file with a spline over time of each quantity, for AKISPL and CUBSPL in functions,
by the commands in the reference of Adams View: `data_element create spline` with `spline_name`,
`comments`, `x`, `y`, `linear_extrapolate`. Numbers are in millimetre, newton, degree, second.

SolidWorks Motion: data points of motors and forces, a file for each quantity, by the program's
help: one point a line, time and value, with a comma between them and without a header. The name of
a file ends in the unit.

Simulink: a MAT-file for the block From File, by the block's reference: one matrix of doubles, the
time in its first row, a signal in each other row. From Workspace takes its transpose.
"""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from planter.files import csv_rows, units
from planter.kernels import Array

DICTIONARY = "dictionary.csv"
_HEAD = ("name", "unit", "si_per_unit", "meaning", "source")
_MILLIMETRES = {
    "m": ("mm", 1e3),
    "rad": ("deg", 180 / math.pi),
    "J": ("N mm", 1e3),
    "W": ("N mm/s", 1e3),
}
"""SI units in the system of millimetre, newton, degree, second: their name there, and their size in
it.
"""
_NUMBERS_PER_LINE, _LINE_WIDTH = 4, 110
_MAT_HEADER_BYTES = 116
"""Length of the text at the beginning of a MAT-file of version 5, in which SciPy puts the date."""


@dataclass(frozen=True)
class Column:
    """A quantity over time: values (n,) in SI; `name` is a plain word, `key` ends in the display
    unit.
    """

    name: str
    key: str
    unit: str
    meaning: str
    source: str
    values: Array


@dataclass(frozen=True)
class MotionTable:
    """Columns of one length, the time [s] first, which rises; `notes` are comments on all of
    them.
    """

    name: str
    notes: tuple[str, ...]
    columns: tuple[Column, ...]

    @property
    def time(self) -> Array:
        return self.columns[0].values


@dataclass(frozen=True)
class PlacedColumn:
    """A column of a format: its name there, its unit, and the factor of this unit to SI."""

    place: str
    unit: str
    factor: float
    column: Column

    @property
    def values(self) -> Array:
        """Values (n,) in the unit."""
        return self.column.values / self.factor


def convert_to_key_unit(column: Column, place: str) -> PlacedColumn:
    """Return a column in the unit that its key ends in."""
    return PlacedColumn(
        place, units.display_unit(column.key) or "1", units.unit_factor(column.key), column
    )


def convert_to_millimetres(column: Column, place: str) -> PlacedColumn:
    """Return a column in millimetres, newtons, degrees, seconds and units of these, as torques in N
    mm.
    """
    above, slash, below = column.unit.partition("/")
    (top, up), (bottom, down) = (_convert_product(part) for part in (above, below))
    return PlacedColumn(place, f"{top}{slash}{bottom}", down / up, column)


def _convert_product(product: str) -> tuple[str, float]:
    """Return a product of units in that system, and the size of the product in it."""
    words, factor = [], 1.0
    for word, power in re.findall(r"([A-Za-z1]+?)(\d*)(?: |$)", product):
        name, size = _MILLIMETRES.get(word, (word, 1.0))
        words.append(f"{name}{power}")
        factor *= size ** int(power or 1)
    return " ".join(words), factor


def _format_dictionary(
    title: str, motion: MotionTable, columns: Iterable[PlacedColumn]
) -> dict[str, bytes]:
    """Return the dictionary with name, unit, meaning and source of each column as CSV."""
    rows = (
        (
            entry.place,
            entry.column.name,
            entry.unit,
            repr(entry.factor),
            entry.column.meaning,
            entry.column.source,
        )
        for entry in columns
    )
    return {DICTIONARY: csv_rows.format_csv(motion.notes, (title, *_HEAD), rows).encode()}


def format_adams(motion: MotionTable) -> dict[str, bytes]:
    """Return `motion.cmd` and the dictionary of its splines."""
    columns = [
        convert_to_millimetres(column, f"{motion.name}_{column.name}")
        for column in motion.columns[1:]
    ]
    notes = (*motion.notes, "Units: mm, N, N mm, deg, s.")
    lines = [f"! {line}" for note in notes for line in textwrap.wrap(note, _LINE_WIDTH)]
    time = motion.time.tolist()
    for column in columns:
        meaning = column.column.meaning.replace('"', "'")
        lines += [
            "!",
            "data_element create spline &",
            f"   spline_name = {column.place} &",
            f'   comments = "{meaning} [{column.unit}] over time [s]" &',
            *_format_numbers("x", time),
            *_format_numbers("y", column.values.tolist()),
            "   linear_extrapolate = no",
        ]
    text = "\n".join(lines) + "\n"
    return {"motion.cmd": text.encode("ascii", "replace")} | _format_dictionary(
        "spline", motion, columns
    )


def _format_numbers(name: str, values: Sequence[float]) -> Iterator[str]:
    """Yield the continued lines of numbers with all their digits."""
    for first in range(0, len(values), _NUMBERS_PER_LINE):
        part = ", ".join(f"{value:.16E}" for value in values[first : first + _NUMBERS_PER_LINE])
        head = f"   {name} = " if first == 0 else "      "
        yield f"{head}{part}{',' if first + _NUMBERS_PER_LINE < len(values) else ''} &"


def format_solidworks(motion: MotionTable) -> dict[str, bytes]:
    """Return a file for each quantity, and the dictionary of all."""
    columns = [convert_to_key_unit(column, f"{column.key}.csv") for column in motion.columns[1:]]
    time = motion.time.tolist()
    points = {
        column.place: "".join(
            f"{t!r},{v!r}\n" for t, v in zip(time, column.values.tolist(), strict=True)
        ).encode()
        for column in columns
    }
    return points | _format_dictionary("file", motion, columns)


def format_simulink(motion: MotionTable) -> dict[str, bytes]:
    """Return `motion.mat` with the matrix `motion` in SI units and radians, and the dictionary of
    its rows.
    """
    columns = [
        PlacedColumn(str(row), column.unit, 1.0, column)
        for row, column in enumerate(motion.columns, 1)
    ]
    stream = io.BytesIO()
    scipy.io.savemat(
        stream, {"motion": np.array([column.values for column in columns])}, format="5"
    )
    text = f"MATLAB 5.0 MAT-file, {motion.name}, rows: see {DICTIONARY}".encode("ascii", "replace")[
        :_MAT_HEADER_BYTES
    ]
    content = text.ljust(_MAT_HEADER_BYTES) + stream.getvalue()[_MAT_HEADER_BYTES:]
    return {"motion.mat": content} | _format_dictionary("row", motion, columns)


def format_csv(motion: MotionTable) -> dict[str, bytes]:
    """Return `motion.csv`, with a column for each quantity under a name that ends in its unit, and
    its dictionary.
    """
    columns = [convert_to_key_unit(column, column.key) for column in motion.columns]
    rows = zip(*(column.values.tolist() for column in columns), strict=True)
    table = csv_rows.format_csv(motion.notes, [column.place for column in columns], rows)
    return {"motion.csv": table.encode()} | _format_dictionary("column", motion, columns)


FORMATS: dict[str, Callable[[MotionTable], dict[str, bytes]]] = {
    "adams": format_adams,
    "solidworks": format_solidworks,
    "simulink": format_simulink,
    "csv": format_csv,
}
"""Functions that return names and contents of the files of a motion."""
