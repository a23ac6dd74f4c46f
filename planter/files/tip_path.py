"""Points that a tip must pass: a table in a machine's file, or a CSV beside it, each with the radius of its tube."""

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
"""Place of a point, in the frame of the machine, and how far from it the path may pass."""
MOST = 200
Point = tuple[Real, Real, Positive]
Points = Annotated[list[Point], Field(min_length=1, max_length=MOST)]


def inlined(table: Mapping[str, Any], section: str, source: str) -> dict[str, Any]:
    """A file's table whose `points_csv` in a section has become `points_mm`: it needs no other file any more.

    Raises InputError, naming file and line, for a CSV that holds no such points, and where there are both.
    """
    found, own = dict(table), table.get(section)
    if not isinstance(own, Mapping) or not isinstance(own.get("points_csv"), str):
        return found
    rest = {key: value for key, value in own.items() if key != "points_csv"}
    if "points_mm" in rest:
        allowed = "points stand in points_mm or in a CSV, not in both"
        raise InputError(not_allowed(source, f"{section}.points_csv", own["points_csv"], allowed))
    return found | {section: rest | {"points_mm": read(Path(source).parent / own["points_csv"])}}


def read(path: Path) -> list[list[float]]:
    """The points of a CSV with the header `x_mm,y_mm,tube_mm`. Raises InputError for anything else."""
    rows = csv_rows.read(read_text(path), str(path), COLUMNS)
    return [list(row) for row in zip(*(rows.numbers(name) for name in COLUMNS), strict=True)]
