"""Files as data loggers write them are read, what is dropped is said, and refusals name line and
remedy.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planter.errors import InputError
from planter.kernels import Array
from planter.measured.logger_table import LoggerTable, read_logger_table
from planter.measured.reading import Columns, Measurement, read
from planter.numerics.arrays import TURN
from tests.planter.measured.test_noise import correlate
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.labview import END, Layout, write_lvm

RATE, SPEED = 500.0, 30.0
"""Samples per second, and mean speed [rad/s]."""


def force(phi: Array) -> Array:
    """A force [N] with three harmonics."""
    return 50 + 20 * np.cos(phi) + 8 * np.sin(2 * phi) + 3 * np.cos(3 * phi)


def write_german(path: Path, jitter: float = 0.2) -> tuple[Array, Array]:
    """Write a record with preamble, decimal commas, a line of units, a trigger and damage; return
    time and angle.

    The pulse rises at angle 0, 1 rad after the record begins, and the speed swings by 2 %.
    """
    t = np.arange(0, 2.4, 1 / RATE)
    phi = SPEED * t - 0.02 * SPEED / 4.4 * np.cos(4.4 * t) - 1.0
    pulse = np.where(np.mod(phi, TURN) < 0.3, 4.8, 0.1)
    values = force(phi) + np.random.default_rng(2).normal(0, jitter, len(t))
    lines = ["Messgerät: Prüfstand 3;;", "Datum;12.03.2024;", "", "Zeit;Kraft;Trigger", "s;kN;V"]
    for i in range(len(t)):
        cells = [f"{t[i]:.4f}", f"{values[i] / 1e3:.7f}", f"{pulse[i]:.2f}"]
        if i in (300, 301, 302):
            cells[1] = ""
        if i == 400:
            cells[1] = "OVERFLOW"
        if i == 500:
            cells[1] = "0.400"
        if i == 600:
            lines.append("Bereich umgeschaltet;;")
        lines.append(";".join(cells).replace(".", ","))
    path.write_bytes("\r\n".join(lines).encode("cp1252"))
    return t, phi


def test_trigger_record_gives_angles_and_losses(tmp_path: Path) -> None:
    path = tmp_path / "daq.csv"
    t, phi = write_german(path)
    measured = read(path, Columns("Kraft", time="Zeit", trigger="Trigger"), 1.0)
    result = measured.reading
    assert result is not None
    assert (result.encoding, result.channels[0].gaps, result.channels[0].outliers) == (
        "Windows-1252",
        4,
        1,
    )
    assert result.channels[0].outlier_lines == [5 + 501]
    reasons = {entry.reason: entry for entry in result.dropped}
    assert reasons["lines of text among the rows"].lines == [5 + 601]
    assert reasons["overflow of the logger in Kraft"].lines == [5 + 401]
    before = next(entry for reason, entry in reasons.items() if "before the first" in reason)
    assert result.rows - before.count == len(measured.phi)
    truth = np.interp(
        np.arange(len(measured.phi)) + np.flatnonzero(phi >= 0)[0], np.arange(len(t)), phi
    )
    # a pulse is known to half a sample: 0.03 rad
    assert measured.phi == pytest.approx(truth, abs=0.08)
    assert measured.speed is not None
    assert measured.speed == pytest.approx(
        SPEED * (1 + 0.02 * np.sin(4.4 * (truth + 1) / SPEED)), rel=0.015
    )
    assert result.speed_rpm is not None
    assert result.speed_rpm[0] < 0.99 * result.speed_rpm[1] < result.speed_rpm[2]
    used = measured.used
    assert measured.values[used] == pytest.approx(force(measured.phi[used]), abs=2.0)
    assert len(measured.treatment) >= 3 + len(result.dropped)


def test_encodings_separators_and_header_units(tmp_path: Path) -> None:
    degrees = np.arange(0.0, 720.0, 5.0)
    values = force(np.radians(degrees))
    rows = [f"{a % 360:.3f}\t{f:.6f}\tok" for a, f in zip(degrees, values, strict=True)]
    texts = {
        "utf-16": "\n".join(["% made up", "Winkel (°)\tKraft (N)\tnote", *rows]),
        "utf-8-sig": "\r\n".join(["Winkel [°]\tKraft [N]\tnote", *rows]) + "\r\n\x1a",
        "latin-1": "\r".join(["Prüfung", "Winkel\tKraft\tnote", "[deg]\t[N]\t", *rows]),
        "utf-16-le": "\n".join(["Winkel / deg\tKraft / N\tnote", *rows]),
    }
    for encoding, text in texts.items():
        path = tmp_path / f"{encoding}.txt"
        path.write_bytes(text.encode(encoding))
        measured = read(path, Columns("Kraft", angle="Winkel"), 1.0)
        assert measured.phi == pytest.approx(np.radians(degrees), abs=1e-9), encoding
        assert measured.values == pytest.approx(values, abs=1e-6), encoding


def read_rows(tmp_path: Path, head: str, rows: list[str], columns: Columns) -> Measurement:
    path = tmp_path / "data.csv"
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return read(path, columns, SPEED)


def test_repeated_stamps_are_spread_or_dropped(tmp_path: Path) -> None:
    t = np.arange(0, 1.0, 1e-3)
    coarse = [f"{np.floor(s * 100) / 100:.2f};{force(np.array(SPEED * s)):.4f}" for s in t]
    measured = read_rows(tmp_path, "t [s];F [N]", coarse, Columns("F", time="t"))
    assert measured.phi == pytest.approx(SPEED * t, abs=SPEED * 1.1e-3)
    assert measured.reading is not None
    assert "coarse" in measured.reading.angle
    single = [f"{s:.4f};{force(np.array(SPEED * s)):.4f}" for s in t]
    single.insert(50, single[49])
    measured = read_rows(tmp_path, "t [s];F [N]", single, Columns("F", time="t"))
    assert len(measured.phi) == len(t)
    assert measured.reading is not None
    assert [(entry.count, entry.lines) for entry in measured.reading.dropped] == [(1, [52])]


def test_clock_times_run_past_midnight(tmp_path: Path) -> None:
    rows = []
    for i in range(40):
        seconds = (86_390 + i / 2) % 86_400
        clock = f"{int(seconds // 3600):02d}:{int(seconds % 3600 // 60):02d}:{seconds % 60:04.1f}".replace(
            ".", ","
        )
        rows.append(f"{clock};{i / 7:.3f}".replace(".", ","))
    measured = read_rows(tmp_path, "Uhrzeit;F [N]", rows, Columns("F", time="Uhrzeit"))
    assert np.diff(measured.phi) == pytest.approx(SPEED / 2)


def test_lost_pulse_drops_a_revolution_and_a_half(tmp_path: Path) -> None:
    t = np.arange(0, 3.0, 1e-3)
    phi = 20.0 * t
    pulse = (np.mod(phi, TURN) < 0.3) & ~((phi > 3 * TURN - 1) & (phi < 3 * TURN + 1))
    rows = [f"{s:.4f};{f:.4f};{int(p)}" for s, f, p in zip(t, force(phi), pulse, strict=True)]
    measured = read_rows(tmp_path, "t [s];F [N];z", rows, Columns("F", time="t", trigger="z"))
    assert measured.reading is not None
    lost = next(entry for entry in measured.reading.dropped if "one is missing" in entry.reason)
    assert lost.count == pytest.approx(2 * TURN / 20 * 1e3, abs=3)
    assert measured.values == pytest.approx(force(measured.phi), abs=1.0)


def test_noise_of_revolutions_needs_no_model(tmp_path: Path) -> None:
    rng, phi = np.random.default_rng(8), np.arange(0, 6 * TURN, TURN / 120)
    noise = correlate(rng, len(phi), 0.9, 1.0)
    rows = [f"{a:.5f};{f:.5f}" for a, f in zip(np.degrees(phi), force(phi) + noise, strict=True)]
    channel = read_rows(tmp_path, "a [deg];F [N]", rows, Columns("F", angle="a")).channels[0]
    assert channel.noise == pytest.approx(1.0, rel=0.3)
    assert channel.rho == pytest.approx(0.9, abs=0.12)
    single_revolution = read_rows(
        tmp_path, "a [deg];F [N]", rows[:120], Columns("F", angle="a")
    ).channels[0]
    assert single_revolution.rho is None


ROWS = [f"{a};{a / 7:.2f}" for a in range(40)]
REFUSED = {
    "text": (["hello", "world"], "line 1 is 'hello'"),
    "two decimal marks": (["a [deg];F [N]", *ROWS, "41;1.2.3", "42;1"], "line 42, column F"),
    "commas for both": (
        ["a [deg],F [N]", *(f"{a},{a / 7:.2f}".replace(".", ",") for a in range(40))],
        "decimal commas",
    ),
    "unknown unit": (["a [deg];F [lbf]", *ROWS], "the unit lbf does not fit"),
    "extra cell": (["a [deg];F [N]", *ROWS[:20], "20;3;4", *ROWS[20:]], "line 22 has 3 cells"),
    "few rows": (["a [deg];F [N]", *ROWS[:8]], "8 points are too few"),
    "open quote": (["a [deg];F [N]", *ROWS[:20], '20;"3', *ROWS[20:]], "line 22"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusal_names_line_and_remedy(case: str, tmp_path: Path) -> None:
    lines, hint = REFUSED[case]
    path = tmp_path / "data.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        read(path, Columns("F", angle="a"), SPEED)
    assert hint in error.value.message


def test_time_that_runs_back_is_refused(tmp_path: Path) -> None:
    rows = [*ROWS]
    rows[20] = "3;1"
    with pytest.raises(InputError, match="line 22, column t") as error:
        read_rows(tmp_path, "t [s];F [N]", rows, Columns("F", time="t"))
    assert "cut the file here" in error.value.message


def test_empty_and_binary_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    for content, hint in (
        (b"", "empty"),
        (b"\x00\x01\x02" * 400, "line"),
        (b"\xff\xfea", "cut off"),
    ):
        path.write_bytes(content)
        with pytest.raises(InputError, match=hint):
            read_logger_table(path)


def test_column_is_found_by_an_unambiguous_part(tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_text(
        "Angle [deg],Support force left [N],Support force right [N],Mount [N]\n0,1,2,3\n1,2,3,4\n"
    )
    table = read_logger_table(path)
    assert [
        table.find_column(name, "--column") for name in ("force left", "MOUN", "Mount", "4")
    ] == [1, 3, 3, 3]
    with pytest.raises(
        InputError, match=r"'Support force left \[N\]' or 'Support force right \[N\]'"
    ):
        table.find_column("Support force", "--column")
    for name in ("", "deg", "[N]", "speed"):
        with pytest.raises(InputError, match="is not a column"):
            table.find_column(name, "--column")


def test_preview_shows_reading_and_fits_nothing(tmp_path: Path) -> None:
    path = tmp_path / "daq.csv"
    write_german(path)
    machine = str(own.generated("slider_crank") / "slider_crank.toml")
    call = ("calibrate", machine, "--data", str(path), "--time", "Zeit", "--trigger", "Trigger")
    answered = answer(
        *call,
        "--column",
        "Kraft",
        "--quantity",
        "F_Ox_N",
        "--preview",
        "--out",
        str(tmp_path / "out"),
    )
    assert answered.keys() == {"machine", "quantity", "columns", "reading", "treatment"}
    assert answered["reading"]["channels"][0]["outliers"] == 1
    assert (tmp_path / "out" / "figures" / "data.png").stat().st_size > 10_000
    assert "--column must name" in refusal(*call, "--quantity", "F_Ox_N")
    unnamed = answer(*call, "--preview")
    assert [column["name"] for column in unnamed["columns"]] == ["Zeit", "Kraft", "Trigger"]
    assert unnamed["reading"]["revolutions"] == pytest.approx(answered["reading"]["revolutions"])
    assert "--quantity is given 1 times" in refusal(
        *call, "--column", "Kraft", "--column", "Trigger", "--quantity", "F_Ox_N", "--preview"
    )


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
    "times of two rates": Layout(x_columns="Multi", steps=(0.002, 0.003)),
    "no times, two rates": Layout(x_columns="No", steps=(0.002, 0.003)),
    "commas": Layout(separator="Comma", x_columns="Multi"),
    "segments that begin anew, past midnight": Layout(segments=30, restarts=True),
}
"""Layouts that those of the search do not have, or seldom."""


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


DAMAGED = {
    "unknown layout": ("X_Columns\tOne", "X_Columns\tTwo", "X_Columns"),
    "layout of another file": ("X_Columns\tOne", "X_Columns\tMulti", "X_Columns Multi"),
    "other channels": ("Channels\t2", "Channels\t3", "Channels is '3'"),
    "separator of another file": ("Separator\tTab", "Separator\tComma", "Separator"),
    "no decimal mark": ("Decimal_Separator\t.", "Decimal_Separator\t", "Decimal_Separator"),
    "header that does not end": (END, "***End***", END),
    "no names": ("X_Value", "", "X_Value"),
    "text among numbers": ("0.002\t", "0.0o2\t", "0.0o2"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_damage_is_refused_by_key_or_line(case: str, tmp_path: Path) -> None:
    old, new, hint = DAMAGED[case]
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
