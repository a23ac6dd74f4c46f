"""LabVIEW measurement files in all layouts give their columns and times, and damage is one
sentence.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planter.errors import InputError
from planter.kernels import Array
from planter.measured.logger_table import LoggerTable, read_logger_table
from planter.measured.reading import Columns, read
from tests.support.cli import answer, refusal
from tests.support.labview import END, Layout, write_lvm


def list_times(table: LoggerTable, channel: int) -> Array:
    """Return the times of a channel: those before it, or those of all channels."""
    column = table.names.index(f"Channel {channel}") - 1
    return table.read_numbers(
        column if table.names[column] == "X_Value" else table.names.index("X_Value")
    )[0]


def assert_reads(path: Path, layout: Layout) -> LoggerTable:
    times, values = write_lvm(path, layout)
    table = read_logger_table(path)
    assert len(table.rows) == layout.segments * layout.rows
    for channel in range(layout.channels):
        column = table.find_column(f"Channel {channel}", "--column")
        assert table.read_numbers(column)[0] == pytest.approx(values[channel], abs=1e-9)
        assert table.units[column] == ["N", "Volts", "mm"][channel]
        assert list_times(table, channel) == pytest.approx(times[channel], abs=2e-6)
    return table


LAYOUTS = {
    "one column of times": Layout(),
    "times before each channel": Layout(x_columns="Multi"),
    "times of two rates": Layout(x_columns="Multi", steps=(0.002, 0.003)),
    "no times, decimal comma": Layout(x_columns="No", decimal=","),
    "no times, two rates": Layout(x_columns="No", steps=(0.002, 0.003)),
    "decimal comma that is not stated": Layout(decimal=",", states_decimal=False),
    "semicolons and decimal comma": Layout(separator="Semicolon", decimal=","),
    "commas": Layout(separator="Comma", x_columns="Multi"),
    "segments": Layout(segments=3),
    "segments that begin anew, past midnight": Layout(segments=30, restarts=True),
    "segments without times that begin anew": Layout(x_columns="No", segments=3, restarts=True),
    "one row a segment": Layout(segments=14, rows=1, restarts=True, x_columns="Multi"),
    "comments": Layout(comments=True),
    "comments, a single channel, no times": Layout(comments=True, channels=1, x_columns="No"),
    "special block and three channels": Layout(special=True, channels=3, x_columns="Multi"),
    "no padding": Layout(padded=False, channels=3, x_columns="No", decimal=","),
}


@pytest.mark.parametrize("case", LAYOUTS)
def test_layout_gives_columns_and_times(case: str, tmp_path: Path) -> None:
    assert_reads(tmp_path / "own.lvm", LAYOUTS[case])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    layout=st.builds(
        Layout,
        x_columns=st.sampled_from(["No", "One", "Multi"]),
        separator=st.sampled_from(["Tab", "Semicolon"]),
        decimal=st.sampled_from([".", ","]),
        states_decimal=st.booleans(),
        segments=st.integers(1, 40),
        channels=st.integers(1, 3),
        rows=st.integers(1, 9),
        comments=st.booleans(),
        special=st.booleans(),
        restarts=st.booleans(),
        padded=st.booleans(),
        steps=st.sampled_from([(0.002, 0.002), (0.001, 0.001)]),
    )
)
def test_any_layout_gives_columns_and_times(
    layout: Layout, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert_reads(tmp_path_factory.mktemp("lvm") / "own.lvm", layout)


def test_rows_under_a_single_header_count_on(tmp_path: Path) -> None:
    layout = Layout(x_columns="No", multi_headings=False, segments=1, rows=40)
    path = tmp_path / "own.lvm"
    times, _ = write_lvm(path, layout)
    lines = path.read_text().split("\n")
    lines.insert(len(lines) - 20, "")
    path.write_text("\n".join(lines))
    assert list_times(read_logger_table(path), 1) == pytest.approx(times[1], abs=1e-9)


def spoil(path: Path, old: str, new: str) -> None:
    text = path.read_bytes().decode("cp1252")
    assert old in text
    path.write_bytes(text.replace(old, new).encode("cp1252"))


REFUSED = {
    "unknown layout": ("X_Columns\tOne", "X_Columns\tTwo", "X_Columns"),
    "layout of another file": ("X_Columns\tOne", "X_Columns\tMulti", "X_Columns Multi"),
    "other channels": ("Channels\t2", "Channels\t3", "Channels is '3'"),
    "separator of another file": ("Separator\tTab", "Separator\tComma", "Separator"),
    "no decimal mark": ("Decimal_Separator\t.", "Decimal_Separator\t", "Decimal_Separator"),
    "header that does not end": (END, "***End***", END),
    "no names": ("X_Value", "", "X_Value"),
    "text among numbers": ("0.002\t", "0.0o2\t", "0.0o2"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_damage_is_refused_by_key_or_line(case: str, tmp_path: Path) -> None:
    old, new, hint = REFUSED[case]
    path = tmp_path / "own.lvm"
    write_lvm(path, Layout())
    spoil(path, old, new)
    with pytest.raises(InputError) as error:
        read(path, Columns("Channel 0", time="X_Value"), 30.0)
    assert hint in error.value.message
    assert error.value.message.isprintable()


@pytest.mark.parametrize(
    ("change", "hint"),
    [
        (("Channel 1", "Channel 7"), "first segment"),
        (("Date\t2026/02/28", "Day\t2026/02/28"), "begin anew"),
        (("23:59:59.063", "23:59:59.001"), "begins before"),
    ],
)
def test_segments_that_do_not_fit_are_refused(
    change: tuple[str, str], hint: str, tmp_path: Path
) -> None:
    path = tmp_path / "own.lvm"
    write_lvm(path, Layout(segments=2, restarts=True))
    first, mark, second = path.read_bytes().decode("cp1252").rpartition("Channels")
    assert change[0] in second
    path.write_bytes(f"{first}{mark}{second.replace(*change)}".encode("cp1252"))
    with pytest.raises(InputError, match=hint):
        read_logger_table(path)


def test_time_column_of_two_rates_must_be_numbered(tmp_path: Path) -> None:
    path = tmp_path / "own.lvm"
    write_lvm(path, Layout(x_columns="Multi"))
    assert read_logger_table(path).find_column("X_Value", "--time") == 0
    times, _ = write_lvm(path, Layout(x_columns="Multi", steps=(0.002, 0.003)))
    with pytest.raises(InputError, match="use 1 or 3"):
        read(path, Columns("Channel 1", time="X_Value", value_unit="N"), 30.0)
    spoil(path, "Volts", "N")
    measured = read(path, Columns("Channel 1", time="3"), 30.0)
    assert measured.phi == pytest.approx(30.0 * times[1], abs=1e-6)


def test_preview_lists_columns_and_takes_an_interval(tmp_path: Path) -> None:
    path = tmp_path / "own.lvm"
    write_lvm(path, Layout(x_columns="Multi"))
    call = ("calibrate", "wang2017", "--data", str(path), "--preview")
    seen = answer(*call)
    assert [column["name"] for column in seen["columns"]] == [
        "X_Value",
        "Channel 0",
        "X_Value",
        "Channel 1",
    ]
    assert [column["unit"] for column in seen["columns"]] == ["s", "N", "s", "Volts"]
    assert seen["reading"] is None
    by_time = answer(*call, "--column", "Channel 0", "--time", "X_Value")["reading"]
    by_interval = answer(*call, "--column", "Channel 0", "--interval-s", "0.002")["reading"]
    assert by_interval["revolutions"] == pytest.approx(by_time["revolutions"], rel=1e-9)
    assert answer(*call, "--column", "Channel 0", "--interval-s", "0.004")["reading"][
        "revolutions"
    ] == pytest.approx(2 * by_time["revolutions"], rel=1e-9)
    assert "--interval-s" in refusal(
        *call, "--column", "Channel 0", "--interval-s", "0.002", "--time", "1"
    )
    assert "--interval-s" in refusal(*call, "--column", "Channel 0")
    assert "--unit" in refusal(*call, "--unit", "N")
    assert "--place-unit" in refusal(
        *call, "--column", "Channel 0", "--interval-s", "0.002", "--place-unit", "s"
    )
