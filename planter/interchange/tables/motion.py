"""Quantities over time, and what a dictionary says of them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from planter.files import csv_rows, units
from planter.kernels import Array

DICTIONARY = "dictionary.csv"
_HEAD = ("name", "unit", "si_per_unit", "meaning", "source")
_MILLIMETRES = {"m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "J": ("N mm", 1e3), "W": ("N mm/s", 1e3)}
"""Words of SI units in the system of millimetre, newton, degree, second, and how many of these make one."""


@dataclass(frozen=True)
class Column:
    """A quantity over time: values (n,) in SI; `name` is a plain word, `key` ends in the display unit."""

    name: str
    key: str
    unit: str
    meaning: str
    source: str
    values: Array


@dataclass(frozen=True)
class Motion:
    """Columns of one length, the time [s] first, which grows; `notes` say what they are of."""

    name: str
    notes: tuple[str, ...]
    columns: tuple[Column, ...]

    @property
    def time(self) -> Array:
        return self.columns[0].values


@dataclass(frozen=True)
class PlacedColumn:
    """A column of a format: its place there, its values (n,) in a unit, and the factor of this unit to SI."""

    place: str
    unit: str
    factor: float
    column: Column

    @property
    def values(self) -> Array:
        values: Array = self.column.values / self.factor
        return values


def in_si(column: Column, place: str) -> PlacedColumn:
    """Return a column in SI units and radians."""
    return PlacedColumn(place, column.unit, 1.0, column)


def in_key_unit(column: Column, place: str) -> PlacedColumn:
    """Return a column in the unit that its key ends in."""
    return PlacedColumn(place, units.unit(column.key) or "1", units.factor(column.key), column)


def in_millimetres(column: Column, place: str) -> PlacedColumn:
    """Return a column in millimetres, newtons, degrees, seconds and units of these, as torques in N mm."""
    above, slash, below = column.unit.partition("/")
    (top, up), (bottom, down) = (_in_millimetres(part) for part in (above, below))
    return PlacedColumn(place, f"{top}{slash}{bottom}", down / up, column)


def _in_millimetres(product: str) -> tuple[str, float]:
    """A product of units in that system, and how many of it make one of the other."""
    words, factor = [], 1.0
    for word, power in re.findall(r"([A-Za-z1]+?)(\d*)(?: |$)", product):
        other, many = _MILLIMETRES.get(word, (word, 1.0))
        words.append(f"{other}{power}")
        factor *= many ** int(power or 1)
    return " ".join(words), factor


def dictionary(title: str, notes: Iterable[str], columns: Iterable[PlacedColumn]) -> bytes:
    """Return place, unit, meaning and source of each column as CSV."""
    rows = (
        (entry.place, entry.column.name, entry.unit, repr(entry.factor), entry.column.meaning, entry.column.source)
        for entry in columns
    )
    return csv_rows.written(notes, (title, *_HEAD), rows).encode()
