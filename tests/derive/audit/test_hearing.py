"""What a verdict hangs on: readings, single characters, completed pieces, witnesses, causes, references."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit.case import Case
from derive.audit.causes import causes, told
from derive.audit.fold import folded
from derive.audit.hearing import Outcome, heard, is_fragile, reasons
from derive.audit.judge import judge
from derive.audit.judgement import Judgement
from derive.audit.paper import Paper, Reading
from derive.audit.record import equation as recorded
from derive.audit.references import references
from derive.audit.subject import Subject
from derive.equations import Definition, Equation, derived, stated
from tests.support.made_up import POINTS, WORDS, MadeUp, MadeUpClaim, a, b, c, d, judged, t, u, v, x, x_dot
from tests.support.mutations import CASES


def case(meant: Equation, subject: type[MadeUp] = MadeUp) -> Case:
    return Case(Paper("made up", ""), subject({MadeUpClaim.SUM: meant}))


def outcome(own: Case) -> Outcome:
    return heard(own, "1")


# readings


def open_case(printed: sp.Expr, *readings: Reading) -> Case:
    own = case(derived(MadeUpClaim.SUM, x - a * u, x))
    own.paper.defines("1", x, printed, MadeUpClaim.SUM)
    own.paper.admits(["1"], *readings)
    return own


def test_the_kindest_reading_decides_and_all_are_shown() -> None:
    found = outcome(open_case(b * u, Reading("b is a width"), Reading("b is the length a", {b: a})))
    assert found.kindest.judgement.verdict == "confirmed"
    assert found.kindest.choice.meaning == "b is the length a"
    assert [h.judgement.verdict for h in found.every] == ["misprint", "confirmed"]
    assert not found.robust


def test_a_verdict_is_robust_where_all_readings_give_it() -> None:
    found = outcome(open_case(b * u, Reading("b is a width"), Reading("b is twice a", {b: 2 * a})))
    assert [h.judgement.verdict for h in found.every] == ["misprint", "misprint"]
    assert found.robust


def test_a_reading_may_be_of_the_derivation_or_of_the_text() -> None:
    derivation = outcome(open_case(b * u, Reading("as derived"), Reading("another mechanism", derived={a: b})))
    assert [h.judgement.verdict for h in derivation.every] == ["misprint", "confirmed"]
    text = outcome(open_case(b * u, Reading("as read"), Reading("read otherwise", text=x - a * u)))
    assert [h.judgement.verdict for h in text.every] == ["misprint", "confirmed"]


def test_two_questions_have_every_pair_of_answers() -> None:
    own = open_case(b * v, Reading("b"), Reading("b is a", {b: a}))
    own.paper.admits(["1"], Reading("v"), Reading("v is u", {v: u}))
    found = outcome(own)
    assert len(found.every) == 4
    assert found.kindest.choice.meaning == "b is a; v is u"


def test_the_papers_open_questions_and_what_depends_on_them() -> None:
    for name, numbers in {"shi2021": {"B1", "B2", "12"}, "wang2017": {"x_E", "z_E"}, "sun2019": {"d1", "d2"}}.items():
        assert {n for n in numbers if not heard(CASES[name], n).robust} == numbers, name
    assert heard(CASES["yu2023"], "W1").robust


# a single character, pieces completed, definitions


@pytest.mark.parametrize(
    ("printed", "meant", "fragile"),
    [
        (a * u - b, a * v - b, True),
        (a / t - x, a / t - x_dot, False),
        (a * u - b * v, a * u + b * v, False),
        (2 * a - b + c, a - b + c, False),
    ],
)
def test_a_finding_hangs_on_one_character(printed: sp.Expr, meant: sp.Expr, fragile: bool) -> None:
    assert is_fragile(judged(printed, meant)) is fragile


@pytest.mark.long
def test_dots_and_indices_of_the_papers_are_single_characters() -> None:
    found = {(n, e) for n, numbers in {"wang2017": ("7", "18"), "shi2021": ("9", "8b")}.items() for e in numbers}
    assert all(is_fragile(heard(CASES[name], number).kindest.judgement) for name, number in found)
    others = (("wang2017", "P1"), ("shi2021", "Y_C"))
    assert not any(is_fragile(heard(CASES[name], number).kindest.judgement) for name, number in others)


def test_what_was_completed_is_confirmed_as_rebuilt() -> None:
    own = case(derived(MadeUpClaim.SUM, x - a * u, x))
    own.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    assert outcome(own).kindest.judgement.verdict == "confirmed"
    own.paper.rebuilds("1", "the factor u")
    assert outcome(own).kindest.judgement.verdict == "confirmed as rebuilt"


def test_what_is_stated_is_not_tested_by_itself_but_an_error_in_it_is_told() -> None:
    own = case(stated(MadeUpClaim.SUM, x - a * u, x))
    own.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    assert outcome(own).kindest.judgement.verdict == "untested"
    own.paper.equations["1"] = replace(own.paper.equations["1"], residual=x - b * u)
    assert outcome(own).kindest.judgement.verdict == "misprint"


def definition(factor: sp.Expr, **values: str) -> str:
    paper = Paper("made up", "")
    paper.defines("1", x, factor * a, Definition("made up"))
    if values:
        paper.shows("1", "a table", **values)
    return judge(paper.equations["1"], None, POINTS, WORDS).verdict


def test_a_definition_is_tested_by_printed_values() -> None:
    tenth = sp.Rational(1, 10)
    assert definition(6 * tenth) == "untested"
    assert definition(6 * tenth, testx="1.81", test_a="3.02") == "definition"
    assert definition(7 * tenth, testx="1.81", test_a="3.02") == "contradicted"
    assert definition(6 * tenth, testx="1.82", test_a="3.02") == "contradicted"
    with pytest.raises(ValueError, match="a table prints nothing of test_a"):
        definition(6 * tenth, testx="1.81")


@pytest.mark.parametrize(("name", "number"), [("wang2017", "29"), ("wang2017", "31"), ("shi2021", "k")])
def test_a_changed_number_in_a_definition_is_noticed(name: str, number: str) -> None:
    printed = CASES[name].paper.equations[number]
    assert judge(printed, None, POINTS, WORDS).verdict == "definition"
    for term in sp.Add.make_args(sp.expand(printed.residual - (printed.defines or 0))):
        wrong = replace(printed, residual=printed.residual + term / 6)
        assert judge(wrong, None, POINTS, WORDS).verdict == "contradicted", term


# where a thing is held


class Held(MadeUp):
    def held(self, claim: Any, said: sp.Expr) -> dict[str, sp.Expr]:
        return {"slope at the wall": said.diff(u).subs(u, 0)}


def test_what_must_vanish_where_a_thing_is_held() -> None:
    for shape, verdict in ((sp.sin(u), "contradicted"), (1 - sp.cos(u), "confirmed")):
        own = case(derived(MadeUpClaim.SUM, x - a * shape, x), Held)
        own.paper.defines("1", x, a * shape, MadeUpClaim.SUM)
        found = outcome(own).kindest.judgement
        assert found.verdict == verdict
        assert found.loose == (("slope at the wall",) if verdict == "contradicted" else ())


def test_the_assumed_shape_of_the_shaft_turns_in_its_bearing() -> None:
    for number in ("9", "10"):
        assert heard(CASES["shi2021"], number).kindest.judgement.loose == ("slope at the bearing",)
    assert heard(CASES["shi2021"], "start").kindest.judgement.verdict == "contradicted"


def test_what_lacks_a_term_without_a_force_lacks_the_first_of_them() -> None:
    found = Judgement("incomplete", "", missing=(a * u, b))
    printed = derived(MadeUpClaim.SUM, c - b)
    assert reasons(found, printed, {}) == (f"lacks {a * u}",)


def test_the_record_shows_what_each_reading_leaves() -> None:
    own = open_case(a * u, Reading("as derived"), Reading("two terms more", derived={a: a + b + c * sp.sin(v)}))
    first, second = recorded(own, "1", "key")["depends"]
    assert (first["verdict"], first["finding"]) == ("confirmed", "no difference left")
    assert second["finding"].endswith(": 2 missing")


# terms told in differences


def test_missing_terms_are_told_in_differences() -> None:
    whole = sp.expand(a * (b - c) * (d - c) * (u + v) ** 2)
    assert folded(sp.Add.make_args(whole), {u: -v, b: c, d: c}) == (a * (b - c) * (d - c) * (u + v) ** 2,)
    assert set(folded((a * b, c * u), {b: c})) == {a * b, c * u}


# causes


def record(number: str, *why: str, terms: tuple[str, ...] = ()) -> dict[str, Any]:
    return {"paper": "p", "equation": number, "reasons": list(why), "terms": [{"term": t} for t in terms],
            "claims": "sum", "correction": list(why)}  # fmt: skip


def test_one_slip_in_several_equations_is_one_cause() -> None:
    found = causes([record("1", "b for a"), record("2", "b for a", "sign of c"), record("3"), record("4", "b for a")])
    assert [(one["cause"], one["equations"]) for one in found] == [
        ("b for a", ["p: 1", "p: 2", "p: 4"]),
        ("sign of c", ["p: 2"]),
    ]


def test_of_several_things_left_out_the_shared_one_is_the_cause() -> None:
    found = causes([record("1", "lacks moment", "lacks force", terms=("M",)), record("2", "lacks force", terms=("F",))])
    assert [(one["cause"], one["equations"]) for one in found] == [("force is left out", ["p: 1", "p: 2"])]


def test_the_three_equations_with_the_body_left_behind_are_one_slip() -> None:
    own = CASES["shi2021"]
    kindest = {n: heard(own, n).kindest for n in ("B1", "B2", "12")}
    (reason,) = {reasons(hearing.judgement, hearing.printed, {}) for hearing in kindest.values()}
    assert len(reason) == 1


def test_the_sentence_names_what_does_most() -> None:
    law = {
        "violation": 5.0,
        "unit": "N",
        "shares": [{"equation": "2", "shapley": 4.0}, {"equation": "1", "shapley": 1.0}],
    }
    said = told(law, {"1": record("1"), "2": record("2", terms=("F*sin(a)",))})
    assert said == "4 of the 5 N come from (2), sum: it lacks F*sin(a)."
    assert told({"shares": []}, {}) == ""


# references


def test_a_reference_to_equations_that_do_not_give_the_quantity_cannot_be_meant() -> None:
    own = case(derived(MadeUpClaim.SUM, x - a * u, x))
    own.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    own.paper.defines("2", b, a * v, Definition("width"))
    own.paper.refers([b], "1")
    own.paper.refers([x, b], "1", "2")
    first, second = references(own)
    assert (first["verdict"], first["lacking"], first["instead"]) == ("cannot be meant", [str(b)], ["2"])
    assert (second["verdict"], second["lacking"]) == ("can be meant", [])


def test_the_bars_do_not_come_from_the_places() -> None:
    (found,) = references(CASES["yu2023"])
    assert (found["lacking"], found["instead"]) == (["L1", "L2"], ["11a", "11b"])


def test_a_subject_holds_nothing_unless_it_says_so() -> None:
    assert Subject.held(MadeUp({}), MadeUpClaim.SUM, a) == {}
