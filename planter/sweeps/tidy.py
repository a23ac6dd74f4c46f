"""The rows of a sweep as tidy files: a column a variable, a row a point; Parquet and CSV, a chunk at a time."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from planter import legible
from planter.progress import Listener, Phase
from planter.report import folder
from planter.sweeps.rows import Rows


def write(out: Path, rows: Rows, comments: Iterable[str], progress: Listener | None = None) -> None:
    """Writes rows.parquet and rows.csv, whole or not at all. Raises InputError where they cannot be written."""
    import pyarrow as pa
    from pyarrow import csv, parquet

    head = "".join(f"# {legible.line(comment)}\n" for comment in comments).encode()
    style = csv.WriteOptions(quoting_style="needed")
    phase = Phase("writing", "row", rows.points.rows, progress)
    with folder.replacing(out / "rows.parquet") as tabled, folder.replacing(out / "rows.csv") as listed:
        first = next(iter(rows.batches()))
        with (
            parquet.ParquetWriter(tabled, first.schema, compression="zstd") as table,
            pa.OSFile(str(listed), "wb") as file,
        ):
            file.write(head)
            with csv.CSVWriter(file, first.schema, write_options=style) as lines:
                for batch in rows.batches():
                    table.write_batch(batch)
                    lines.write_batch(batch)
                    phase.reached(phase.done + batch.num_rows)
