"""`planter audit wang2017 --front`: what can be attained, told, drawn and written; refused where
there is none.
"""

import csv
import json
from pathlib import Path

from planter.papers.planting.printed.attainable import load_paper_points
from tests.support.cli import answer, refusal

TABLE1 = {"theory": (122.17, 1907.32), "experiment": (147.03, 1033.23)}


def test_front_is_reported_with_table_points_and_files(tmp_path: Path) -> None:
    front = answer(f"audit wang2017 --front --out {tmp_path}")["front"]
    assert load_paper_points("wang2017") == {
        row: {"range_N": r, "variance_N2": v} for row, (r, v) in TABLE1.items()
    }
    assert {row["name"]: (row["range_N"], row["variance_N2"]) for row in front["table"]} == TABLE1
    pushing, free = front["fronts"]
    assert [curve["contact"] for curve in front["fronts"]] == ["cam pushing", "free sign"]
    assert max(p["range_N"] for p in pushing["points"]) < max(p["range_N"] for p in free["points"])
    assert all(p["least_push_N"] >= 0 for p in pushing["points"])
    for row in front["table"]:
        statement = next(s for s in front["statements"] if s.startswith(f"Table 1, {row['name']}"))
        assert ("was not reached" in statement) is (
            max(row["most_variance_N2"].values()) < row["variance_N2"]
        )
    assert any("heuristic" in s for s in front["statements"])
    rows = list(csv.DictReader((tmp_path / "front.csv").open(encoding="utf-8")))
    assert [float(r["range_N"]) for r in rows] == [
        p["range_N"] for curve in front["fronts"] for p in curve["points"]
    ]
    assert json.loads((tmp_path / "front.json").read_text(encoding="utf-8"))["key"] == front["key"]
    assert "Table 1, theory" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert {path.name for path in tmp_path.iterdir()} >= {"front.svg", "front.png"}


def test_a_paper_without_a_front_is_refused() -> None:
    assert "--front needs one of the papers wang2017" in refusal("audit sun2019 --front")
