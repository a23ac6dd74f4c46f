"""What a record says beside the verdict: the derived side, unexplained terms, terms that vanish."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit import record
from derive.audit.case import Case
from derive.audit.paper import Paper
from derive.audit.record import find_vanishing_terms
from derive.audit.verdicts import as_page
from derive.equations import ClaimError, Definition, Equation, derived_equation
from derive.evaluate import Point
from derive.quantity import Quantity
from tests.support.made_up import (
    MadeUp,
    MadeUpClaim,
    a,
    b,
    c,
    quantity,
    record_equation,
    t,
    u,
    v,
    x,
)
from tests.support.mutations import CASES

push, r = quantity("test_push", "m"), quantity("test_r", "m")
ZERO = {push: "nothing pushes"}


def case(
    printed: Equation,
    meant: sp.Expr,
    lifted: sp.Expr | None = None,
    reading: dict[Quantity, sp.Expr] | None = None,
) -> Case:
    """A paper of one equation, with a derivation, and that derivation while an assumption is
    lifted.
    """
    equations = {
        MadeUpClaim.SUM: derived_equation(MadeUpClaim.SUM, meant, printed.defines, printed.relation)
    }
    paper = Paper("made up", "", {printed.number: printed}, reading=reading or {})
    return Case(paper, MadeUp(equations, lifted, ZERO))


def equation(residual: sp.Expr, defines: Quantity | None = None) -> Equation:
    return Equation("n", residual, "test", MadeUpClaim.SUM, defines=defines)


def recorded(case_: Case) -> dict[str, Any]:
    return record_equation(case_, "n")


def test_derived_side_has_the_printed_form() -> None:
    entry = recorded(case(equation(a - b * u), b * u - a))
    assert (entry["printed"], entry["derived"], entry["defines"]) == (
        f"{a - b * u} = 0",
        f"{a - b * u} = 0",
        "",
    )
    entry = recorded(case(equation(x - b * u, x), x - b * v))
    assert (entry["printed"], entry["derived"], entry["defines"]) == (
        f"{x - b * u} = 0",
        f"{x - b * v} = 0",
        str(x),
    )


def test_a_lost_print_shows_the_derivation_alone() -> None:
    lost = replace(equation(sp.S.Zero), legibility="lost")
    entry = recorded(case(lost, a - b))
    assert (entry["verdict"], entry["printed"], entry["derived"]) == (
        "reconstructed",
        "",
        f"{a - b} = 0",
    )


def test_a_definition_has_no_derived_side() -> None:
    case_ = case(replace(equation(x - a, x), claims=Definition("made up")), x - a)
    entry = recorded(case_)
    assert (entry["verdict"], entry["derived"], entry["terms"]) == ("untested", "", [])


def test_unexplained_terms_have_their_size() -> None:
    case_ = case(equation(a - b * sp.exp(u) * u**3), a - c * sp.log(1 + v))
    (term,) = recorded(case_)["unexplained"]
    largest = max(float(abs(p(b * sp.exp(u) * u**3))) for p in case_.dense_cycle)
    derived = max(float(abs(p(part))) for p in case_.dense_cycle for part in (a, c * sp.log(1 + v)))
    assert term["max_abs"] == pytest.approx(largest, rel=1e-5)
    assert term["share_of_largest"] == pytest.approx(largest / derived, rel=1e-5)
    assert (term["term"], term["unit"]) == (str(-b * sp.exp(u) * u**3), "m")


def test_a_term_without_a_value_has_no_size() -> None:
    case_ = case(equation(a - b * sp.asin(3 + u)), a - c * sp.log(1 + v))
    (term,) = recorded(case_)["unexplained"]
    assert (term["max_abs"], term["share_of_largest"]) == (None, None)
    assert "no real value" in as_page([recorded(case_)], {"made up": ""})


def test_units_are_named_or_composed() -> None:
    assert record.find_unit(a * b / t) == "m2/s"
    assert record.find_unit(a / t**2) == "m/s2"
    assert record.find_unit(1 / t) == "1/s"
    assert record.find_unit(u) == "1"
    assert record.find_unit(quantity("test_force", "N") * a) == "N m"
    assert record.find_unit(a + t) == "?"


# terms that vanish


def test_vanishing_term_names_the_assumption() -> None:
    case_ = case(equation(a - b * u), a - b * u, a - b * u + push * v - 2 * push)
    entry = recorded(case_)
    assert entry["verdict"] == "confirmed"
    assert entry["vanishing"] == [
        {"term": text, "because": f"{push} = 0: nothing pushes", "printed": False}
        for text in (str(-2 * push), str(push * v))
    ]
    assert "nothing pushes" in as_page([entry], {"made up": ""})


def test_vanishing_printed_term_is_not_an_error() -> None:
    case_ = case(equation(a - b * u + push * v), a - b * u, a - b * u + push * v)
    entry = recorded(case_)
    assert entry["verdict"] == "confirmed"
    assert [(v["term"], v["printed"]) for v in entry["vanishing"]] == [(str(push * v), True)]
    case_ = case(equation(a - b * u + push * u), a - b * u, a - b * u + push * v)
    assert [(v["term"], v["printed"]) for v in recorded(case_)["vanishing"]] == [
        (str(push * v), False),
        (str(push * u), True),
    ]


def test_printed_term_remains_without_lifted_derivation() -> None:
    entry = recorded(case(equation(a - b * u + push * v), a - b * u))
    assert entry["verdict"] == "not judged"
    assert f"{push} has no value" in entry["finding"]


def test_cancelling_terms_do_not_vanish_by_assumption() -> None:
    pair = c * push * sp.cos(u) ** 2 + c * push * sp.sin(u) ** 2 - c * push
    case_ = case(equation(a - b), a - b, a - b + pair + v * push)
    assert [v["term"] for v in recorded(case_)["vanishing"]] == [str(v * push)]


def test_cancelling_printed_terms_are_named() -> None:
    case_ = case(equation(x - a - r, x), x - b, reading={r: b - a})
    entry = recorded(case_)
    assert entry["verdict"] == "confirmed"
    assert entry["vanishing"] == [
        {"term": str(-a), "because": f"{r} read as {b - a}", "printed": True}
    ]
    assert recorded(case(equation(x - a - r, x), x - b - a, reading={r: b}))["vanishing"] == []


@pytest.mark.parametrize("name", CASES)
def test_relaxed_derivations_reduce_to_the_derivations(name: str) -> None:
    case_ = CASES[name]
    for number in case_.paper.equations:
        general, (_, derived) = case_.lifted(number), case_.pair(number)
        if general is not None and derived is not None:
            assumed = general.residual.xreplace(dict.fromkeys(case_.subject.zero(), sp.S.Zero))
            assert sp.expand(assumed - derived.residual) == 0, number


def test_constant_carrier_speed_removes_terms() -> None:
    """By hand: a body that turns with the carrier and is hinged to it has m r phi'' and J phi''
    more.
    """
    case_ = CASES["wang2017"]
    vanished = {
        n: {str(v.term) for v in find_vanishing_terms(case_, n) if "phi_ddot = 0" in v.because}
        for n in case_.paper.equations
    }
    assert vanished["12"] == {"m2*phi_ddot*y_CA", "-m2*phi_ddot*y_A1"}
    assert vanished["13"] == {"-m2*phi_ddot*x_CA", "m2*phi_ddot*x_A1"}
    assert vanished["14"] == {"-J_56*phi_ddot"}
    assert "-J_4*phi_ddot" in vanished["28"]
    assert vanished["9"] == vanished["10"] == vanished["11"] == set()


def test_relaxed_balance_includes_carrier_acceleration() -> None:
    """About its own shaft the middle body resists with its moment of inertia, wherever its centroid
    lies.
    """
    case_ = CASES["wang2017"]
    general = case_.lifted("14")
    assert general is not None
    phi_ddot = next(s for s in case_.subject.zero() if s.name == "phi_ddot")
    slope = sp.expand(general.residual).diff(phi_ddot)
    for point in case_.points:
        J_56 = next(s for s in general.residual.free_symbols if s.name == "J_56")
        assert abs(point(slope) + point(J_56)) < 1e-40


@pytest.mark.parametrize("name", CASES)
def test_unjudged_verdicts_have_a_reason(name: str) -> None:
    """What a definition defines is defined nowhere else, in print or by derivation; what is lost,
    is derived.
    """
    case_ = CASES[name]
    for number, printed in case_.paper.equations.items():
        _, derived = case_.pair(number)
        elsewhere = {e.defines for n, e in case_.paper.equations.items() if n != number}
        elsewhere |= {e.defines for e in case_.claims.values()}
        if derived is None:
            defined = {printed.defines} if printed.defines else printed.residual.free_symbols
            assert defined - elsewhere, number
        assert printed.legibility != "lost" or derived is not None, number


def test_seeded_points_are_the_same_again() -> None:
    case_ = CASES["shi2021"]
    again = Point(case_.subject.admissible(random.Random(1)))
    assert again.values() == case_.points[0].values()


# what a paper claims must be what its subject derives


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
