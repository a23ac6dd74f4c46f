"""Logger files with columns that hold nothing, little or everything at odds end in a curve or in
one sentence.
"""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from planter.errors import InputError
from planter.measured.logger_table import read_logger_table
from planter.measured.reading import Columns, read
from tests.attack.files import NUMBERS, PIECES
from tests.attack.test_attack import SEED, assert_ends_properly, share
from tests.support.labview import Layout, write_lvm

ROWS = 60
WORDS = ("nan", "", "inf", "OVERFLOW", "-", "1e99", "-0.0", "0", "true")
_column = st.one_of(
    st.sampled_from(["counted", "constant", "falling", "pulses", "random", "steps"]),
    st.sampled_from(WORDS),
)
_hole = st.sampled_from(
    ["none", "first half", "second half", "odd", "all but one", "all but the last"]
)


def write_column(kind: str, hole: str, word: str, scale: float) -> list[str]:
    """Return the cells of a column: a record with a hole that `word` fills, or nothing but a
    word.
    """
    i = np.arange(ROWS, dtype=float)
    records = {
        "counted": i,
        "constant": np.ones(ROWS),
        "falling": -i,
        "pulses": (i % 7 < 2) * 5.0,
        "random": np.sin(i * i),
        "steps": i // 20,
    }
    holes = {
        "none": i < 0,
        "first half": i < ROWS / 2,
        "second half": i >= ROWS / 2,
        "odd": i % 2 == 1,
        "all but one": i != 3,
        "all but the last": i < ROWS - 1,
    }
    if kind not in records:
        return [kind] * ROWS
    cells = zip(records[kind] * scale, holes[hole], strict=True)
    return [word if missing else repr(float(value)) for value, missing in cells]


T = TypeVar("T")


def attempt(call: Callable[[], T]) -> T | str:
    """Return the result of a call, or the message with which it refuses its input."""
    try:
        return call()
    except InputError as error:
        return error.message


@seed(SEED)
@share
@given(
    columns=st.tuples(*[st.tuples(_column, _hole, st.sampled_from(WORDS))] * 4),
    scales=st.tuples(*[st.sampled_from([1.0, 10.0, 1e-6, 1e12])] * 4),
    positions=st.sampled_from(
        [
            "angle",
            "time",
            "trigger",
            "angle time",
            "trigger time",
            "interval_s",
            "trigger interval_s",
            "angle interval_s",
        ]
    ),
)
def test_columns_without_numbers_end_in_sentences(
    columns: tuple[tuple[str, str, str], ...], scales: tuple[float, ...], positions: str
) -> None:
    cells = [write_column(*column, scale) for column, scale in zip(columns, scales, strict=True)]
    lines = ["angle [deg];time [s];trigger [V];force [N]", *map(";".join, zip(*cells, strict=True))]
    given_columns = {name: 0.01 if name == "interval_s" else name for name in positions.split()}
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        path = Path(folder) / "own.csv"
        path.write_text("\n".join(lines) + "\n")
        measured = attempt(lambda: read(path, Columns("force", **given_columns), 30.0))  # type: ignore[arg-type]
    if isinstance(measured, str):
        assert measured.isprintable()
        return
    assert np.isfinite(measured.phi).all()
    channel = measured.channels[0]
    assert np.isfinite(channel.values[channel.used]).all()
    assert math.isfinite(channel.noise)


@pytest.mark.parametrize("option", ["--angle", "--time", "--trigger", "--column"])
def test_column_of_nothing_but_nan_is_named(option: str, tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text(
        "a [deg];t [s];F [N];nothing\n"
        + "".join(f"{9 * i};{i / 100};{i * i};nan\n" for i in range(ROWS))
    )
    place = {"--column": "F"} if option != "--column" else {"--angle": "a"}
    words = [word for pair in {**place, option: "nothing"}.items() for word in pair]
    assert_ends_properly(
        "calibrate", "wang2017", "--preview", "--data", str(tmp_path / "own.csv"), *words
    )
    with pytest.raises(InputError, match="nothing holds no number"):
        read(
            tmp_path / "own.csv",
            Columns(
                **{  # type: ignore[arg-type]
                    "value": "F",
                    "angle": None if option in ("--time", "--trigger") else "a",
                    "value_unit": "N",
                    "place_unit": None
                    if option == "--trigger"
                    else "s"
                    if option == "--time"
                    else "deg",
                    {"--column": "value"}.get(option, option[2:]): "nothing",
                }
            ),
            30.0,
        )


_blow = st.tuples(
    st.floats(0, 1),
    st.integers(0, 8),
    st.sampled_from(["cell", "drop", "twice", "insert", "cut"]),
    st.sampled_from(
        [*NUMBERS, *PIECES, "X_Value", "***End_of_Header***", "Channels\t1", "Samples\t0"]
    ),
)


@seed(SEED)
@share
@given(
    blows=st.lists(_blow, min_size=1, max_size=5),
    x_columns=st.sampled_from(["No", "One", "Multi"]),
    restarts=st.booleans(),
)
def test_spoiled_labview_files_end_in_tables_or_sentences(
    blows: list[tuple[float, int, str, str]], x_columns: str, restarts: bool
) -> None:
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        path = Path(folder) / "own.lvm"
        write_lvm(path, Layout(x_columns=x_columns, restarts=restarts, segments=2, rows=4))
        lines = path.read_text().split("\n")
        for place, cell, kind, piece in blows:
            k = int(place * (len(lines) - 1))
            cells = lines[k].split("\t")
            cells[cell % len(cells)] = piece
            lines[k : k + 1] = {
                "cell": ["\t".join(cells)],
                "drop": [],
                "twice": [lines[k]] * 2,
                "insert": [piece, lines[k]],
                "cut": [lines[k]],
            }[kind]
            lines = (lines[: k + 1] if kind == "cut" else lines) or [""]
        path.write_text("\n".join(lines), errors="replace")
        table = attempt(lambda: read_logger_table(path))
    if isinstance(table, str):
        assert table.isprintable()
        return
    assert len({len(row) for row in table.rows} | {len(table.names), len(table.units)}) == 1
    assert len(table.lines) == len(table.rows)
