"""An equation, a reading, a law or a number that cannot be judged costs one line: the rest is
judged all the same.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy as sp

from derive.audit import key, record, verdicts
from derive.audit.case import Case
from derive.audit.paper import Cycle, Dynamics, Law, Paper, Reading
from derive.chain import Chain
from derive.equations import derived_equation
from tests.support.made_up import (
    MadeUp,
    MadeUpClaim,
    a,
    b,
    c,
    judge_number,
    judge_readings,
    list_verdicts,
    u,
    x,
)

ODD = sp.Function("odd")


def made_up() -> Case:
    """A case with a sum ``x = a u`` that is derived, and nothing printed yet."""
    return Case(
        Paper("made up", "A made-up paper"),
        MadeUp({MadeUpClaim.SUM: derived_equation(MadeUpClaim.SUM, x - a * u, x)}),
    )


def audit(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> tuple[dict[str, record.Record], list[record.Record]]:
    """Records of all equations by number and of the laws, judged in this process."""
    module = ModuleType("made_up_case")
    module.__file__ = "made_up_case.py"
    module.CASE = case  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)

    class Here:
        def __enter__(self) -> Here:
            return self

        def __exit__(self, *_: object) -> None:
            return None

        map = staticmethod(map)

        @staticmethod
        def submit(function: Any, *arguments: Any) -> Any:
            result = function(*arguments)
            return type("Done", (), {"result": staticmethod(lambda: result)})

    monkeypatch.setattr(verdicts, "ProcessPoolExecutor", lambda **_: Here())
    monkeypatch.setattr(key, "laws_key", lambda *_: "of laws")
    records, laws = verdicts.judge_modules([module], {}, [])
    return {entry["equation"]: entry for entry in records}, laws


def test_bad_equation_adds_a_single_line(monkeypatch: pytest.MonkeyPatch) -> None:
    case = made_up()
    unknown = case.paper.symbol("Z_1", "m", "a length that nothing explains")
    case.paper.defines("right", x, a * u, MadeUpClaim.SUM)
    case.paper.defines("unknown", x, a * u + unknown, MadeUpClaim.SUM)
    case.paper.defines("odd", x, ODD(a) * u, MadeUpClaim.SUM)
    case.paper.equation("odd, unclaimed", x - ODD(a))
    case.paper.defines("wrong", x, a * u + 3 * b + 7 * c)
    case.paper.defines("wrong and claimed", x, 2 * a * u, MadeUpClaim.SUM)
    records, _ = audit(case, monkeypatch)
    assert {number: entry["verdict"] for number, entry in records.items()} == {
        "right": "confirmed",
        "unknown": "not judged",
        "odd": "not judged",
        "odd, unclaimed": "not judged",
        "wrong": "contradicted",
        "wrong and claimed": "misprint",
    }
    assert "Z_1" in records["unknown"]["finding"]
    assert "odd" in records["odd"]["finding"]
    assert records["wrong"]["reasons"] == ["(wrong) does not hold"]
    text = verdicts.as_page(list(records.values()), {"made up": "A made-up paper"})
    assert "3 not judged" in text
    assert "### (odd) not judged" in text
    for entry in records.values():
        assert entry.keys() == records["right"].keys()
        assert entry["mathml"].keys() == records["right"]["mathml"].keys()


def test_unreadable_interpretation_is_the_least_kind() -> None:
    case = made_up()
    case.paper.defines("1", x, b * u, MadeUpClaim.SUM)
    case.paper.admits(["1"], Reading("b is odd", {b: ODD(a)}), Reading("b is twice a", {b: 2 * a}))
    outcome = judge_readings(case, "1")
    assert list_verdicts(outcome) == [
        "not judged",
        "misprint",
    ]
    assert outcome.kindest.judgement.verdict == "misprint"


def test_subject_without_values_is_still_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    case = made_up()
    case.paper.defines("1", x, a * u, MadeUpClaim.SUM)

    def admissible(*_: object) -> None:
        raise ValueError("its loops close nowhere")

    monkeypatch.setattr(MadeUp, "admissible", admissible)
    with pytest.raises(ValueError, match="close nowhere"):
        audit(case, monkeypatch)


def test_defined_symbol_may_be_mapped() -> None:
    case = made_up()
    foreign = case.paper.symbol("X_1", "m", "what the paper calls x")
    case.paper.defines("1", foreign, a * u, MadeUpClaim.SUM)
    case.paper.defines("2", foreign, -a * u, MadeUpClaim.SUM)
    case.paper.defines("half", foreign, a * u / 2, MadeUpClaim.SUM)
    case.paper.defines("reversed", foreign, -a * u, MadeUpClaim.SUM)
    case.paper.reads({foreign: x}, "1", "2")
    case.paper.reads({foreign: x / 2}, "half")
    case.paper.reads({foreign: -x}, "reversed")
    judgements = {number: judge_number(case, number) for number in case.paper.equations}
    assert {number: judgement.verdict for number, judgement in judgements.items()} == {
        "1": "confirmed",
        "2": "misprint",
        "half": "confirmed",
        "reversed": "confirmed",
    }
    assert judgements["2"].corrections


def test_untestable_law_adds_a_single_line(monkeypatch: pytest.MonkeyPatch) -> None:
    case = made_up()
    case.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    cycle = Cycle(({a: np.ones(3)},), np.ones(3))
    dynamics = Dynamics((Law("a law of nothing", "N", (ODD(a),)),), {"reference": cycle}, {}, ())
    monkeypatch.setattr(MadeUp, "dynamics", lambda _: dynamics)
    records, (law,) = audit(replace(case, chains=(Chain({}, []), Chain({}, []))), monkeypatch)
    assert records["1"]["verdict"] == "confirmed"
    assert (law["violation"], law["search"], law["caused_by"]) == (None, "not judged", [])
    assert law["owed"]
    assert "unknown" in verdicts.as_page(list(records.values()), {"made up": ""}, [law])
