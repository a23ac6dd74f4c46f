"""Tables from CSV files as functions: a cam law, a load over an angle, a ratio that was
measured.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import sympy as sp
from sympy import Expr

from .functions import TabulatedFunction, wrap
from .quantity import (
    Dimension,
    DimensionError,
    Quantity,
    TableError,
    dimension,
    find_factor,
    of_unit,
    quantities,
)

FEWEST, MOST = 4, 400
"""The numbers of rows that a table may have."""


def read_table(path: str | Path, columns: str, periodic: bool = False) -> Callable[[Expr], Expr]:
    r"""Return a table of a CSV file as a function with two continuous derivatives, for use in any
    statement.

    ``columns`` has two lines ``name | unit | meaning``, as `quantities` reads them: of the
    argument, which rises from row to row, and of the value. The header of the file names them with
    their units, such as ``phi_deg`` and ``lift_mm``; lines that begin with # are comments; where
    semicolons separate columns, decimals may be written with a comma. The
    function takes an expression in the SI unit of the argument and is in that of the value. It is
    the cubic spline through all points, not-a-knot at both ends (C. de Boor, A practical guide to
    splines, 2001, chapter 4); beyond them it has no value. If ``periodic``, it repeats after the
    last argument, where the value must be the first again. The points become part of the generated
    functions: derive again after a change of the file.

    Raises TableError, which names file, line and column, if a cell is not a finite number,
    arguments do not rise, a column is missing, there are fewer than 4 rows or more than 400, or a
    periodic table does not end as it begins; the function raises DimensionError for an argument in
    another unit.

    >>> from derive import quantities, read_table
    >>> from pathlib import Path
    >>> from tempfile import mkdtemp
    >>> file = Path(mkdtemp()) / "load.csv"
    >>> _ = file.write_text("phi_deg,load_N\n0,0\n90,40\n180,20\n270,10\n360,0\n")
    >>> load = read_table(file, "phi | deg | crank angle\nload | N | push of the crop", periodic=True)
    >>> q = quantities("phi | rad | crank angle")
    >>> load(q.phi).subs(q.phi, 0.5 * 3.141592653589793).n(3)
    40.0
    """
    argument, value = parse_columns(columns)
    x, y = read_columns(Path(path), argument, value)
    if periodic and y[-1] != y[0]:
        raise TableError(
            f"{path}: column {_key(value)}: the last value {y[-1]:g} is not the first, {y[0]:g}: "
            f"close the period by a "
            "last row with the first value, or leave out periodic=True"
        )
    table = build_table(value.name, (of_unit(value.unit), of_unit(argument.unit)), x, y, periodic)

    def tabulate(at: Expr) -> Expr:
        at = sp.sympify(at)
        if dimension(at) not in (None, of_unit(argument.unit)):
            raise DimensionError(
                f"{value.name}({at}): its argument is not in {argument.unit}, as {path} has it"
            )
        return table(at)

    return tabulate


def build_table(
    name: str,
    units: tuple[Dimension, Dimension],
    x: Sequence[float],
    y: Sequence[float],
    periodic: bool,
) -> Callable[[Expr], Expr]:
    """Return the cubic spline through points as a function; the units are of value and argument."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(x, y, bc_type="periodic" if periodic else "not-a-knot")
    pieces = [(start, row) for start, row in zip(x, spline.c.T.tolist(), strict=False)]
    function = _build_functions(name, units, pieces, None if periodic else (x[0], x[-1]))
    return lambda at: function(x[0] + wrap(at - x[0], sp.Float(x[-1] - x[0])) if periodic else at)


def _build_functions(
    name: str,
    units: tuple[Dimension, Dimension],
    pieces: Sequence[tuple[float, Sequence[float]]],
    limits: tuple[float, float] | None,
) -> type[TabulatedFunction]:
    """Return the class of a piecewise polynomial, and of its derivatives; the units are of value
    and argument.
    """
    value, argument = units
    degree = len(pieces[0][1]) - 1
    slopes = [
        (x, [k * a for k, a in zip(range(degree, 0, -1), row, strict=False)]) for x, row in pieces
    ]
    per_argument = value[0] - argument[0], value[1] - argument[1], value[2] - argument[2]
    members = {
        "exponents": value,
        "pieces": tuple((start, tuple(row)) for start, row in pieces),
        "limits": limits,
        "slope": _build_functions(f"{name}_prime", (per_argument, argument), slopes, limits)
        if degree
        else None,
    }
    return type(name, (TabulatedFunction,), members)


def parse_columns(columns: str) -> tuple[Quantity, Quantity]:
    """Return the argument and the value of a table. Raises TableError for more or fewer columns."""
    parsed = list(quantities(columns).values())
    if len(parsed) != 2:
        raise TableError(
            f"a table has two columns, the argument and the value, and these are {len(parsed)}"
        )
    return parsed[0], parsed[1]


def _key(column: Quantity) -> str:
    """Return the name of a column, with the ending of its unit."""
    return column.shown.rpartition(".")[2]


def read_columns(path: Path, *columns: Quantity) -> list[list[float]]:
    """Return the numbers of columns of a file, in SI; the first of them rises.

    Raises TableError as `read_table`.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise TableError(
            f"{path}: this cannot be read as a text ({getattr(error, 'strerror', 'not UTF-8')})"
        ) from None
    contents = [
        (number, line)
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    is_split = bool(contents) and ";" in contents[0][1]
    rows = [
        (number, next(csv.reader([line], delimiter=";" if is_split else ",")))
        for number, line in contents
    ]
    if is_split and not any("." in line for _, line in contents[1:]):
        rows[1:] = [(number, [cell.replace(",", ".") for cell in row]) for number, row in rows[1:]]
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    for key in map(_key, columns):
        if key not in header:
            raise TableError(
                f"{path}: the header {','.join(header)} has no column {key}: name it there"
            )
    if not FEWEST <= len(rows) - 1 <= MOST:
        raise TableError(
            f"{path}: a table has {FEWEST} to {MOST} rows, and this has {len(rows) - 1}"
        )
    numbers = [
        [_parse_number(path, line, cells, header, _key(c)) for line, cells in rows[1:]]
        for c in columns
    ]
    for (line, _), before, after in zip(rows[2:], numbers[0], numbers[0][1:], strict=False):
        if after <= before:
            raise TableError(
                f"{path}: line {line}, column {_key(columns[0])}: {after:g} does not exceed "
                f"{before:g} in the row "
                "above: sort the rows, and leave out repeated ones"
            )
    factors = [float(find_factor(c.shown)) for c in columns]
    return [
        [number * factor for number in part] for factor, part in zip(factors, numbers, strict=True)
    ]


def _parse_number(
    path: Path, line: int, cells: Sequence[str], header: Sequence[str], key: str
) -> float:
    place, index = f"{path}: line {line}, column {key}", header.index(key)
    cell = cells[index].strip() if index < len(cells) else ""
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if len(cells) > len(header):
        raise TableError(
            f"{place}: the line has {len(cells)} cells, the header {len(header)}: write decimals "
            f"as 1.5"
        )
    if not math.isfinite(number):
        raise TableError(
            f"{place}: '{cell}' is not a finite number: write one, or leave the line out"
        )
    return number
