"""Tables of a cycle, written and read back."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from planter.kernels import Array
from planter.report import files


def read_cycle_csv(path: Path) -> tuple[list[str], dict[str, Array]]:
    """Return the comments and columns (n,) of a file of a cycle."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comments = [line.removeprefix("#").strip() for line in lines if line.startswith("#")]
    header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    values = np.array(rows, dtype=float).reshape(len(rows), len(header))
    return comments, dict(zip(header, values.T, strict=True))


def write_cycle_csv(
    path: Path, comments: Iterable[str], columns: Mapping[str, Array | Sequence[float]]
) -> None:
    """Write comments and columns (n,) as commands write those of a cycle."""
    files.write_text(path, files.cycle_csv(str(path), comments, columns))
