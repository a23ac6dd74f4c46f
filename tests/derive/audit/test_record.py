"""What a record says beside the verdict: the derived side, unexplained terms, terms that vanish."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit import key, record
from derive.audit.case import Case
from derive.audit.paper import Paper
from derive.audit.record import find_vanishing_terms
from derive.audit.verdicts import as_page
from derive.equations import Definition, Equation, derived
from derive.evaluate import Point
from derive.quantity import Quantity
from tests.support.made_up import MadeUp, MadeUpClaim, a, b, c, quantity, t, u, v, x
from tests.support.mutations import CASES

push, r = quantity("test_push", "m"), quantity("test_r", "m")
ZERO = {push: "nothing pushes"}


def case(
    printed: Equation, meant: sp.Expr, lifted: sp.Expr | None = None, reading: dict[Quantity, sp.Expr] | None = None
) -> Case:
    """A paper of one equation, with a derivation, and that derivation while an assumption is lifted."""
    equations = {MadeUpClaim.SUM: derived(MadeUpClaim.SUM, meant, printed.defines, printed.relation)}
    paper = Paper("made up", "", {printed.number: printed}, reading=reading or {})
    return Case(paper, MadeUp(equations, lifted, ZERO))


def equation(residual: sp.Expr, defines: Quantity | None = None) -> Equation:
    return Equation("n", residual, "test", MadeUpClaim.SUM, defines=defines)


def recorded(own: Case) -> dict[str, Any]:
    return record.equation(own, "n", "key")


def test_points_differ() -> None:
    points = case(equation(a - b), a - b).points
    assert len({point.digits(a) for point in points}) == len(points) > 1


def test_the_derived_side_stands_as_the_printed_one_does() -> None:
    found = recorded(case(equation(a - b * u), b * u - a))
    assert (found["printed"], found["derived"], found["defines"]) == (f"{a - b * u} = 0", f"{a - b * u} = 0", "")
    found = recorded(case(equation(x - b * u, x), x - b * v))
    assert (found["printed"], found["derived"], found["defines"]) == (f"{x - b * u} = 0", f"{x - b * v} = 0", str(x))


def test_a_key_knows_what_actions_of_its_equation_are_called_and_no_others() -> None:
    def keyed(called: str, elsewhere: str) -> str:
        class Acting(MadeUp):
            def actions(self) -> dict[sp.Symbol, str]:
                return {a: called, t: elsewhere}

        own = case(equation(a - b), a - b)
        return key.equation_key(Case(own.paper, Acting({MadeUpClaim.SUM: derived(MadeUpClaim.SUM, a - b)})), "n")

    assert keyed("push", "pull") == keyed("push", "drag") != keyed("shove", "pull")


def test_a_lost_print_shows_the_derivation_alone() -> None:
    lost = replace(equation(sp.S.Zero), legibility="lost")
    found = recorded(case(lost, a - b))
    assert (found["verdict"], found["printed"], found["derived"]) == ("reconstructed", "", f"{a - b} = 0")


def test_a_definition_has_no_derived_side() -> None:
    own = case(replace(equation(x - a, x), claims=Definition("made up")), x - a)
    found = recorded(own)
    assert (found["verdict"], found["derived"], found["terms"]) == ("untested", "", [])


def test_unexplained_terms_have_their_size() -> None:
    own = case(equation(a - b * sp.exp(u) * u**3), a - c * sp.log(1 + v))
    (term,) = recorded(own)["unexplained"]
    largest = max(float(abs(p(b * sp.exp(u) * u**3))) for p in own.cycle)
    derived = max(float(abs(p(part))) for p in own.cycle for part in (a, c * sp.log(1 + v)))
    assert term["max_abs"] == pytest.approx(largest, rel=1e-5)
    assert term["share_of_largest"] == pytest.approx(largest / derived, rel=1e-5)
    assert (term["term"], term["unit"]) == (str(-b * sp.exp(u) * u**3), "m")


def test_a_term_without_a_value_has_no_size() -> None:
    own = case(equation(a - b * sp.asin(3 + u)), a - c * sp.log(1 + v))
    (term,) = recorded(own)["unexplained"]
    assert (term["max_abs"], term["share_of_largest"]) == (None, None)
    assert "no real value" in as_page([recorded(own)], {"made up": ""})


def test_units_are_named_or_composed() -> None:
    assert record.unit_of(a * b / t) == "m2/s"
    assert record.unit_of(a / t**2) == "m/s2"
    assert record.unit_of(1 / t) == "1/s"
    assert record.unit_of(u) == "1"
    assert record.unit_of(quantity("test_force", "N") * a) == "N m"
    assert record.unit_of(a + t) == "?"


# terms that vanish


def test_a_term_that_an_assumption_makes_vanish_is_named() -> None:
    own = case(equation(a - b * u), a - b * u, a - b * u + push * v - 2 * push)
    found = recorded(own)
    assert found["verdict"] == "confirmed"
    assert found["vanishing"] == [
        {"term": text, "because": f"{push} = 0: nothing pushes", "printed": False}
        for text in (str(-2 * push), str(push * v))
    ]
    assert "nothing pushes" in as_page([found], {"made up": ""})


def test_a_printed_term_that_an_assumption_makes_vanish_is_named_and_no_error() -> None:
    own = case(equation(a - b * u + push * v), a - b * u, a - b * u + push * v)
    found = recorded(own)
    assert found["verdict"] == "confirmed"
    assert [(v["term"], v["printed"]) for v in found["vanishing"]] == [(str(push * v), True)]
    own = case(equation(a - b * u + push * u), a - b * u, a - b * u + push * v)
    assert [(v["term"], v["printed"]) for v in recorded(own)["vanishing"]] == [
        (str(push * v), False),
        (str(push * u), True),
    ]


def test_printed_term_remains_without_lifted_derivation() -> None:
    found = recorded(case(equation(a - b * u + push * v), a - b * u))
    assert found["verdict"] == "not judged"
    assert f"{push} has no value" in found["finding"]


def test_terms_that_cancel_with_the_assumption_lifted_do_not_vanish_by_it() -> None:
    pair = c * push * sp.cos(u) ** 2 + c * push * sp.sin(u) ** 2 - c * push
    own = case(equation(a - b), a - b, a - b + pair + v * push)
    assert [v["term"] for v in recorded(own)["vanishing"]] == [str(v * push)]


def test_printed_terms_that_cancel_as_they_are_read_are_named() -> None:
    own = case(equation(x - a - r, x), x - b, reading={r: b - a})
    found = recorded(own)
    assert found["verdict"] == "confirmed"
    assert found["vanishing"] == [{"term": str(-a), "because": f"{r} read as {b - a}", "printed": True}]
    assert recorded(case(equation(x - a - r, x), x - b - a, reading={r: b}))["vanishing"] == []


@pytest.mark.parametrize("name", CASES)
def test_lifted_derivations_become_the_derivations_under_their_assumptions(name: str) -> None:
    own = CASES[name]
    for number in own.paper.equations:
        kept, (_, derived) = own.lifted(number), own.pair(number)
        if kept is not None and derived is not None:
            assumed = kept.residual.xreplace(dict.fromkeys(own.subject.zero(), sp.S.Zero))
            assert sp.expand(assumed - derived.residual) == 0, number


def test_the_planting_device_loses_terms_by_constant_carrier_speed() -> None:
    """By hand: a body that turns with the carrier and is hinged to it has m r phi'' and J phi'' more."""
    own = CASES["wang2017"]
    found = {
        n: {str(v.term) for v in find_vanishing_terms(own, n) if "phi_ddot = 0" in v.because}
        for n in own.paper.equations
    }
    assert found["12"] == {"m2*phi_ddot*y_CA", "-m2*phi_ddot*y_A1"}
    assert found["13"] == {"-m2*phi_ddot*x_CA", "m2*phi_ddot*x_A1"}
    assert found["14"] == {"-J_56*phi_ddot"}
    assert "-J_4*phi_ddot" in found["28"]
    assert found["9"] == found["10"] == found["11"] == set()


def test_the_lifted_balance_is_that_of_a_carrier_that_speeds_up() -> None:
    """About its own shaft the middle body resists with its moment of inertia, wherever its centroid lies."""
    own = CASES["wang2017"]
    kept = own.lifted("14")
    assert kept is not None
    phi_ddot = next(s for s in own.subject.zero() if s.name == "phi_ddot")
    slope = sp.expand(kept.residual).diff(phi_ddot)
    for point in own.points:
        J_56 = next(s for s in kept.residual.free_symbols if s.name == "J_56")
        assert abs(point(slope) + point(J_56)) < 1e-40


def test_every_record_has_its_keys() -> None:
    keys = {"paper", "equation", "legibility", "claims", "verdict", "finding", "correction", "reading", "terms",
            "unexplained", "vanishing", "printed", "derived", "defines", "key", "mathml", "rebuilt", "fragile",
            "depends", "robust", "reasons", "answer", "domain"}  # fmt: skip
    assert recorded(case(equation(a - b), a - b)).keys() == keys


@pytest.mark.parametrize("name", CASES)
def test_verdicts_that_are_no_judgement_have_their_reason(name: str) -> None:
    """What a definition defines is defined nowhere else, in print or by derivation; what is lost, is derived."""
    own = CASES[name]
    for number, printed in own.paper.equations.items():
        _, derived = own.pair(number)
        elsewhere = {e.defines for n, e in own.paper.equations.items() if n != number}
        elsewhere |= {e.defines for e in own.claims.values()}
        if derived is None:
            defined = {printed.defines} if printed.defines else printed.residual.free_symbols
            assert defined - elsewhere, number
        assert printed.legibility != "lost" or derived is not None, number


def test_seeded_points_are_the_same_again() -> None:
    own = CASES["shi2021"]
    again = Point(own.subject.admissible(random.Random(1)))
    assert again.values() == own.points[0].values()
