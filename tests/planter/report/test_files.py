"""Result files: nothing is lost, nothing is half written, and what is not a number is refused."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from planter import safe_text
from planter.errors import ComputationError, InputError
from planter.files import examples
from planter.papers.planting import file
from planter.report import files
from tests.support.tables import read_cycle_csv, write_cycle_csv

NASTY = [
    0.1,
    1 / 3,
    -0.0,
    5e-324,
    1.7976931348623157e308,
    123456789.123456789,
    math.pi,
    1e22,
    2.0**-1074 * 3,
]


def test_csv_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "cycle.csv"
    rng = np.random.default_rng(0)
    columns = {
        "phi_deg": np.array(NASTY),
        "a, b": rng.standard_normal(len(NASTY)),
        "n": np.arange(len(NASTY)),
    }
    write_cycle_csv(path, ["machine: x", "two\nlines", ""], columns)
    comments, read_columns = read_cycle_csv(path)
    assert comments == ["machine: x", "two", "lines", ""]
    assert list(read_columns) == list(columns)
    for name, column in columns.items():
        assert read_columns[name].tobytes() == np.asarray(column, dtype=float).tobytes()


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_csv_refuses_non_finite_values(tmp_path: Path, bad: float) -> None:
    with pytest.raises(ComputationError, match="support_N is not finite in row 1"):
        write_cycle_csv(tmp_path / "c.csv", [], {"phi_deg": [0.0, 1.0], "support_N": [1.0, bad]})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("columns", [{}, {"a": [1.0], "b": [1.0, 2.0]}, {"a": [[1.0, 2.0]]}])
def test_csv_refuses_unequal_columns(tmp_path: Path, columns: dict[str, list[float]]) -> None:
    with pytest.raises(ComputationError, match=r"columns .* shapes"):
        write_cycle_csv(tmp_path / "c.csv", [], columns)


def test_summary_is_json_with_all_digits(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    summary = {
        "a": np.float64(1 / 3),
        "b": np.arange(3),
        "c": {"d": [np.int64(2), None, True, "φ"]},
        "e": (0.1,),
    }
    files.write_summary(path, summary)
    read_summary = json.loads(path.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert read_summary == {
        "a": 1 / 3,
        "b": [0, 1, 2],
        "c": {"d": [2, None, True, "φ"]},
        "e": [0.1],
    }


@pytest.mark.parametrize("bad", [math.nan, math.inf, np.float64("nan"), np.array([1.0, -np.inf])])
def test_summary_refuses_nan_and_names_the_key(tmp_path: Path, bad: object) -> None:
    with pytest.raises(ComputationError, match=r"support_force\.max_N"):
        files.write_summary(tmp_path / "summary.json", {"support_force": {"max_N": bad}})
    assert list(tmp_path.iterdir()) == []


def test_failed_write_leaves_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "summary.json"
    files.write_text(path, "old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", full)
        with pytest.raises(InputError, match="No space left"):
            files.write_text(path, "new")
    assert path.read_text() == "old"
    assert {entry.name for entry in tmp_path.iterdir()} == {path.name, ".planter.json"}
    files.write_text(path, "new")
    assert path.read_text() == "new"


def test_unwritable_folder_is_refused(tmp_path: Path) -> None:
    occupied = tmp_path / "occupied"
    occupied.write_text("a file")
    for folder in (occupied, occupied / "below", "a\0b"):
        with pytest.raises(InputError) as caught:
            files.output_folder(folder)
        assert caught.value.exit_code == 2
        assert safe_text.sanitise_line(str(folder)) in caught.value.message
        assert "\n" not in caught.value.message
    with pytest.raises(InputError, match="occupied"):
        write_cycle_csv(occupied / "cycle.csv", [], {"a": [1.0]})


def test_provenance_is_of_the_values_not_of_the_file(tmp_path: Path) -> None:
    copy = tmp_path / "copy.toml"
    copy.write_text("# another comment\n" + examples.example("wang2017"), encoding="utf-8")
    provenance = files.list_provenance(file.load("wang2017"), seed=7)
    assert files.list_provenance(file.load(copy), seed=7) == provenance
    assert provenance["seed"] == 7
    assert len(provenance["machine_sha256"]) == 64
    assert {"planter", "casadi", "numpy", "python"} <= set(provenance)
    assert "seed" not in files.list_provenance(file.load("wang2017"))


def test_comments_are_sufficient_to_repeat_a_run() -> None:
    machine = file.load("wang2017", {"sun_kg": 0.5})
    text = "\n".join(files.list_comments(machine, "machine", ["model: exact"], seed=3))
    for part in (
        "machine: wang2017",
        "model: exact",
        "casadi",
        "command line: mass.sun_kg",
        "seed: 3",
    ):
        assert part in text
    assert files.list_provenance(machine)["machine_sha256"] in text


def test_unencodable_text_is_escaped_in_single_lines(tmp_path: Path) -> None:
    files.write_summary(tmp_path / "summary.json", {"source": "w\udcff.csv"})
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8")) == {
        "source": "w\udcff.csv"
    }
    write_cycle_csv(tmp_path / "cycle.csv", ["data: w\udcff\x1b[31m\u2028x"], {"a\nb": [1.0]})
    assert (
        tmp_path / "cycle.csv"
    ).read_bytes() == b"# data: w\\udcff\\x1b[31m\\u2028x\na\\nb\n1.0\n"
