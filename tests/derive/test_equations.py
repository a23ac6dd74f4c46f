"""Claims are values: what is misspelt, made twice or not at all raises with a sentence."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from derive import papers
from derive.audit.paper import Paper
from derive.discovery import import_modules, list_offers
from derive.equations import (
    Balance,
    Claimed,
    ClaimError,
    Definition,
    Equation,
    by_claim,
    defining_equation,
    derived_equation,
    find_claim,
)
from tests.support.made_up import MadeUpClaim, a, b, c


def test_claims_are_said_by_their_sentences() -> None:
    assert str(Definition("gear ratio")) == "definition: gear ratio"
    assert (
        str(Balance("sun", "moment", "z", "frame", "O")) == "sun: moment along z of frame about O"
    )


KNOWN: dict[Claimed, int] = {
    MadeUpClaim.SUM: 1,
    MadeUpClaim.SHARE.format(a): 2,
    Balance("sun", "force", "x", "frame"): 3,
}


def test_among_returns_value_of_a_claim() -> None:
    assert [find_claim(KNOWN, claim) for claim in KNOWN] == [1, 2, 3]


def test_unknown_claim_error_suggests_near_claims() -> None:
    message = f"nothing here states 'made-up share {b}'; near it: .*'made-up share {a}'"
    with pytest.raises(ClaimError, match=message):
        find_claim(KNOWN, MadeUpClaim.SHARE.format(b))
    with pytest.raises(ClaimError, match="near it: 'sun: force along x of frame'"):
        find_claim(KNOWN, Balance("sun", "force", "y", "frame"))
    with pytest.raises(ClaimError, match=r"^nothing here states 'definition: zzz'$"):
        find_claim({}, Definition("zzz"))


def test_duplicate_claims_raise() -> None:
    first, other = (
        defining_equation(MadeUpClaim.SUM, a, b + c),
        derived_equation(MadeUpClaim.SHARE.format(a), a - c, relation="<"),
    )
    assert by_claim([first, other]) == {MadeUpClaim.SUM: first, MadeUpClaim.SHARE.format(a): other}
    with pytest.raises(ClaimError, match="elsewhere claim the same: made-up sum"):
        by_claim([first, other, replace(first, source="elsewhere")])


def test_derived_equation_is_numbered_by_the_claim() -> None:
    equation = defining_equation(MadeUpClaim.SUM, a, b + c)
    assert equation == Equation(
        "made-up sum", a - b - c, "derived: made-up sum", MadeUpClaim.SUM, defines=a, relation="="
    )
    assert derived_equation(MadeUpClaim.SUM, sp.S.Zero, relation=">").relation == ">"


@pytest.mark.parametrize(
    "paper", list_offers(import_modules(papers), "PAPER"), ids=lambda p: p.name
)
def test_every_equation_of_a_paper_claims_a_value(paper: Paper) -> None:
    claims = [equation.claims for equation in paper.equations.values()]
    assert all(isinstance(claim, Balance | Definition | str) for claim in claims)
