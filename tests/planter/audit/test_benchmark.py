"""`planter audit --benchmark`: what the command returns and writes, and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema

from tests.derive.audit.texts.test_benchmark import write_text
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema


def test_benchmark_fits_its_schema_and_writes_claims(tmp_path: Path) -> None:
    write_text(tmp_path / "crank", "text.tex", "3" * 64)
    result = answer(f"audit {tmp_path} --benchmark --slips 18 --out", str(tmp_path / "out"))
    jsonschema.validate(result, load_schema("audit benchmark"))
    score, by_units = (result["checkers"][name]["all"] for name in ("planter", "units"))
    assert score["detected"] == score["slips"] > by_units["detected"] > 0
    assert (score["errata"], score["errata_found"], score["false_alarms"]) == (1, 1, 0)
    lines = (tmp_path / "out" / "claims.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(lines) == score["slips"] + score["errata"] + score["sound"]
    assert set(json.loads(lines[0])) == {"key", "latex", "text"}


def test_folder_that_is_no_corpus_is_refused(tmp_path: Path) -> None:
    assert "no such folder" in refusal("audit", str(tmp_path / "none"), "--benchmark")
    assert "source.toml" in refusal(f"audit {tmp_path} --benchmark")
    assert "--names" in refusal(f"audit {tmp_path} --benchmark --names names.toml")
    sentence = refusal("audit wang2017 --answers other.jsonl")
    assert "--answers" in sentence
    assert "--benchmark" in sentence
