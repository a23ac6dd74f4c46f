"""The benchmark of audits: what is selected, what counts, and checkers that are right or wrong by
construction.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from derive.audit.texts.benchmark import (
    BenchmarkClaim,
    CheckerAnswer,
    Outcome,
    TextClaims,
    read_corpus,
    run_benchmark,
    score_answers,
)
from derive.audit.texts.changes import SLIPS
from derive.audit.texts.monomials import MonomialSearch
from derive.audit.texts.names import PointNames
from derive.generated_folder import OwnError
from tests.support import own

TEXT = r"""\begin{align}
 s &= r\cos\varphi + l\cos\beta \label{eq:s}\\
 r\sin\varphi + l\sin\beta &= e \label{eq:e}\\
 \dot s &= -r\omega\sin\varphi + l\dot\beta\sin\beta \label{eq:v}\\
 l\dot\beta\cos\beta &= - r\omega\cos\varphi \label{eq:b}\\
 T &= \frac{1}{2} m_s \dot{s}^2 + \frac{1}{2} J \dot\beta^2 + \frac12 m_r v_C^2 \label{eq:T}
\end{align}"""
CORRECT = r"\dot s &= -r\omega\sin\varphi - l\dot\beta\sin\beta \label{eq:v}"
SOURCE = """title = "A crank"
licence = "CC0-1.0"
commit = "0"
path = "crank.tex"
sha256 = "{hash}"

[[errata]]
row = "eq:v"
corrected = '{correct}'
"""


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("corpus")
    write_text(folder / "crank", "text.tex", hashlib.sha256(b"a").hexdigest())
    return folder


def write_text(folder: Path, file: str, digest: str) -> None:
    folder.mkdir()
    shutil.copy(own.EXAMPLES / "slider_crank.py", folder / "mechanism.py")
    shutil.copy(own.EXAMPLES / "slider_crank_text.names.toml", folder / "names.toml")
    (folder / file).write_text(TEXT, encoding="utf-8")
    (folder / "source.toml").write_text(
        SOURCE.format(hash=digest, correct=CORRECT), encoding="utf-8"
    )


@pytest.fixture(scope="module")
def claims(corpus: Path) -> TextClaims:
    return TextClaims(read_corpus(corpus)[0])


def test_known_error_is_one_and_the_rest_is_sound(claims: TextClaims) -> None:
    (erratum,) = claims.errata
    assert erratum.row == "eq:v"
    assert claims.answer(erratum) == CheckerAnswer("fails", is_exact=True)
    assert [claim.row for claim in claims.sound] == ["eq:s", "eq:e", "eq:b", "eq:T"]
    assert {claims.judge(claim) for claim in claims.sound} == {"holds"}


def test_slips_of_all_classes_change_what_is_said_and_are_found(claims: TextClaims) -> None:
    selected = claims.draw(54, 3)
    slips = [claim for claim in selected if claim.kind == "slip"]
    assert {claim.slip for claim in slips} == set(SLIPS)
    assert len({claim.key for claim in selected}) == len(selected)
    answers = [claims.answer(claim) for claim in slips]
    assert all(answer.outcome == "fails" for answer in answers)
    assert np.mean([answer.is_exact for answer in answers]) >= 0.9
    assert [claim.latex for claim in claims.draw(54, 3)] == [claim.latex for claim in selected]
    assert [claim.latex for claim in claims.draw(54, 4)] != [claim.latex for claim in selected]


def test_rewrites_change_nothing(claims: TextClaims) -> None:
    rewrites = [
        claim for seed in range(8) for claim in claims.draw(9, seed) if claim.kind == "rewrite"
    ]
    assert all(claim.latex != claim.correct for claim in rewrites)
    assert {claims.judge(claim) for claim in rewrites} == {"holds"}


def test_equation_that_only_the_motion_makes_equal_is_no_slip(claims: TextClaims) -> None:
    place = claims.sound[0]
    assert claims.is_same(r"s = l\cos\beta + r\cos\varphi", r"r\cos\varphi + l\cos\beta = s", place)
    assert not claims.is_same(
        r"s = r\cos\varphi + l\cos\beta", r"s = r\cos\varphi + \sqrt{l^2 - e^2}", place
    )


@pytest.mark.parametrize(
    ("outcome", "detection", "alarms"), [("holds", 0, 0), ("fails", 1, 100), ("refused", 0, None)]
)
def test_one_answer_to_all_has_its_score(
    claims: TextClaims, outcome: Outcome, detection: float, alarms: float | None
) -> None:
    selected = [*claims.sound, *claims.errata, *claims.draw(18, 0)]
    score = score_answers(selected, [CheckerAnswer(outcome)] * len(selected))["all"]
    assert (score["detection"], score["exact_repair"], score["false_alarms_per_100"]) == (
        detection,
        0,
        alarms,
    )
    assert score["errata_found"] == (outcome == "fails")


def test_answers_of_another_checker_are_scored_beside(corpus: Path, tmp_path: Path) -> None:
    first = run_benchmark(corpus, 18, 0)
    path = tmp_path / "other.jsonl"
    # a checker that knows the sound equations by heart, and repairs every slip to the first of them
    sound_keys = {claim["key"] for claim in first["claims"] if ":sound:" in claim["key"]}
    lines = [
        {"key": c["key"], "outcome": "holds" if c["key"] in sound_keys else "fails"}
        for c in first["claims"]
    ]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    scores = run_benchmark(corpus, 18, 0, path)["checkers"]["other"]["all"]
    assert (scores["detection"], scores["errata_found"], scores["exact_repair"]) == (1, 1, 0)
    assert scores["false_alarms"] == sum(":rewrite:" in claim["key"] for claim in first["claims"])
    unnamed = first["checkers"]["planter without names"]["all"]
    named = first["checkers"]["planter"]["all"]
    assert unnamed["refused"] > named["refused"] == 0  # nothing says what v_C is
    assert 0 < unnamed["detected"] < named["detected"] == named["slips"]
    assert (unnamed["false_alarms"], unnamed["errata_found"]) == (0, 1)
    path.write_text('{"key": "x"}\n', encoding="utf-8")
    with pytest.raises(OwnError, match=r"other\.jsonl, line 1"):
        run_benchmark(corpus, 18, 0, path)


def test_text_is_held_out_if_its_source_gives_a_reason(tmp_path: Path) -> None:
    for name, key in (
        ("plain", ""),
        ("kept", 'held_out = "added last"\n'),
        ("empty", 'held_out = ""\n'),
    ):
        write_text(tmp_path / name, "text.tex", "3" * 64)
        source = tmp_path / name / "source.toml"
        source.write_text(key + source.read_text(encoding="utf-8"), encoding="utf-8")
    assert [text.name for text in read_corpus(tmp_path) if text.is_held_out] == ["kept"]


def test_original_is_read_only_with_its_hash(tmp_path: Path) -> None:
    digest = hashlib.sha256(TEXT.encode()).hexdigest()
    write_text(tmp_path / "crank", "crank.tex", digest)
    (text,) = read_corpus(tmp_path)
    assert text.file == tmp_path / "crank" / "crank.tex"
    text.file.write_text(TEXT.replace("+", "-"), encoding="utf-8")
    with pytest.raises(OwnError, match="hash"):
        read_corpus(tmp_path)
    text.file.unlink()
    assert read_corpus(tmp_path)[0].file is None
    with pytest.raises(OwnError, match="none of its texts"):
        run_benchmark(tmp_path, 9, 0)


def find_products(claims: TextClaims, values: Any, dimension: Any = None) -> list[str]:
    names = PointNames(claims.printed.names, claims.points)
    return list(MonomialSearch(names, claims.vocabulary).find(values, dimension))


def test_term_is_found_by_its_values(claims: TextClaims) -> None:
    names = PointNames(claims.printed.names, claims.points)
    factors = MonomialSearch(names, claims.vocabulary)._search.factors
    by_name = {factor.label: factor.values for factor in factors}
    values = -1.5 * by_name["m_{s}"] * by_name[r"\dot{s}^2"] * by_name[r"\cos \beta"]
    assert find_products(claims, values)[0].split() == [
        r"-\frac{3}{2}",
        r"\dot{s}^2",
        "m_{s}",
        r"\cos",
        r"\beta",
    ]
    assert find_products(claims, values, (0, 1, 0)) == []
    assert find_products(claims, values * np.linspace(1, 1.001, len(values))) == []
    assert find_products(claims, np.random.default_rng(0).uniform(0.5, 2, len(values))) == []


def test_claims_are_told_apart_by_what_they_say() -> None:
    first = BenchmarkClaim("t", "1", "a = b", "sound")
    assert first.key != BenchmarkClaim("t", "1", "a = c", "sound").key
    assert first.key == BenchmarkClaim("t", "1", "a = b", "sound", correct="a = c").key


def test_folder_without_texts_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OwnError, match=r"source\.toml"):
        read_corpus(tmp_path)
