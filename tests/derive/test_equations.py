"""Claims are values: what is misspelt, made twice or not at all raises with a sentence."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from derive import papers
from derive.discovery import import_modules
from derive.equations import (
    Balance,
    Claim,
    Claimed,
    ClaimError,
    ClaimOf,
    Definition,
    Equation,
    by_claim,
    defining_equation,
    derived_equation,
    find_claim,
)
from derive.systems.clutch.quantities import ClutchClaim
from derive.systems.mapping.quantities import MappingClaim
from derive.systems.pickup.quantities import PickupClaim
from derive.systems.planting.quantities import PlantingClaim
from tests.support.made_up import MadeUpClaim, a, b, c

VOCABULARIES: list[type[Claim]] = [ClutchClaim, MappingClaim, PickupClaim, PlantingClaim]


def test_claims_are_said_by_their_sentences() -> None:
    assert str(ClutchClaim.HEXAGON_SIDE) == "side of the hexagon that fits the polygon's width"
    assert str(MadeUpClaim.SHARE.of(a)) == f"made-up share {a}"
    assert str(Definition("gear ratio")) == "definition: gear ratio"
    assert (
        str(Balance("sun", "moment", "z", "frame", "O")) == "sun: moment along z of frame about O"
    )


def test_claims_are_equal_by_value() -> None:
    assert PlantingClaim.NORMAL_FORCE.of("P") == ClaimOf(PlantingClaim.NORMAL_FORCE, ("P",))
    assert PlantingClaim.NORMAL_FORCE.of("P") != PlantingClaim.NORMAL_FORCE.of("Q")
    assert len({MadeUpClaim.SHARE.of(a), MadeUpClaim.SHARE.of(a), MadeUpClaim.SHARE.of(b)}) == 2


@pytest.mark.parametrize("vocabulary", VOCABULARIES)
def test_a_misspelt_member_raises(vocabulary: type[Claim]) -> None:
    for name in vocabulary.__members__:
        with pytest.raises(AttributeError):
            getattr(vocabulary, f"{name}E")


@pytest.mark.parametrize("vocabulary", VOCABULARIES)
def test_no_two_members_say_the_same(vocabulary: type[Claim]) -> None:
    assert len(vocabulary.__members__) == len(list(vocabulary))


@pytest.mark.parametrize("things", [(), ("P",), ("P", "x", "y")])
def test_claim_family_checks_number_of_arguments(things: tuple[str, ...]) -> None:
    with pytest.raises(
        ClaimError, match=f"'tooth force at {{}}, {{}}' has gaps for 2, not for {len(things)}"
    ):
        PlantingClaim.TOOTH_FORCE.of(*things)
    assert str(PlantingClaim.TOOTH_FORCE.of("P", "x")) == "tooth force at P, x"


KNOWN: dict[Claimed, int] = {
    MadeUpClaim.SUM: 1,
    MadeUpClaim.SHARE.of(a): 2,
    Balance("sun", "force", "x", "frame"): 3,
}


def test_among_returns_value_of_a_claim() -> None:
    assert [find_claim(KNOWN, claim) for claim in KNOWN] == [1, 2, 3]


def test_unknown_claim_error_suggests_near_claims() -> None:
    message = (
        f"nothing here states ClaimOf 'made-up share {b}'; near it: .*ClaimOf 'made-up share {a}'"
    )
    with pytest.raises(ClaimError, match=message):
        find_claim(KNOWN, MadeUpClaim.SHARE.of(b))
    with pytest.raises(ClaimError, match="near it: Balance 'sun: force along x of frame'"):
        find_claim(KNOWN, Balance("sun", "force", "y", "frame"))
    with pytest.raises(ClaimError, match=r"^nothing here states Definition 'definition: zzz'$"):
        find_claim({}, Definition("zzz"))


def test_sentences_and_families_are_not_claims() -> None:
    sentence: object = "made-up sum"
    with pytest.raises(
        ClaimError,
        match="nothing here states str 'made-up sum'; near it: MadeUpClaim 'made-up sum'",
    ):
        find_claim(KNOWN, sentence)  # type: ignore[arg-type]
    with pytest.raises(ClaimError, match=r"MadeUpClaim 'made-up share \{\}'"):
        find_claim(KNOWN, MadeUpClaim.SHARE)


def test_duplicate_claims_raise() -> None:
    first, other = (
        defining_equation(MadeUpClaim.SUM, a, b + c),
        derived_equation(MadeUpClaim.SHARE.of(a), a - c, relation="<"),
    )
    assert by_claim([first, other]) == {MadeUpClaim.SUM: first, MadeUpClaim.SHARE.of(a): other}
    with pytest.raises(ClaimError, match="elsewhere claim the same: made-up sum"):
        by_claim([first, other, replace(first, source="elsewhere")])


def test_derived_equation_is_numbered_by_the_claim() -> None:
    equation = defining_equation(MadeUpClaim.SUM, a, b + c)
    assert equation == Equation(
        "made-up sum", a - b - c, "derived: made-up sum", MadeUpClaim.SUM, defines=a, relation="="
    )
    assert derived_equation(MadeUpClaim.SUM, sp.S.Zero, relation=">").relation == ">"


@pytest.mark.parametrize("module", import_modules(papers), ids=lambda m: m.PAPER.name)
def test_every_equation_of_a_paper_claims_a_value(module: object) -> None:
    equations: list[Equation] = list(module.PAPER.equations.values())  # type: ignore[attr-defined]
    assert all(isinstance(e.claims, Balance | Claim | ClaimOf | Definition) for e in equations)
