"""Papers from anywhere: found by the module that states their case, tried, and an error in them
found.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from derive import papers
from derive.audit import key, verdicts
from derive.audit.case import Case
from derive.audit.paper import Paper
from derive.discovery import import_modules
from derive.equations import ClaimError
from tests.support.centrifuge import NAME, TEXT
from tests.support.made_up import MadeUp


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path
    sys.modules.pop(NAME, None)


def loaded(folder: Path, text: str) -> ModuleType:
    """A user's module, from its file."""
    file = folder / f"{NAME}.py"
    file.write_text(text, encoding="utf-8")
    sys.modules.pop(NAME, None)
    verdicts.load_modules([(NAME, str(file))])
    return sys.modules[NAME]


def test_planted_error_in_external_paper_is_reported(folder: Path) -> None:
    texts = verdicts.judge_cases([loaded(folder, TEXT.replace("WEIGHT", "2"))])
    content = json.loads(texts["audit.json"])
    for line in ("## Made up 2024", "| centrifuge2024 | support is the weight |"):
        assert line in texts["AUDIT.md"]
    assert {r["equation"]: r["verdict"] for r in content["equations"]} == {
        "1": "misprint",
        "2": "confirmed",
    }
    assert content["equations"][0]["correction"] == ["factor 1/2 on 2*g*m"]
    (law,) = content["laws"]
    assert (law["law"], law["caused_by"], law["search"]) == (
        "support is the weight",
        ["1"],
        "exhaustive",
    )
    assert law["violation"] == pytest.approx(2 * 2 * 9.81, rel=1e-3)


def test_the_same_paper_without_the_error_is_confirmed(folder: Path) -> None:
    module = loaded(folder, TEXT.replace("WEIGHT", "1"))
    content = json.loads(verdicts.judge_cases([module])["audit.json"])
    assert {r["verdict"] for r in content["equations"]} == {"confirmed"}
    assert [(law["violation"], law["caused_by"]) for law in content["laws"]] == [(0.0, [])]


def test_external_paper_is_not_judged_twice(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = loaded(folder, TEXT.replace("WEIGHT", "2"))
    texts = verdicts.judge_cases([module])
    for name in texts.keys() - {"AUDIT.md"}:
        (folder / name).write_text(texts[name], encoding="utf-8")
    monkeypatch.setattr(verdicts, "ProcessPoolExecutor", None)
    assert verdicts.judge_cases([module], folder / "audit.json") == texts
    module.PAPER.equations["2"] = module.PAPER.equations["1"]
    with pytest.raises(TypeError):
        verdicts.judge_cases([module], folder / "audit.json")


def test_a_wrong_claim_is_refused_before_anything_is_judged(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = TEXT.replace("WEIGHT", "1").replace(
        'N + N_2, "support of the hub")\nCASE', 'N + N_2, "pull of the hub")\nCASE'
    )
    module = loaded(folder, wrong)
    monkeypatch.setattr(verdicts, "ProcessPoolExecutor", None)
    with pytest.raises(
        ClaimError,
        match=r"centrifuge2024 \(2\): .* 'pull of the hub'; near it: .*'support of the hub'",
    ):
        verdicts.judge_cases([module])


def test_external_law_key_covers_module_and_imports(folder: Path) -> None:
    module = loaded(folder, TEXT.replace("WEIGHT", "1"))
    names = {path.name for path in key.list_sources([NAME])}
    assert names >= {f"{NAME}.py", "paper.py", "chain.py", "quantity.py"}
    assert not names & {"core.py", "sympify.py", "numeric.py"}
    assert key.laws_key(module.CASE, {})


# which papers, in which order


def module(name: str, case: object) -> ModuleType:
    new_module = ModuleType(name)
    new_module.__dict__["CASE"] = case
    return new_module


def case(name: str, place: int | None = None) -> Case:
    return Case(Paper(name, "", place=place), MadeUp({}))


def test_papers_of_the_project_stand_in_their_order() -> None:
    names = [case.paper.name for case in verdicts.find_cases(import_modules(papers)).values()]
    assert names == ["wang2017", "shi2021", "yu2023", "sun2019"]
    assert verdicts.find_cases(reversed(import_modules(papers))) == verdicts.find_cases(
        import_modules(papers)
    )


def test_papers_without_order_come_last_by_name() -> None:
    modules = [
        module("m1", case("zeta")),
        module("m2", case("alpha")),
        module("m3", case("omega", 7)),
    ]
    assert [case.paper.name for case in verdicts.find_cases(modules).values()] == [
        "omega",
        "alpha",
        "zeta",
    ]


def test_modules_without_case_are_ignored() -> None:
    assert verdicts.find_cases([module("m", SimpleNamespace()), ModuleType("n")]) == {}
    assert set(verdicts.judge_cases([])) == {
        "audit.json",
        "audit_mathml.json",
        "verdicts.json",
        "AUDIT.md",
    }


def test_papers_with_equal_names_are_refused() -> None:
    with pytest.raises(ValueError, match="two papers have one name: same"):
        verdicts.find_cases([module("m1", case("same")), module("m2", case("same", 3))])
