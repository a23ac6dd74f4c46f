"""What a verdict hangs on: readings, single characters, completed pieces, witnesses, causes, references."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit.case import Case, references
from derive.audit.judge import FAULTS, Judgement, judge
from derive.audit.paper import Paper, Reading, Subject
from derive.audit.reading_search import Outcome, fold_terms, is_fragile, judge_linked_readings, judge_readings, reasons
from derive.audit.record import describe_law_cause, group_causes
from derive.audit.record import equation as recorded
from derive.equations import Definition, Equation, derived, stated
from planter.kernels import generated
from tests.support.made_up import POINTS, WORDS, MadeUp, MadeUpClaim, a, b, c, d, e, judged, t, u, v, x, x_dot
from tests.support.mutations import CASES


def case(meant: Equation, subject: type[MadeUp] = MadeUp) -> Case:
    return Case(Paper("made up", ""), subject({MadeUpClaim.SUM: meant}))


def outcome(own: Case) -> Outcome:
    return judge_readings(own, "1")


def load_schema(name: str, *numbers: str) -> list[dict[str, Any]]:
    """The committed records of some equations of a paper, in this order."""
    found = {r["equation"]: r for r in generated.sidecar("audit")["equations"] if r["paper"] == name}
    return [found[number] for number in numbers]


def only(own: Case, *numbers: str) -> Case:
    """A paper that leaves only the first question of the first of some equations open, in these alone."""
    question = next(q for q in own.paper.questions if numbers[0] in q.numbers)
    return replace(own, paper=replace(own.paper, questions=[replace(question, numbers=numbers)]))


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


# joint readings: one answer to a question, wherever it is asked


def linked_case(one: sp.Expr, two: sp.Expr, *readings: Reading, separately: bool = False) -> Case:
    """Two prints of x = a u and x_dot = a v that both name the open symbol b."""
    own = Case(Paper("made up", ""), MadeUp({
        MadeUpClaim.SUM: derived(MadeUpClaim.SUM, x - a * u, x),
        MadeUpClaim.SHARE.of("v"): derived(MadeUpClaim.SHARE.of("v"), c - a * v, c),
    }))  # fmt: skip
    own.paper.defines("1", x, one, MadeUpClaim.SUM)
    own.paper.defines("2", c, two, MadeUpClaim.SHARE.of("v"))
    for numbers in (["1"], ["2"]) if separately else (["1", "2"],):
        own.paper.admits(numbers, *readings)
    return own


B_OR_A = Reading("b is the length a", {b: a}), Reading("b is twice the length a", {b: 2 * a})


def test_linked_equations_have_one_answer() -> None:
    found = judge_linked_readings(linked_case(b * u / 2, b * v / 2, *B_OR_A), "1")
    assert {n: o.kindest.judgement.verdict for n, o in found.items()} == {"1": "confirmed", "2": "confirmed"}
    assert {o.kindest.choice.meaning for o in found.values()} == {"b is twice the length a"}
    assert found.keys() == judge_linked_readings(linked_case(b * u / 2, b * v / 2, *B_OR_A), "2").keys()


def test_symbol_with_two_meanings_is_not_chosen() -> None:
    """A cheat: each print is right under one meaning, and no meaning makes both right."""
    found = judge_linked_readings(linked_case(b * u, b * v / 2, *B_OR_A), "1")
    assert sorted(o.kindest.judgement.verdict for o in found.values()) == ["confirmed", "misprint"]
    assert {o.kindest.choice.meaning for o in found.values()} == {"b is the length a"}, "equally kind: the first"
    cheating = linked_case(b * u, b * v / 2, *B_OR_A, separately=True)
    assert [judge_readings(cheating, n).kindest.judgement.verdict for n in ("1", "2")] == ["confirmed", "confirmed"]


def test_least_sum_of_severities_decides() -> None:
    """The first answer, alone kindest to (1), costs (2) more than the second costs (1)."""
    own = linked_case(b * u, b * v / 2 + d * sp.sin(b / a), *B_OR_A)
    first, second = (sum(h.judgement.severity[0] for h in pair) for pair in zip(
        *(judge_readings(own, n).every for n in ("1", "2")), strict=True))  # fmt: skip
    chosen = judge_readings(own, "1").kindest.choice.meaning
    assert chosen == B_OR_A[second < first].meaning


def test_questions_that_overlap_are_answered_together() -> None:
    own = linked_case(b * u, b * v, *B_OR_A)
    own.paper.defines("3", d, e, Definition("made up"))
    own.paper.defines("4", e, d, Definition("made up"))
    own.paper.admits(["2", "3"], Reading("v"), Reading("v is u", {v: u}))
    assert [own.linked(n) for n in ("1", "2", "3", "4")] == [("1", "2", "3")] * 3 + [("4",)]
    joint = own.joint_choices(("1", "2", "3"))
    assert len(joint) == 4
    for choices in joint:
        assert choices["1"].answers[0] is choices["2"].answers[0]
        assert choices["2"].answers[1] is choices["3"].answers[0]


@pytest.mark.parametrize("name", CASES)
def test_committed_answers_are_one_to_each_question(name: str) -> None:
    own, records = CASES[name], generated.sidecar("audit")["equations"]
    answers = {r["equation"]: r["answer"] for r in records if r["paper"] == name and own.choices(r["equation"])}
    chosen = own.choices_by(answers)
    assert {n: c.meaning for n, c in chosen.items()} == answers
    for question in own.paper.questions:
        meanings = {a.meaning for n in question.numbers for a in chosen[n].answers if a in question.readings}
        assert len(meanings) == 1, question.numbers


def test_hinge_forces_of_both_halves_confirm_the_planet_balances() -> None:
    """The funnel takes the forces of both halves: so read, two balances hold and one has a wrong character."""
    found = load_schema("wang2017", "17", "18", "19", "20")
    assert [r["verdict"] for r in found] == ["confirmed", "misprint", "confirmed", "incomplete"]
    assert found[1]["correction"] == ["y_B1 for x_B1"]
    assert {t["term"] for t in found[3]["terms"]} == {"-M_Az", "-M_Aoz"}
    assert all(r["depends"][0]["verdict"] == "incomplete" for r in found), "the inner half's alone"
    own = CASES["wang2017"]
    assert [h.judgement.verdict for h in judge_readings(only(own, "17"), "17").every] == ["incomplete", "confirmed"]


def test_force_along_z_counts_one_way_in_both_balances() -> None:
    """Against z' (7) has one slip less, and (19) one more: it has no such sense in (7) alone."""
    assert {"7", "19"} <= {*CASES["wang2017"].linked("17")}
    seventh, nineteenth = load_schema("wang2017", "7", "19")
    along, against = seventh["depends"]
    assert along["finding"].count(";") == against["finding"].count(";") + 1
    assert seventh["answer"] == along["reading"]
    assert along["reading"] in nineteenth["answer"]


def test_chain_is_read_as_its_equations_are() -> None:
    own = CASES["wang2017"]
    literal, summed = (own.choices("19")[i] for i in (0, 2))
    assert own.read_chains({}) == own.chains
    side, _ = own.read_chains({"19": summed})
    added = side.equations["19"].residual.free_symbols - own.paper.equations["19"].residual.free_symbols
    assert {str(s) for s in added} == {"F_Aoz"}
    assert own.read_chains({"19": literal}) == own.chains
    assert own.choices_by({"19": summed.meaning, "20": ""}) == {"19": summed, "20": own.choices("20")[0]}
    with pytest.raises(ValueError, match="shi2021 has no executable chains"):
        CASES["shi2021"].read_chains({})


def test_the_papers_open_questions_and_what_depends_on_them() -> None:
    for name, numbers in {"shi2021": ("B1", "B2", "12"), "wang2017": ("x_E", "z_E"), "sun2019": ("d1", "d2")}.items():
        assert not any(r["robust"] for r in load_schema(name, *numbers)), name
    assert load_schema("yu2023", "W1")[0]["robust"]


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
    assert all(is_fragile(judge_readings(CASES[name], number).kindest.judgement) for name, number in found)
    others = (("wang2017", "P1"), ("shi2021", "Y_C"))
    assert not any(is_fragile(judge_readings(CASES[name], number).kindest.judgement) for name, number in others)


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


def test_definition_is_tested_by_bounds_of_what_is_not_printed() -> None:
    """x = a^2 with a between b and 2 b is tested by printed values of x and b."""
    for expr, value, verdict in (
        (a**2, "2.5", "definition"),
        (a**2, "4.5", "contradicted"),
        (a, "2.5", "contradicted"),
    ):
        paper = Paper("made up", "")
        paper.defines("1", x, expr, Definition("made up"))
        paper.shows("1", "a table", {a: (b, 2 * b)}, testx=value, test_b="1")
        assert judge(paper.equations["1"], None, POINTS, WORDS).verdict == verdict


def test_variance_printed_as_standard_deviation_is_noticed() -> None:
    """Table 1 gives forces that no deviation of 1907 N fits between."""
    printed = CASES["wang2017"].paper.equations["30"]
    assert judge(printed, None, POINTS, WORDS).verdict == "definition"
    square = printed.defines - printed.residual
    for wrong in (sp.sqrt(square), -square):
        planted = replace(printed, residual=printed.defines - wrong)
        assert judge(planted, None, POINTS, WORDS).verdict == "contradicted"


def test_wrong_angle_in_the_angle_curve_is_noticed() -> None:
    own = CASES["sun2019"]
    printed = own.paper.equations["y"]
    assert judge_readings(own, "y").kindest.judgement.verdict == "confirmed"
    theta, phi = sorted(printed.residual.free_symbols - {printed.defines}, key=lambda s: str(s) != "theta")
    for wrong in (theta + phi, theta, phi, 2 * (theta - phi)):
        equations = {**own.paper.equations, "y": replace(printed, residual=printed.defines - wrong)}
        planted = replace(own, paper=replace(own.paper, equations=equations))
        assert judge_readings(planted, "y").kindest.judgement.verdict in FAULTS, wrong


@pytest.mark.parametrize(("name", "number"), [("wang2017", "29"), ("wang2017", "31"), ("shi2021", "k")])
def test_a_changed_number_in_a_definition_is_noticed(name: str, number: str) -> None:
    printed = CASES[name].paper.equations[number]
    assert judge(printed, None, POINTS, WORDS).verdict == "definition"
    for term in sp.Add.make_args(sp.expand(printed.residual - (printed.defines or 0))):
        wrong = replace(printed, residual=printed.residual + term / 6)
        assert judge(wrong, None, POINTS, WORDS).verdict == "contradicted", term


# where a thing is held


class Held(MadeUp):
    def constraint_residuals(self, claim: Any, formula: sp.Expr) -> dict[str, sp.Expr]:
        return {"slope at the wall": formula.diff(u).subs(u, 0)}


def test_what_must_vanish_where_a_thing_is_held() -> None:
    for shape, verdict in ((sp.sin(u), "contradicted"), (1 - sp.cos(u), "confirmed")):
        own = case(derived(MadeUpClaim.SUM, x - a * shape, x), Held)
        own.paper.defines("1", x, a * shape, MadeUpClaim.SUM)
        found = outcome(own).kindest.judgement
        assert found.verdict == verdict
        assert found.loose == (("slope at the wall",) if verdict == "contradicted" else ())


def test_assumed_shape_of_the_shaft_needs_a_hinged_end() -> None:
    """Clamped or held elastically it would have another slope: only a bearing in which it turns freely admits it."""
    assert [r["verdict"] for r in load_schema("shi2021", "9", "10")] == ["misprint", "confirmed"]
    found = judge_readings(only(CASES["shi2021"], "10"), "10")
    assert [h.judgement.loose for h in found.every] == [("slope at the bearing",)] * 2 + [()]


def test_end_of_a_beam_starts_with_the_speed_of_the_body() -> None:
    whole, end = judge_readings(CASES["shi2021"], "start").every
    assert (whole.judgement.verdict, end.judgement.verdict) == ("contradicted", "confirmed")


def test_rotation_of_the_crank_gear_counts_one_way() -> None:
    found = load_schema("shi2021", "6", "7a", "7b")
    assert [r["verdict"] for r in found] == ["contradicted", "misprint", "confirmed"]
    assert [r["depends"][0]["verdict"] for r in found] == ["contradicted", "misprint", "misprint"]
    assert len({r["answer"] for r in found}) == 1


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
    assert fold_terms(sp.Add.make_args(whole), {u: -v, b: c, d: c}) == (a * (b - c) * (d - c) * (u + v) ** 2,)
    assert set(fold_terms((a * b, c * u), {b: c})) == {a * b, c * u}


# causes


def record(number: str, *why: str, terms: tuple[str, ...] = ()) -> dict[str, Any]:
    return {"paper": "p", "equation": number, "reasons": list(why), "terms": [{"term": t} for t in terms],
            "claims": "sum", "correction": list(why)}  # fmt: skip


def test_one_slip_in_several_equations_is_one_cause() -> None:
    found = group_causes(
        [record("1", "b for a"), record("2", "b for a", "sign of c"), record("3"), record("4", "b for a")]
    )
    assert [(one["cause"], one["equations"]) for one in found] == [
        ("b for a", ["p: 1", "p: 2", "p: 4"]),
        ("sign of c", ["p: 2"]),
    ]


def test_of_several_things_left_out_the_shared_one_is_the_cause() -> None:
    found = group_causes(
        [record("1", "lacks moment", "lacks force", terms=("M",)), record("2", "lacks force", terms=("F",))]
    )
    assert [(one["cause"], one["equations"]) for one in found] == [("force is left out", ["p: 1", "p: 2"])]


def test_the_three_equations_with_the_body_left_behind_are_one_slip() -> None:
    own = CASES["shi2021"]
    kindest = (found.kindest for found in judge_linked_readings(own, "B1").values())
    (reason,) = {reasons(hearing.judgement, hearing.printed, {}) for hearing in kindest}
    assert len(reason) == 1


def test_the_sentence_names_what_does_most() -> None:
    law = {
        "violation": 5.0,
        "unit": "N",
        "shares": [{"equation": "2", "alone": 4.5, "shapley": 4.0}, {"equation": "1", "alone": 0.5, "shapley": 1.0}],
    }
    said = describe_law_cause(law, {"1": record("1"), "2": record("2", terms=("F*sin(a)",))})
    assert all(part in said for part in ("(2)", "from 5 to 0.5 N", "it lacks F*sin(a)"))
    assert describe_law_cause({"shares": []}, {}) == ""


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
    assert Subject.constraint_residuals(MadeUp({}), MadeUpClaim.SUM, a) == {}
