"""The rows of a sweep as tidy files: a column a variable, a row a point; CSV and Parquet, a chunk at a time."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from planter import legible
from planter.kernels import Array
from planter.progress import Listener, Phase
from planter.report import folder
from planter.sweeps.rows import Rows

LACKING = "rows.parquet is not written, rows.csv holds the same rows; for Parquet: pip install 'planter[parquet]'"


def has_parquet() -> bool:
    """Whether Parquet files can be written here."""
    return find_spec("pyarrow") is not None


def write(out: Path, rows: Rows, comments: Iterable[str], progress: Listener | None = None) -> None:
    """Write rows.csv, and rows.parquet where the extra `parquet` is installed, each whole or not at all.

    Raises InputError if a file cannot be written.
    """
    _write_csv(out / "rows.csv", rows, comments, progress)
    if has_parquet():
        _write_parquet(out / "rows.parquet", rows)


def _write_csv(path: Path, rows: Rows, comments: Iterable[str], progress: Listener | None) -> None:
    phase = Phase("writing", "row", rows.points.rows, progress)
    with folder.replacing(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {legible.line(comment)}\n" for comment in comments)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows.columns)
        for table in rows.tables():
            columns = [column if isinstance(column, list) else _cells(column) for column in table.values()]
            writer.writerows(zip(*columns, strict=True))
            phase.reached(phase.done + len(columns[0]))


def _cells(column: Array) -> list[float | None]:
    """Numbers (m,) as cells; one that is missing is empty."""
    cells: list[float | None] = column.tolist()
    for index in np.flatnonzero(np.isnan(column)):
        cells[index] = None
    return cells


def _write_parquet(path: Path, rows: Rows) -> None:
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

    texts = {name for name, axis in rows.inputs.items() if axis.texts is not None}
    schema = pa.schema([(name, pa.string() if name in texts else pa.float64()) for name in rows.columns])
    with folder.replacing(path) as part, ParquetWriter(part, schema, compression="zstd") as writer:
        for table in rows.tables():
            columns = [pa.array(column, from_pandas=True) for column in table.values()]
            writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=schema))
