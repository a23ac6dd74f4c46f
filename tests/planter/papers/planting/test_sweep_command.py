"""`planter sweep` as it is called: its files, its words, and what kills at any moment leave of
it.
"""

import json
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest

from planter.rows import sweep
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema

ROOT = Path(__file__).parents[4]
EXAMPLE = ROOT / "docs" / "examples" / "sweep_speed.toml"
SMALL = """\
machine = "wang2017"
outputs = ["support_range_N"]
[inputs]
speed_rpm = [35, 40, 45]
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory, kernel_cache: None) -> tuple[dict, Path]:
    """The documented example: what it prints, and its folder."""
    out = tmp_path_factory.mktemp("sweep") / "run"
    return answer("sweep", str(EXAMPLE), "--out", str(out)), out


def test_sweep_example_matches_schema(done: tuple[dict, Path]) -> None:
    result, out = done
    jsonschema.validate(result, load_schema("sweep"))
    assert result["rows"] == 2 * 21 * 9 * 2
    assert result["columns"][:4] == ["model", "operation.speed_rpm", "mass.planet_kg", "design.m31"]
    assert (result["workers"], result["resumed"]) == (0, 0)
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["hash"], summary["plan"]["scheme"]) == (result["hash"], "grid")


def test_csv_and_parquet_have_equal_rows(done: tuple[dict, Path]) -> None:
    result, out = done
    parquet = pyarrow.parquet.read_table(out / "rows.parquet")
    lines = (out / "rows.csv").read_text().splitlines()
    head = sum(line.startswith("#") for line in lines)
    csv = pyarrow.csv.read_csv(
        out / "rows.csv", read_options=pyarrow.csv.ReadOptions(skip_rows=head)
    )
    assert parquet.column_names == csv.column_names == result["columns"]
    assert (parquet.num_rows, csv.num_rows) == (result["rows"],) * 2
    for name in parquet.column_names:
        assert parquet[name].to_pylist() == csv[name].to_pylist()
    for name, extent in result["envelope"].items():
        column = parquet[name].to_numpy()
        assert (extent["min"], extent["max"]) == (column.min(), column.max())
        assert np.isclose(extent["mean"], column.mean(), rtol=1e-12)
        row = parquet.slice(int(column.argmax()), 1).to_pylist()[0]
        assert extent["max_at"] == {key: row[key] for key in extent["max_at"]}


def test_sweep_without_pyarrow_writes_csv_and_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plan.toml").write_text(SMALL)
    out = tmp_path / "run"
    command = ("sweep", str(tmp_path / "plan.toml"), "--out", str(out))
    answer(*command)
    before = (out / "rows.csv").read_bytes()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr(sweep, "find_spec", lambda name: None)
    code, _, messages = run(*command)
    assert code == 0
    assert "planter[parquet]" in messages
    assert (out / "rows.csv").read_bytes() == before
    assert not (out / "rows.parquet").exists(), (
        "a table of an earlier call must not stay beside another"
    )


def test_folder_of_other_plan_exits_2(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(SMALL)
    out = tmp_path / "run"
    answer("sweep", str(tmp_path / "plan.toml"), "--out", str(out))
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    (tmp_path / "plan.toml").write_text(SMALL.replace("45", "46"))
    assert "sweep.sqlite" in refusal("sweep", str(tmp_path / "plan.toml"), "--out", str(out))
    assert before == {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    result = answer("sweep", str(tmp_path / "plan.toml"), "--out", str(out), "--overwrite")
    assert result["resumed"] == 0
    rows = pyarrow.parquet.read_table(out / "rows.parquet")
    assert rows["operation.speed_rpm"].to_pylist() == [35, 40, 46]


def test_sweep_without_plan_is_rejected() -> None:
    assert "PLAN or --list MACHINE" in refusal("sweep")
    assert "a plan must be a .toml file" in refusal("sweep", "plan.csv")
