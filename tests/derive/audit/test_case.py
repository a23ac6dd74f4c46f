"""A paper on trial: what it claims must be what its subject derives."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest

from derive.audit.case import Case
from derive.audit.paper import Paper
from derive.equations import ClaimError, Definition
from tests.support.made_up import MadeUpClaim, a, b
from tests.support.mutations import CASES


def judged(case: Case) -> str:
    """Number of an equation that is held against its derivation."""
    return next(n for n, e in case.paper.equations.items() if not isinstance(e.claims, Definition))


def claiming(case: Case, number: str, claim: Any) -> Case:
    equations = {
        **case.paper.equations,
        number: replace(case.paper.equations[number], claims=claim),
    }
    return replace(case, paper=replace(case.paper, equations=equations))


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_claim_in_a_paper_raises(name: str) -> None:
    case_ = CASES[name]
    number = judged(case_)
    wrong = re.escape(f"{name} ({number}): nothing here states 'made-up sum that nothing derives'")
    with pytest.raises(ClaimError, match=wrong):
        claiming(case_, number, MadeUpClaim.NOWHERE).pair(number)
    assert claiming(case_, number, case_.paper.equations[number].claims).pair(number) == case_.pair(
        number
    )


@pytest.mark.parametrize("name", CASES)
def test_every_claim_of_a_paper_is_derived(name: str) -> None:
    case_ = CASES[name]
    for number, printed in case_.paper.equations.items():
        assert (case_.pair(number)[1] is None) is isinstance(printed.claims, Definition), number


def test_reading_of_absent_equation_is_refused() -> None:
    paper = Paper("made up", "")
    paper.equation("1", a - b, MadeUpClaim.SUM)
    paper.reads({a: b}, "1")
    paper.reads({b: a})
    assert (paper.reading, paper.readings) == ({b: a}, {"1": {a: b}})
    with pytest.raises(ValueError, match="made up has no equation 2 to read"):
        paper.reads({a: b}, "1", "2")
