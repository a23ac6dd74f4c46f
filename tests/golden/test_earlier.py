"""Folders and files that earlier versions wrote load, and searches and sweeps in them go on."""

import shutil
import sqlite3
import subprocess
from pathlib import Path

import numpy as np
import pytest

from planter.planting import family_comparison as comparison
from planter.planting.file import load
from tests.support.cli import answer, refusal
from tests.support.lanes import STRICT, needs_compiler, path_of

EARLIER = Path(__file__).parent / "earlier"

pytestmark = pytest.mark.usefixtures("blank_figures")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(EARLIER, tmp_path / "earlier"))


def test_sweep_goes_on_from_an_earlier_store(folder: Path) -> None:
    arguments = ("sweep", str(folder / "plan.toml"), "--workers", "1", "--out")
    resumed, anew = (answer(*arguments, str(out)) for out in (folder / "sweep", folder / "anew"))
    assert (resumed["resumed"], anew["resumed"]) == (1, 0)
    rows = [np.genfromtxt(folder / run / "rows.csv", delimiter=",", skip_header=5) for run in ("sweep", "anew")]
    np.testing.assert_allclose(*rows, rtol=1e-12)
    assert rows[0].shape == (12, 4)


def test_damaged_chunk_of_an_earlier_store_is_computed_again(folder: Path) -> None:
    with sqlite3.connect(folder / "sweep" / "sweep.sqlite") as file:
        (content,) = file.execute("SELECT content FROM chunks").fetchone()
        file.execute("UPDATE chunks SET content = ?", (b"\0" * len(content),))
    file.close()
    result = answer("sweep", str(folder / "plan.toml"), "--workers", "1", "--out", str(folder / "sweep"))
    assert result["resumed"] == 0


def test_earlier_store_of_another_plan_is_not_changed(folder: Path) -> None:
    before = (folder / "sweep" / "sweep.sqlite").read_bytes()
    plan = folder / "plan.toml"
    plan.write_text(plan.read_text(encoding="utf-8").replace("[30, 40, 50]", "[30, 40, 51]"), encoding="utf-8")
    assert "another plan" in refusal("sweep", str(plan), "--out", str(folder / "sweep"))
    assert (folder / "sweep" / "sweep.sqlite").read_bytes() == before


@pytest.mark.long
def test_tolerance_goes_on_from_an_earlier_store(folder: Path) -> None:
    """The rows of another question would be refused."""
    options = ["--samples", "200", "--indices", "0", "--no-robust", "--output", "support_range_N", "--workers", "1"]
    result = answer("tolerance", "compact", *options, "--out", str(folder / "tolerance"))
    assert "support_range_N" in result["outputs"]


@pytest.mark.parametrize("pair", [None, ("limacon", "limacon")])
def test_compared_device_of_earlier_folder_is_reused(folder: Path, pair: tuple[str, str] | None) -> None:
    store = comparison.ComparisonStore(folder / "compare" / "devices", load("wang2017-wide"), starts=1, seed=0)
    assert (store.load(pair) or {}).get("objective")
    swapped = folder / "compare" / "devices" / "sine+limacon.json"
    shutil.copy(folder / "compare" / "devices" / "limacon+limacon.json", swapped)
    assert store.load(("sine", "limacon")) is None


def test_optimum_of_an_earlier_version_simulates(folder: Path) -> None:
    result = answer("simulate", str(folder / "optimum.toml"))
    assert result["objective"] < answer("simulate", "compact")["objective"]


@needs_compiler
def test_program_for_earlier_c_runs_with_current_code(folder: Path) -> None:
    answer("export", "c", "wang2017", "--out", "c")
    sources = [str(folder / "wang2017_main.c"), "c/wang2017.c"]
    subprocess.run([path_of("gcc"), *STRICT, "-Ic", "-o", "program", *sources, "-lm"], check=True)
    printed = subprocess.run(["./program"], check=True, capture_output=True, text=True).stdout
    now, before = (
        dict(line.split() for line in text.splitlines())
        for text in (printed, (folder / "wang2017_main.txt").read_text(encoding="utf-8"))
    )
    assert now.keys() == before.keys()
    pairs = np.array([(float(now[key]), float(before[key])) for key in before])
    np.testing.assert_allclose(*pairs.T, rtol=1e-12, atol=1e-12)
    assert len(subprocess.run(["./program", "turn"], check=True, capture_output=True).stdout.splitlines()) == 361
