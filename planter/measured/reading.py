"""Measured curves from CSV files as they come: any separator, decimal points or commas, units in the header or told."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows, paths
from planter.files.dimensions import measured as parse_unit
from planter.files.text import read_text
from planter.kernels import Array
from planter.numerics.arrays import Flags

ANGLES = {"deg": np.pi / 180, "°": np.pi / 180, "rad": 1.0, "rev": 2 * np.pi}
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
VALUES = {
    "N": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "N m": {"N m": 1.0, "Nm": 1.0, "kN m": 1e3, "kNm": 1e3, "N mm": 1e-3, "Nmm": 1e-3},
}
"""Units of a column by the unit of the quantity that was measured."""
ALIKE = (
    ("mm", "m", "cm", "um"), ("deg", "rad"), ("rad/s", "r/min", "deg/s"), ("rad/s2", "deg/s2"), ("m/s", "mm/s"),
    ("m/s2", "mm/s2"), ("W", "kW", "mW"), ("J", "kJ", "mJ"), ("1", "%"),
)  # fmt: skip
"""Units of other quantities that a column may have."""
_UNIT = re.compile(r"(?:\[(?P<a>[^\]]+)\]|\((?P<b>[^)]+)\)|/ *(?P<c>[^/]+)|_(?P<d>[A-Za-z°]+))\s*$")
FEWEST = 12
"""Points that a fit takes at least."""
REACH, OUTSIDE = 2, 6.0
"""Neighbours on each side that a point is held against, and the robust deviations beyond which it is left out."""
GAP, TINY = 12.0, 1e-6
"""Usual steps that four neighbours may span at most, and share of one that two points are apart at least."""
TO_SIGMA = 1.4826
"""Median of absolute deviations of a normal distribution to its standard deviation."""


@dataclass(frozen=True)
class Columns:
    """Which columns of a file hold what, and units that its header does not say; `angle` or `time` is given."""

    value: str
    angle: str | None = None
    time: str | None = None
    value_unit: str | None = None
    place_unit: str | None = None


@dataclass(frozen=True)
class Measurement:
    """A measured curve: drive angles (n,) [rad] as counted by the data, values (n,), which points count.

    `told` says how the file was read; `noise` is the scatter of neighbours. Values and
    noise are in the display unit of what was measured.
    """

    phi: Array
    values: Array
    used: Flags
    noise: float
    told: tuple[str, ...]


def read(path: str | Path, columns: Columns, speed: float, unit: str = "N") -> Measurement:
    """The curve in a file; `speed` [rad/s] of the drive turns times into angles, `unit` is that of the quantity.

    Raises InputError, naming file, line and column, for a file that is not read, columns and units that there are not,
    too few points, and points that are no numbers.
    """
    table, how = _table(read_text(path), str(path))
    value = _column(table, columns.value, "--column")
    place, kinds = _place(table, columns)
    value_factor, value_unit = _factor(table, value, list_units(unit), columns.value_unit, "--unit")
    place_factor, place_unit = _factor(table, place, kinds, columns.place_unit, "--place-unit")
    values = np.array(table.numbers(value)) * value_factor
    places = np.array(table.numbers(place)) * place_factor
    phi = places * speed if kinds is TIMES else places
    if len(phi) < FEWEST:
        raise InputError(f"{path}: {len(phi)} points are not enough, at least {FEWEST} are needed")
    order = np.argsort(phi, kind="stable")
    phi, values = phi[order], values[order]
    used, noise = _inliers(phi, values)
    told = (
        f"{how}; {value} in {value_unit} over {place} in {place_unit}",
        f"not smoothed; {_outliers(used)} (test: {OUTSIDE:g} robust sigma from a local cubic)",
    )
    return Measurement(phi, values, used, noise, told)


def list_units(unit: str) -> dict[str, float]:
    """Return the units that a column of a quantity may have, each in parts of the quantity's display unit.

    >>> list_units("mm")["m"], list_units("N")["kN"]
    (1000.0, 1000.0)
    """
    if unit in VALUES:
        return VALUES[unit]
    alike = next((names for names in ALIKE if (unit or "1") in names), (unit,))
    return {name: parse_unit(name).factor / parse_unit(unit).factor for name in alike}


def _outliers(used: Flags) -> str:
    count = int((~used).sum())
    return f"{count} of {len(used)} points removed as outliers" if count else "no outliers removed"


def _table(text: str, source: str) -> tuple[csv_rows.Table, str]:
    """A file with any separator as one with commas and decimal points, and how it stood."""
    lines = [
        line for line in text.replace("\r\n", "\n").split("\n") if line.strip() and not line.lstrip().startswith("#")
    ]
    first = lines[0] if lines else ""
    separator = next((mark for mark in (";", "\t") if mark in first), ",")
    names = {";": "semicolons", "\t": "tabs", ",": "commas"}
    commas = separator != "," and any("," in line for line in lines)
    if separator != ",":
        text = "\n".join(
            line if line.lstrip().startswith("#") else line.replace(",", ".").replace(separator, ",")
            for line in text.replace("\r\n", "\n").split("\n")
        )
    if lines and all(csv_rows.finite(cell.strip().replace(",", ".")) for cell in first.split(separator)):
        head = ",".join(str(i + 1) for i in range(len(first.split(separator))))
        cells = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")]
        rows = tuple(tuple(cell.strip() for cell in line.split(",")) for line in cells)
        table = csv_rows.Table(source, (), tuple(head.split(",")), tuple(range(1, len(rows) + 1)), rows)
        return table, f"columns separated by {names[separator]}, no header: columns are numbered from 1"
    decimals = ", decimal commas" if commas else ""
    return csv_rows.read(text, source), f"columns separated by {names[separator]}{decimals}"


def _column(table: csv_rows.Table, name: str, option: str) -> str:
    """The column of a name, which may be told without its unit."""
    if name in table.header:
        return name
    bare = [column for column in table.header if _UNIT.sub("", column).strip() == name]
    if len(bare) == 1:
        return bare[0]
    without_unit = {_UNIT.sub("", column).strip(): column for column in table.header}
    near = paths.close(name, [*table.header, *without_unit])
    hint = f"did you mean {without_unit.get(near[0], near[0])!r}? " if near else ""
    known = ", ".join(map(repr, table.header))
    raise InputError(f"{table.source}: {option} = {name} is not allowed: {hint}it must be one of {known}")


def _place(table: csv_rows.Table, columns: Columns) -> tuple[str, dict[str, float]]:
    if columns.time is not None:
        return _column(table, columns.time, "--time"), TIMES
    if columns.angle is not None:
        return _column(table, columns.angle, "--angle"), ANGLES
    raise InputError(f"{table.source}: --angle or --time must name the column that tells where in the turn a point is")


def _factor(
    table: csv_rows.Table, name: str, units: dict[str, float], told: str | None, option: str
) -> tuple[float, str]:
    """SI value of a column's unit: as told, else as its name says."""
    found = _UNIT.search(name)
    written = next((part.strip() for part in found.groups() if part), None) if found else None
    unit = told if told is not None else written
    if unit is None and "1" in units:
        return units["1"], "parts of one"
    if unit is None or unit not in units:
        given = f"{option} = {told} is not allowed" if told is not None else "has no unit that is known"
        if told is None and written is not None:
            given = f"the unit {written} does not fit"
        raise InputError(f"{table.source}: column {name}: {given}: {option} must be one of {', '.join(units)}")
    return units[unit], unit


def _inliers(phi: Array, values: Array) -> tuple[Flags, float]:
    """Points that lie near a cubic through their neighbours, and the scatter about such cubics [SI].

    An outlier bends its neighbours' cubics too: of points close to each other the worst alone is left out. Points at
    the ends, beside a gap or measured twice are not judged.
    """
    aside, judged = _aside(phi, values)
    noise = TO_SIGMA * float(np.median(np.abs(aside[judged]))) if judged.any() else 0.0
    size = np.where(judged, np.abs(aside), 0.0)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(size, REACH), 2 * REACH + 1).max(axis=1)
    return ~((size > OUTSIDE * noise) & (size == around) & (noise > 0)), noise


def _aside(phi: Array, values: Array) -> tuple[Array, Flags]:
    """Distance of each point from the cubic through two neighbours on each side, scaled to scatter as a point does."""
    count = len(phi)
    inner = np.arange(REACH, count - REACH)
    near = inner + np.array([-2, -1, 1, 2])[:, None]
    x, steps = phi[near] - phi[inner], np.diff(phi)
    span, usual = x[-1] - x[0], float(np.median(steps))
    good = (span < GAP * usual) & (np.diff(phi[near], axis=0) > TINY * usual).all(axis=0) & (x != 0).all(axis=0)
    weights = np.ones_like(x)
    for j, k in ((j, k) for j in range(4) for k in range(4) if j != k):
        weights[j, good] *= -x[k, good] / (x[j, good] - x[k, good])
    aside, judged = np.zeros(count), np.zeros(count, dtype=bool)
    aside[inner] = (values[inner] - (weights * values[near]).sum(axis=0)) / np.sqrt(1 + (weights**2).sum(axis=0))
    judged[inner] = good
    return aside, judged
