"""The audit knows no paper, and no finding stands anywhere in the sources."""

import ast
import json
import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

import derive.audit
import derive.papers
from derive.audit.paper import Paper
from derive.audit.typesetting import GREEK
from derive.generated_folder import GENERATED
from derive.quantity import _BASE
from tests.support.made_up import judge_number
from tests.support.mutations import CASES, at_its_points, derivable, outcome, untouched
from tests.support.sampled import sampled

SOURCES = sorted(Path(derive.audit.__path__[0]).glob("*.py"))
TRANSCRIBED = sorted(Path(derive.papers.__path__[0]).rglob("*.py"))

SHARES = 4
"""Of the equations of a paper, each judged again in a copy of it; the long tests judge all but
two.
"""


def test_the_audit_names_no_paper_and_no_equation() -> None:
    names = set(CASES)
    numbers = {n for case in CASES.values() for n in case.paper.equations} - set(_BASE) - set(GREEK)
    for path in SOURCES:
        text = path.read_text()
        assert not [n for n in names if n in text], path.name
        quoted = {
            n.value
            for n in ast.walk(ast.parse(text))
            if isinstance(n, ast.Constant) and isinstance(n.value, str)
        }
        assert not quoted & numbers, path.name


def test_no_verdict_stands_in_transcriptions_or_derivations() -> None:
    words = re.compile(
        r"\b(confirmed|misprint|incomplete|contradicted|reconstructed|untested)\b", re.IGNORECASE
    )
    for path in TRANSCRIBED:
        assert not words.findall(path.read_text()), path.name


@pytest.mark.parametrize(
    ("name", "share"), sampled([("yu2023", 0), ("sun2019", 0)], product(CASES, range(SHARES)))
)
def test_renamed_paper_gets_the_same_verdicts(name: str, share: int) -> None:
    case = CASES[name]
    renamed = {number: f"copy {i}" for i, number in enumerate(case.paper.equations)}
    copied = {
        new: replace(case.paper.equations[old], number=new, source="copy")
        for old, new in renamed.items()
    }
    readings = {renamed[old]: reading for old, reading in case.paper.readings.items()}
    questions = [
        replace(q, numbers=tuple(renamed[n] for n in q.numbers)) for q in case.paper.questions
    ]
    paper = Paper(
        "copy", "a copy", copied, reading=case.paper.reading, readings=readings, questions=questions
    )
    copy = at_its_points(name, paper)
    for number in derivable(name)[share::SHARES]:
        judgement = judge_number(copy, renamed[number])
        assert outcome(judgement) == outcome(untouched(name, number)), number


def test_findings_and_corrections_do_not_stand_in_the_sources() -> None:
    texts = "\n".join(path.read_text() for path in TRANSCRIBED)
    record = json.loads((GENERATED / "audit.json").read_text(encoding="utf-8"))["equations"]
    corrections = {
        text
        for entry in record
        for correction in entry["correction"]
        for text in correction.split("; ")
    }
    assert corrections
    assert not [text for text in corrections if text in texts]
