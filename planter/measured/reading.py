"""Measured curves from CSV files: any separator, decimal points or commas, units in the header or by option."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.errors import InputError
from planter.files import csv_rows, paths
from planter.files.text import read_text
from planter.files.units import parse_unit as parse_unit
from planter.kernels import Array
from planter.numerics.arrays import Flags

ANGLES = {"deg": np.pi / 180, "°": np.pi / 180, "rad": 1.0, "rev": 2 * np.pi}
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
VALUES = {
    "N": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "N m": {"N m": 1.0, "Nm": 1.0, "kN m": 1e3, "kNm": 1e3, "N mm": 1e-3, "Nmm": 1e-3},
}
"""Units of a column by the unit of the measured quantity."""
ALIKE = (
    ("mm", "m", "cm", "um"), ("deg", "rad"), ("rad/s", "r/min", "deg/s"), ("rad/s2", "deg/s2"), ("m/s", "mm/s"),
    ("m/s2", "mm/s2"), ("W", "kW", "mW"), ("J", "kJ", "mJ"), ("1", "%"),
)  # fmt: skip
"""Units of columns of other quantities."""
_UNIT = re.compile(r"(?:\[(?P<a>[^\]]+)\]|\((?P<b>[^)]+)\)|/ *(?P<c>[^/]+)|_(?P<d>[A-Za-z°]+))\s*$")
FEWEST = 12
"""Minimum number of points of a fit."""
REACH, OUTSIDE = 2, 6.0
"""Number of neighbours on each side of a point, and robust deviations beyond which it is an outlier."""
GAP, TINY = 12.0, 1e-6
"""Maximum span of four neighbours and minimum distance of two points, in median steps."""
TO_SIGMA = 1.4826
"""Ratio of the standard deviation of a normal distribution to its median absolute deviation."""


@dataclass(frozen=True)
class Columns:
    """Columns of a file, and units that its header lacks; one of `angle` and `time` is set."""

    value: str
    angle: str | None = None
    time: str | None = None
    value_unit: str | None = None
    place_unit: str | None = None


@dataclass(frozen=True)
class Measurement:
    """A measured curve: drive angles (n,) [rad] as counted by the data, values (n,), and which points are used.

    `treatment` describes how the file was read; `noise` is the scatter of neighbours. Values and noise are in the
    display unit of the measured quantity.
    """

    phi: Array
    values: Array
    used: Flags
    noise: float
    treatment: tuple[str, ...]


def read(path: str | Path, columns: Columns, speed: float, unit: str = "N") -> Measurement:
    """Read a curve from a file; `speed` [rad/s] of the drive converts times to angles, `unit` is that of the quantity.

    Raises InputError, which names file, line and column, if the file cannot be read, a column or unit does not exist,
    there are too few points, or a cell is not a number.
    """
    table, layout = _table(read_text(path), str(path))
    value = _column(table, columns.value, "--column")
    place, kinds = _place(table, columns)
    value_factor, value_unit = _factor(table, value, list_units(unit), columns.value_unit, "--unit")
    place_factor, place_unit = _factor(table, place, kinds, columns.place_unit, "--place-unit")
    values = np.array(table.numbers(value)) * value_factor
    places = np.array(table.numbers(place)) * place_factor
    phi = places * speed if kinds is TIMES else places
    if len(phi) < FEWEST:
        raise InputError(f"{path}: {len(phi)} points are too few; a fit needs {FEWEST}")
    order = np.argsort(phi, kind="stable")
    phi, values = phi[order], values[order]
    used, noise = _inliers(phi, values)
    treatment = (
        f"{layout}; {value} in {value_unit} over {place} in {place_unit}",
        f"not smoothed; {_outliers(used)} (test: {OUTSIDE:g} robust sigma from a local cubic)",
    )
    return Measurement(phi, values, used, noise, treatment)


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


def _table(text: str, source: str) -> tuple[csv_rows.CsvTable, str]:
    """Return a file with any separator as a table, and a description of its layout."""
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
    if lines and all(csv_rows.is_finite_number(cell.strip().replace(",", ".")) for cell in first.split(separator)):
        head = ",".join(str(i + 1) for i in range(len(first.split(separator))))
        cells = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")]
        rows = tuple(tuple(cell.strip() for cell in line.split(",")) for line in cells)
        table = csv_rows.CsvTable(source, (), tuple(head.split(",")), tuple(range(1, len(rows) + 1)), rows)
        return table, f"columns separated by {names[separator]}, no header: columns are numbered from 1"
    decimals = ", decimal commas" if commas else ""
    return csv_rows.read_table(text, source), f"columns separated by {names[separator]}{decimals}"


def _column(table: csv_rows.CsvTable, name: str, option: str) -> str:
    """Return the column of a name, with or without its unit."""
    if name in table.header:
        return name
    bare = [column for column in table.header if _UNIT.sub("", column).strip() == name]
    if len(bare) == 1:
        return bare[0]
    without_unit = {_UNIT.sub("", column).strip(): column for column in table.header}
    close = paths.find_similar(name, [*table.header, *without_unit])
    hint = f"did you mean {without_unit.get(close[0], close[0])!r}? " if close else ""
    columns = ", ".join(map(repr, table.header))
    raise InputError(f"{table.source}: {option} = {name} is not a column: {hint}it must be one of {columns}")


def _place(table: csv_rows.CsvTable, columns: Columns) -> tuple[str, dict[str, float]]:
    if columns.time is not None:
        return _column(table, columns.time, "--time"), TIMES
    if columns.angle is not None:
        return _column(table, columns.angle, "--angle"), ANGLES
    raise InputError(f"{table.source}: add --angle or --time with the column of the angle or the time of the points")


def _factor(
    table: csv_rows.CsvTable, name: str, units: dict[str, float], unit_option: str | None, option: str
) -> tuple[float, str]:
    """Return the factor and the unit of a column, by its option, else by its header."""
    match = _UNIT.search(name)
    header_unit = next((part.strip() for part in match.groups() if part), None) if match else None
    unit = unit_option if unit_option is not None else header_unit
    if unit is None and "1" in units:
        return units["1"], "parts of one"
    if unit is None or unit not in units:
        if unit_option is not None:
            problem = f"{option} = {unit_option} does not fit"
        else:
            problem = "has no unit" if header_unit is None else f"the unit {header_unit} does not fit"
        raise InputError(f"{table.source}: column {name}: {problem}: {option} must be one of {', '.join(units)}")
    return units[unit], unit


def _inliers(phi: Array, values: Array) -> tuple[Flags, float]:
    """Return the mask (n,) of points near the cubic through their neighbours, and the scatter about such cubics.

    An outlier bends the cubics of its neighbours too, so that only the worst of close points is left out. Points at the
    ends, next to a gap or measured twice are not tested.
    """
    deviations, tested = _deviations(phi, values)
    noise = TO_SIGMA * float(np.median(np.abs(deviations[tested]))) if tested.any() else 0.0
    size = np.where(tested, np.abs(deviations), 0.0)
    largest = np.lib.stride_tricks.sliding_window_view(np.pad(size, REACH), 2 * REACH + 1).max(axis=1)
    return ~((size > OUTSIDE * noise) & (size == largest) & (noise > 0)), noise


def _deviations(phi: Array, values: Array) -> tuple[Array, Flags]:
    """Return the scaled distance of each point from the cubic through two neighbours on each side."""
    count = len(phi)
    inner = np.arange(REACH, count - REACH)
    neighbours = inner + np.array([-2, -1, 1, 2])[:, None]
    x, steps = phi[neighbours] - phi[inner], np.diff(phi)
    span, median_step = x[-1] - x[0], float(np.median(steps))
    good = (
        (span < GAP * median_step)
        & (np.diff(phi[neighbours], axis=0) > TINY * median_step).all(axis=0)
        & (x != 0).all(axis=0)
    )
    weights = np.ones_like(x)
    for j, k in ((j, k) for j in range(4) for k in range(4) if j != k):
        weights[j, good] *= -x[k, good] / (x[j, good] - x[k, good])
    deviations, tested = np.zeros(count), np.zeros(count, dtype=bool)
    deviations[inner] = (values[inner] - (weights * values[neighbours]).sum(axis=0)) / np.sqrt(
        1 + (weights**2).sum(axis=0)
    )
    tested[inner] = good
    return deviations, tested
