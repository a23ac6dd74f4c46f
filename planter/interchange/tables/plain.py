"""Plain CSV: a column for each quantity, under a name that ends in its unit, the time first."""

from __future__ import annotations

from planter.files import csv_rows
from planter.interchange.tables.motion import DICTIONARY, Motion, dictionary, in_key_unit


def files(motion: Motion) -> dict[str, bytes]:
    """`motion.csv` and its dictionary."""
    columns = [in_key_unit(column, column.key) for column in motion.columns]
    rows = zip(*(column.values.tolist() for column in columns), strict=True)
    table = csv_rows.written(motion.notes, [column.place for column in columns], rows)
    return {"motion.csv": table.encode(), DICTIONARY: dictionary("column", motion.notes, columns)}
