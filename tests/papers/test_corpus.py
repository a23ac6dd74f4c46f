"""The corpus of the benchmark: every text is read, its sound rows hold, its known errors are found
and mended.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from derive.audit.texts.benchmark import CorpusText, TextClaims, read_corpus, run_benchmark

CORPUS = Path(__file__).parent / "corpus"
TEXTS = read_corpus(CORPUS)
PRESENT = [text for text in TEXTS if text.file is not None]
LONG = ("whipple_dissertation",)
FREE = re.compile(r"(CC-BY|CC0|MIT|BSD|Apache)")


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(text, marks=[pytest.mark.long] * (text.name in LONG), id=text.name)
        for text in PRESENT
    ],
)
def test_sound_rows_hold_and_errors_are_found(text: CorpusText) -> None:
    claims = TextClaims(text)
    assert claims.sound
    assert [claim.row for claim in claims.sound if claims.judge(claim) != "holds"] == []
    for claim in claims.errata:
        assert claims.judge(claim) == "fails"
        mended = replace(claim, latex=claim.correct)
        assert claims.judge(mended) == "holds", f"{claim.row} as it should be"


def test_texts_with_a_free_licence_are_there_and_no_others() -> None:
    assert len(TEXTS) >= 15
    for text in TEXTS:
        assert (text.file is not None) == bool(FREE.match(text.table["licence"])), text.name
        assert re.fullmatch(r"[0-9a-f]{64}", text.table["sha256"]), text.name
        assert re.fullmatch(r"[0-9a-f]{40}", text.table["commit"]), text.name


def test_every_erratum_has_its_source_and_its_verification() -> None:
    errata = [(text.name, entry) for text in TEXTS for entry in text.table.get("errata", ())]
    assert len(errata) >= 40
    for name, entry in errata:
        assert all(entry[key] for key in ("row", "what", "corrected", "source", "verified")), name


def test_a_third_of_texts_is_held_out_and_says_why() -> None:
    held_out = [text for text in TEXTS if text.is_held_out]
    assert len(TEXTS) / 3 <= len(held_out) < 2 * len(TEXTS) / 3
    for text in held_out:
        assert re.fullmatch(r"its hash|[0-9a-f]{8}, \d{4}-\d{2}-\d{2}", text.table["held_out"]), (
            text.name
        )


@pytest.mark.long
def test_goals_of_the_benchmark_are_met() -> None:
    result = run_benchmark(CORPUS, 300, 1)
    scores = result["checkers"]["planter"]["all"]
    assert scores["detection"] >= 0.95
    assert scores["exact_repair"] >= 0.8
    assert scores["false_alarms_per_100"] <= 1
    assert scores["errata_found"] == scores["errata"]
    rows = sum(text["rows"] for text in result["texts"])
    assert sum(text["read_rows"] for text in result["texts"]) >= 0.9 * rows
