"""Plain CSV: a column for each quantity, under a name that ends in its unit, the time first."""

from __future__ import annotations

from planter.files import csv_rows
from planter.interchange.tables.motion import DICTIONARY, Motion, as_shown, dictionary


def files(motion: Motion) -> dict[str, bytes]:
    """`motion.csv` and its dictionary."""
    told = [as_shown(column, column.key) for column in motion.columns]
    rows = zip(*(one.values.tolist() for one in told), strict=True)
    table = csv_rows.written(motion.notes, [one.place for one in told], rows)
    return {"motion.csv": table.encode(), DICTIONARY: dictionary("column", motion.notes, told)}
