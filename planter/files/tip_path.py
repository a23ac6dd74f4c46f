"""Points that a tip must pass, in the machine file or in a CSV file, each with the radius of its tube."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from planter.errors import InputError
from planter.files import csv_rows
from planter.files.complaints import not_allowed
from planter.files.fields import Positive, Real
from planter.files.text import read_text

COLUMNS = ("x_mm", "y_mm", "tube_mm")
"""Position of a point in the frame of the machine, and maximum distance of the path from it."""
MOST = 200
Point = tuple[Real, Real, Positive]
Points = Annotated[list[Point], Field(min_length=1, max_length=MOST)]


def inlined(table: Mapping[str, Any], section: str, source: str) -> dict[str, Any]:
    """Return the table of a file with `points_mm` in a section instead of its `points_csv`.

    Raises InputError, which names file and line, if the CSV is invalid or the section has both keys.
    """
    values, entries = dict(table), table.get(section)
    if not isinstance(entries, Mapping) or not isinstance(entries.get("points_csv"), str):
        return values
    rest = {key: value for key, value in entries.items() if key != "points_csv"}
    if "points_mm" in rest:
        allowed = "points stand in points_mm or in a CSV, not in both"
        raise InputError(not_allowed(source, f"{section}.points_csv", entries["points_csv"], allowed))
    return values | {section: rest | {"points_mm": read(Path(source).parent / entries["points_csv"])}}


def read(path: Path) -> list[list[float]]:
    """Read the points of a CSV with the header `x_mm,y_mm,tube_mm`. Raises InputError for other files."""
    rows = csv_rows.read(read_text(path), str(path), COLUMNS)
    return [list(row) for row in zip(*(rows.numbers(name) for name in COLUMNS), strict=True)]
