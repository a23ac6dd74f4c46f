"""An unchanged paper is not judged twice: keys of findings, and what is judged again when something
changes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import sympy as sp

from derive import papers
from derive.__main__ import GENERATED
from derive.audit import key, record, verdicts
from derive.audit.faults import list_reasons
from derive.audit.judge import Judgement
from derive.audit.paper import Paper
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
print(key.equations_key(shi2021.CASE), key.laws_key(wang2017.CASE, {}))
"""


class Here:
    """Answers in the place of other processes with records that say only what they were made from,
    and counts what is judged.
    """

    def __init__(self) -> None:
        self.judged: list[Any] = []

    def __enter__(self) -> Here:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def submit(self, function: Any, module: str, subject: Any, its_key: str) -> Future[Any]:
        case = CASES[module]
        record: dict[str, Any] = {"paper": case.paper.name, "key": its_key, "mathml": {}}
        is_law = function is verdicts._laws
        self.judged += ["laws"] if is_law else [(module, number) for number in subject]
        future: Future[Any] = Future()
        if is_law:
            future.set_result([record | {"law": "made up", "search": "", "shares": []}])
        else:
            meanings = {n: [c.meaning for c in case.choices(n)] for n in subject}
            future.set_result(
                [record | {"equation": n, "answer": "".join(meanings[n][:1])} for n in subject]
            )
        return future


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Here:
    """What is judged, made for nothing."""
    local = Here()
    monkeypatch.setattr(verdicts, "ProcessPoolExecutor", lambda **_: local)
    return local


def audited(earlier: Any = ((), ())) -> Any:
    records = {(r["paper"], r["equation"]): r for r in earlier[0]}
    return verdicts.judge_modules((shi2021, wang2017), records, earlier[1])


def change(patch: pytest.MonkeyPatch, paper: Paper, number: str) -> None:
    printed = paper.equations[number]
    patch.setitem(paper.equations, number, replace(printed, residual=2 * printed.residual))


def test_changed_paper_alone_is_judged_again(
    counted: Here, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = audited()
    everything = {(m.__name__, n) for m in (wang2017, shi2021) for n in m.PAPER.equations}
    assert set(counted.judged) == everything | {"laws"}
    assert counted.judged.index("laws") == len(wang2017.PAPER.equations)
    counted.judged.clear()
    assert audited(first) == first
    assert counted.judged == []
    change(monkeypatch, shi2021.PAPER, "2a")
    second = audited(first)
    assert {module for module, _ in counted.judged} == {shi2021.__name__}
    counted.judged.clear()
    change(monkeypatch, wang2017.PAPER, "19")
    audited(second)
    assert counted.judged[-1] == "laws"
    assert {module for module, _ in counted.judged[:-1]} == {wang2017.__name__}
    counted.judged.clear()
    monkeypatch.setattr(key, "engine_key", lambda *modules: "another")
    audited(second)
    assert len(counted.judged) == len(everything) + 1


def test_a_changed_derivation_reading_or_point_changes_the_key() -> None:
    case, subject = yu2023.CASE, yu2023.CASE.subject
    number, claim = "Y1", yu2023.PAPER.equations["Y1"].claims
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
    before = key.equations_key(case)
    assert key.equations_key(replace(case)) == before
    assert before not in {key.equations_key(other) for other in variants}


@pytest.mark.long
def test_action_names_change_the_key_but_symbol_meanings_do_not() -> None:
    case, number = wang2017.CASE, "25"
    called = case.subject.actions()
    force = next(s for s in called if str(s) == "F_Ex")
    renamed = called | {force: "push of the cam, x"}
    other = replace(case, subject=tampered(case.subject, actions=lambda _: renamed))
    assert key.equations_key(other) != key.equations_key(case)
    printed = case.paper.equations[number]
    for symbol in (force, Quantity(force.name, force.unit, "something else", "test")):
        incomplete = Judgement("incomplete", "", missing=(sp.sin(1) * symbol,))
        for names in (called, renamed):
            assert list_reasons(incomplete, printed, names) == (
                f"lacks {names[force].rpartition(', ')[0]}",
            )


def test_engine_key_covers_exactly_judging_code() -> None:
    names = {
        path.relative_to(ROOT / "derive").as_posix()
        for path in key.list_sources(["derive.audit.record"])
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
    of_laws = {p.name for p in key.list_sources(["derive.audit.laws", laws.__name__])}
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
    process = subprocess.run(
        [sys.executable, "-c", PRINT_KEYS],
        cwd=ROOT,
        env=os.environ | {"PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )
    keys = [key.equations_key(shi2021.CASE), key.laws_key(wang2017.CASE, {})]
    assert process.stdout.split() == keys


def test_the_committed_records_are_those_of_this_code() -> None:
    committed = json.loads((GENERATED / "audit.json").read_text(encoding="utf-8"))
    equations = {(r["paper"], r["equation"]): r for r in committed["equations"]}
    for case in CASES.values():
        its_key, name = key.equations_key(case), case.paper.name
        assert {equations[name, n]["key"] for n in case.paper.equations} == {its_key}
    case = wang2017.CASE
    answers = {n: equations[case.paper.name, n]["answer"] for n in case.executed}
    law_key = key.laws_key(case, case.select_choices(answers))
    assert {law["key"] for law in committed["laws"]} == {law_key}


def test_reused_records_are_written_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    committed = (GENERATED / "audit.json").read_text(encoding="utf-8")
    content = json.loads(committed)
    parts = (content[part] for part in ("equations", "laws", "references", "papers"))
    assert record.format_records(*parts) == committed
    typeset = (GENERATED / "audit_mathml.json").read_text(encoding="utf-8")
    typeset_records = json.loads(typeset)
    evidence = json.loads((GENERATED / "verdicts.json").read_text(encoding="utf-8"))["records"]
    indexed = record.index_records(content["equations"], typeset_records, evidence)
    assert record.format_typeset(indexed.values()) == typeset
    titles = {case.paper.name: case.paper.reference for case in CASES.values()}
    written = verdicts.as_page(content["equations"], titles, content["laws"], content["references"])
    assert written == (GENERATED / "AUDIT.md").read_text(encoding="utf-8")
