"""An unchanged equation is not judged twice: keys of findings, and what is judged again when
something changes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import sympy as sp

from derive import papers
from derive.__main__ import GENERATED
from derive.audit import key, record, verdicts
from derive.audit.case import Case
from derive.audit.judge import Judgement
from derive.audit.reading_search import list_reasons
from derive.discovery import import_modules, load_user_modules
from derive.papers import shi2021, wang2017, yu2023
from derive.papers.planting import subject as laws
from derive.quantity import Quantity
from tests.support.made_up import tampered

ROOT = Path(__file__).parents[3]
CASES = verdicts.find_cases(import_modules(papers))
PRINT_KEYS = """
from derive.audit import key
from derive.papers import shi2021, wang2017
print(*(key.equation_key(shi2021.CASE, n) for n in shi2021.PAPER.equations), key.laws_key(wang2017.CASE, {}))
"""

Records = tuple[list[record.Record], list[record.Record]]
"""Of equations, and of laws."""


class Here:
    """Runs in this process what would run in others, and counts it."""

    def __init__(self) -> None:
        self.judged: list[Any] = []

    def __enter__(self) -> Here:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def submit(self, function: Any, module: str, *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if len(arguments) == 1:
            self.judged.extend((module, number) for number in arguments[0])
            future.set_result(function(module, *arguments))
        else:
            self.judged.append("laws")
            made_up = {
                "paper": CASES[module].paper.name,
                "law": "made up",
                "search": "",
                "key": arguments[-1],
                "shares": [],
            }
            future.set_result([made_up])
        return future


def counting(patch: pytest.MonkeyPatch) -> Here:
    """Every judgement, made for nothing: a record that says only what it was made from."""
    local = Here()
    patch.setattr(verdicts, "ProcessPoolExecutor", lambda **_: local)
    patch.setattr(
        verdicts,
        "record_equations",
        lambda case, keys: [
            {
                "paper": case.paper.name,
                "equation": n,
                "key": its_key,
                "answer": _first(case, n),
                "mathml": {},
            }
            for n, its_key in keys.items()
        ],
    )
    return local


def _first(case: Case, number: str) -> str:
    return case.choices(number)[0].meaning if case.choices(number) else ""


@pytest.fixture
def counted(first: Records, monkeypatch: pytest.MonkeyPatch) -> Here:
    """What is judged after the first time."""
    return counting(monkeypatch)


@pytest.fixture(scope="module")
def first() -> Records:
    """Papers of two machines, judged from nothing."""
    with pytest.MonkeyPatch.context() as patch:
        counting(patch)
        return audited(([], []))


def audited(earlier: Records, rooms: Sequence[ModuleType] = (shi2021, wang2017)) -> Records:
    typeset: dict[str, dict[str, Any]] = {}
    for judged in earlier[0]:
        typeset.setdefault(judged["paper"], {})[judged["equation"]] = judged["mathml"]
    return verdicts.judge_modules(rooms, record.index_records(earlier[0], typeset), earlier[1])


@pytest.mark.long
def test_second_audit_reuses_all_judgements(counted: Here) -> None:
    rooms = tuple(import_modules(papers))
    first = audited(([], []), rooms)
    total = sum(len(case.paper.equations) for case in CASES.values())
    assert len(counted.judged) == total + 1
    counted.judged.clear()
    assert audited(first, rooms) == first
    assert counted.judged == []


def test_a_changed_transcription_alone_is_judged_again(
    counted: Here, first: Records, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed = shi2021.PAPER.equations["2a"]
    monkeypatch.setitem(
        shi2021.PAPER.equations, "2a", replace(printed, residual=2 * printed.residual)
    )
    second = audited(first)
    assert counted.judged == [(shi2021.__name__, "2a")]
    assert [r for r in second[0] if r not in first[0]] == [
        next(r for r in second[0] if r["equation"] == "2a")
    ]


def test_changed_chain_equation_repeats_laws(
    counted: Here, first: Records, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed = wang2017.PAPER.equations["19"]
    monkeypatch.setitem(
        wang2017.PAPER.equations, "19", replace(printed, residual=-printed.residual)
    )
    audited(first)
    linked = wang2017.CASE.linked("19")
    assert set(linked) > {"17", "19"}
    assert counted.judged == [*((wang2017.__name__, n) for n in linked), "laws"]


def test_with_another_engine_all_is_judged_again(
    counted: Here, first: Records, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(key, "engine_key", lambda *modules: "another")
    audited(first)
    assert len(counted.judged) == len(first[0]) + 1


def test_a_changed_derivation_reading_or_point_changes_the_key(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case, subject = yu2023.CASE, yu2023.CASE.subject
    number, claim = "Y1", yu2023.PAPER.equations["Y1"].claims
    before = key.equation_key(case, number)
    derived = {
        **case.claims,
        claim: replace(case.claims[claim], residual=2 * case.claims[claim].residual),
    }
    symbol = sorted(yu2023.PAPER.equations[number].residual.free_symbols, key=str)[0]
    third = {symbol: sp.Rational(1, 3)}
    variants = [
        replace(case, subject=tampered(subject, claims=lambda _: derived)),
        replace(case, paper=replace(case.paper, questions=[])),
        replace(
            case,
            subject=tampered(
                subject, admissible=lambda _, rng: {**subject.admissible(rng), **third}
            ),
        ),
        replace(
            case,
            subject=tampered(
                subject, reference=lambda _, n: [v | third for v in subject.reference(n)]
            ),
        ),
    ]
    assert key.equation_key(replace(case), number) == before
    assert before not in {key.equation_key(other, number) for other in variants}


@pytest.mark.long
def test_action_names_change_the_key_but_symbol_meanings_do_not() -> None:
    case, number = wang2017.CASE, "25"
    called = case.subject.actions()
    force = next(s for s in called if str(s) == "F_Ex")
    other = replace(
        case,
        subject=tampered(case.subject, actions=lambda _: called | {force: "push of the cam, x"}),
    )
    assert key.equation_key(other, number) != key.equation_key(case, number)
    judgement, printed = (
        Judgement("incomplete", "", missing=(sp.sin(1) * force,)),
        case.paper.equations[number],
    )
    renamed = Quantity(force.name, force.unit, "something else", "test")
    for symbol in (force, renamed):
        incomplete = Judgement("incomplete", "", missing=(sp.sin(1) * symbol,))
        assert list_reasons(incomplete, printed, called) == (
            f"lacks {called[force].rpartition(', ')[0]}",
        )
    assert list_reasons(judgement, printed, other.subject.actions()) == ("lacks push of the cam",)


def test_engine_key_covers_exactly_judging_code() -> None:
    names = {
        path.relative_to(ROOT / "derive").as_posix()
        for path in key.sources(["derive.audit.record"])
    }
    assert {
        "audit/record.py",
        "audit/judge.py",
        "audit/edits.py",
        "audit/terms.py",
        "audit/paper.py",
    } <= names
    assert {"evaluate.py", "equations.py", "quantity.py", "functions.py"} <= names
    assert not [
        n
        for n in names
        if n.startswith(("papers/", "systems/", "emit/")) or n == "audit/verdicts.py"
    ]
    of_laws = {p.name for p in key.sources(["derive.audit.laws", laws.__name__])}
    assert {"subject.py", "chain.py", "derivation.py", "bodies.py", "pitch_curve.py"} <= of_laws


SOURCE = '''
"""A module."""
LIMIT = 3
"""What a limit is."""

def double(value):
    """Return twice a value."""
    return 2 * value  # why
'''


@pytest.mark.parametrize(
    ("before", "after", "is_same"),
    [
        ("A module.", "Another sentence.", True),
        ("What a limit is.", "Another sentence.", True),
        ("Return twice a value.", "Another sentence.", True),
        ('    """Return twice a value."""\n', "", True),
        ("  # why", "", True),
        ("2 * value", "(2  *  value)", True),
        ("2 * value", "3 * value", False),
        ("2 * value", "2 + value", False),
        ("LIMIT = 3", "LIMIT = None", False),
        ("return 2", 'return "2"', False),
    ],
)
def test_engine_hash_ignores_docstrings_alone(
    tmp_path: Path, before: str, after: str, is_same: bool
) -> None:
    assert before in SOURCE
    keys = []
    for name, text in (("one", SOURCE), ("two", SOURCE.replace(before, after, 1))):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "stated_module.py").write_text(text, encoding="utf-8")
        with load_user_modules(folder / "stated_module.py") as (module,):
            key.engine_key.cache_clear()
            keys.append(key.engine_key(module.__name__))
    key.engine_key.cache_clear()
    assert (keys[0] == keys[1]) is is_same


@pytest.mark.parametrize("seed", ["1", pytest.param("20171", marks=pytest.mark.long)])
def test_keys_do_not_depend_on_the_hash_seed(seed: str) -> None:
    case = shi2021.CASE
    keys = [
        *(key.equation_key(case, n) for n in case.paper.equations),
        key.laws_key(wang2017.CASE, {}),
    ]
    process = subprocess.run(
        [sys.executable, "-c", PRINT_KEYS],
        cwd=ROOT,
        env=os.environ | {"PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stdout.split() == keys


def test_the_committed_records_are_those_of_this_code() -> None:
    committed = json.loads((GENERATED / "audit.json").read_text(encoding="utf-8"))
    typeset_records = json.loads((GENERATED / "audit_mathml.json").read_text(encoding="utf-8"))
    records = record.index_records(committed["equations"], typeset_records)
    stale = [
        (case.paper.name, n)
        for case in CASES.values()
        for n in case.paper.equations
        if not record.is_reusable(records.get((case.paper.name, n)), key.equation_key(case, n))
    ]
    assert stale == []
    answers = {
        r["equation"]: r["answer"]
        for r in committed["equations"]
        if r["paper"] == wang2017.PAPER.name
    }
    chosen = wang2017.CASE.select_choices({n: answers[n] for n in wang2017.CASE.executed})
    assert {law["key"] for law in committed["laws"]} == {key.laws_key(wang2017.CASE, chosen)}


def test_reused_records_are_written_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    committed = (GENERATED / "audit.json").read_text(encoding="utf-8")
    content = json.loads(committed)
    parts = (content[part] for part in ("equations", "laws", "references", "papers"))
    assert record.format_records(*parts) == committed
    typeset = (GENERATED / "audit_mathml.json").read_text(encoding="utf-8")
    typeset_records = json.loads(typeset)
    assert (
        record.format_typeset(record.index_records(content["equations"], typeset_records).values())
        == typeset
    )
    titles = {case.paper.name: case.paper.reference for case in CASES.values()}
    written = verdicts.as_page(content["equations"], titles, content["laws"], content["references"])
    assert written == (GENERATED / "AUDIT.md").read_text(encoding="utf-8")
