"""Rows of a sweep: inputs and outputs by name, chunk by chunk, their ranges, and files rows.csv and rows.parquet."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from planter import safe_text
from planter.kernels import Array
from planter.progress import Listener, ProgressPhase
from planter.report import folder
from planter.sweeps.axes import Axis
from planter.sweeps.points import Points
from planter.sweeps.results import Extent
from planter.sweeps.store import Store

PARQUET_HINT = "rows.parquet is not written, rows.csv has the same rows; for Parquet: pip install 'planter[parquet]'"


class Rows:
    """Inputs by path, outputs by name, in display units [which the names end in]; a text is its index in its list."""

    def __init__(self, inputs: Mapping[str, Axis], points: Points, outputs: list[str], store: Store) -> None:
        self.inputs, self.points, self.outputs, self._store = inputs, points, outputs, store

    @property
    def columns(self) -> list[str]:
        """Names of all columns, inputs first."""
        return [*self.inputs, *self.outputs]

    def blocks(self) -> Iterator[tuple[Array, Array]]:
        """Yield the points (m, n) and outputs (m, k) of each chunk; rows without a result are NaN."""
        start = 0
        for outputs in self._store.blocks():
            yield self.points.block(start, start + len(outputs)), outputs
            start += len(outputs)

    def load_all(self) -> tuple[Array, Array]:
        """Return the points and the outputs of all rows."""
        points, outputs = zip(*self.blocks(), strict=True)
        return np.vstack(points), np.vstack(outputs)

    def tables(self) -> Iterator[dict[str, Array | list[str]]]:
        """Yield the columns of each chunk by name; a text is itself, a row without a result NaN."""
        for points, outputs in self.blocks():
            inputs = (_input_column(axis, column) for axis, column in zip(self.inputs.values(), points.T, strict=True))
            yield dict(zip(self.columns, [*inputs, *outputs.T], strict=True))

    def describe_point(self, point: Array) -> dict[str, float | str]:
        """Return the inputs of a point (n,) by name."""
        inputs: dict[str, float | str] = {}
        for (name, axis), value in zip(self.inputs.items(), point, strict=True):
            texts = axis.texts
            inputs[name] = float(value) if texts is None else texts[int(value)]
        return inputs

    def envelope(self) -> dict[str, Extent]:
        """Return the range of each output over all rows."""
        tallies = [_Tally() for _ in self.outputs]
        for points, outputs in self.blocks():
            for tally, column in zip(tallies, outputs.T, strict=True):
                tally.add(points, column)
        return {name: tally.extent(self) for name, tally in zip(self.outputs, tallies, strict=True)}


def _input_column(axis: Axis, column: Array) -> Array | list[str]:
    texts = axis.texts
    return column if texts is None else [texts[int(index)] for index in column]


class _Tally:
    """Extremes and mean of a column, accumulated over blocks."""

    def __init__(self) -> None:
        self.low, self.high, self.total, self.count, self.missing = np.inf, -np.inf, 0.0, 0, 0
        self.low_at: Array | None = None
        self.high_at: Array | None = None

    def add(self, points: Array, column: Array) -> None:
        valid = np.flatnonzero(~np.isnan(column))
        self.missing += len(column) - len(valid)
        self.count += len(valid)
        if not len(valid):
            return
        self.total += float(column[valid].sum())
        low, high = valid[column[valid].argmin()], valid[column[valid].argmax()]
        if column[low] < self.low:
            self.low, self.low_at = float(column[low]), points[low]
        if column[high] > self.high:
            self.high, self.high_at = float(column[high]), points[high]

    def extent(self, rows: Rows) -> Extent:
        if self.low_at is None or self.high_at is None:
            return Extent(None, None, None, self.missing, None, None)
        mean = self.total / self.count
        return Extent(
            self.low, self.high, mean, self.missing, rows.describe_point(self.low_at), rows.describe_point(self.high_at)
        )


def has_parquet() -> bool:
    """Return whether the extra `parquet` is installed."""
    return find_spec("pyarrow") is not None


def write_rows(out: Path, rows: Rows, comments: Iterable[str], progress: Listener | None = None) -> None:
    """Write rows.csv, and rows.parquet if the extra `parquet` is installed; a failure leaves no partial file.

    Raises InputError if a file cannot be written.
    """
    _write_csv(out / "rows.csv", rows, comments, progress)
    if has_parquet():
        _write_parquet(out / "rows.parquet", rows)


def _write_csv(path: Path, rows: Rows, comments: Iterable[str], progress: Listener | None) -> None:
    phase = ProgressPhase("writing", "row", rows.points.rows, progress)
    with folder.replacing(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {safe_text.sanitise_line(comment)}\n" for comment in comments)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows.columns)
        for table in rows.tables():
            columns = [column if isinstance(column, list) else _cells(column) for column in table.values()]
            writer.writerows(zip(*columns, strict=True))
            phase.report(phase.done + len(columns[0]))


def _cells(column: Array) -> list[float | None]:
    """Return numbers (m,) as cells, None for NaN."""
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
