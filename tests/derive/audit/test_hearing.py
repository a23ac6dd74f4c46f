"""What a verdict hangs on: readings, single characters, completed pieces, witnesses, causes,
references.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit.case import Case, judge_references
from derive.audit.faults import is_fragile, list_reasons
from derive.audit.judge import FAULTS, Judgement, judge_equation
from derive.audit.paper import Paper, Reading
from derive.audit.reading_search import (
    Outcome,
    fold_terms,
    judge_linked_readings,
)
from derive.audit.record import describe_law_cause, group_causes
from derive.equations import Definition, Equation, derived_equation, stated_equation
from tests.support.made_up import (
    POINTS,
    WORDS,
    MadeUp,
    MadeUpClaim,
    a,
    b,
    c,
    d,
    e,
    judge_number,
    judge_readings,
    judged,
    list_verdicts,
    record_equation,
    t,
    u,
    v,
    x,
    x_dot,
)
from tests.support.mutations import CASES


def case(meant: Equation, subject: type[MadeUp] = MadeUp) -> Case:
    return Case(Paper("made up", ""), subject({MadeUpClaim.SUM: meant}))


def outcome(case_: Case) -> Outcome:
    return judge_readings(case_, "1")


def only(case_: Case, *numbers: str) -> Case:
    """A paper that leaves only the first question of the first of some equations open, in these
    alone.
    """
    question = next(q for q in case_.paper.questions if numbers[0] in q.numbers)
    return replace(
        case_, paper=replace(case_.paper, questions=[replace(question, numbers=numbers)])
    )


# readings


def open_case(printed: sp.Expr, *readings: Reading) -> Case:
    case_ = case(derived_equation(MadeUpClaim.SUM, x - a * u, x))
    case_.paper.defines("1", x, printed, MadeUpClaim.SUM)
    case_.paper.admits(["1"], *readings)
    return case_


def test_a_verdict_is_robust_where_all_readings_give_it() -> None:
    result = outcome(open_case(b * u, Reading("b is a width"), Reading("b is twice a", {b: 2 * a})))
    assert list_verdicts(result) == ["misprint", "misprint"]
    assert result.robust


@pytest.mark.parametrize(
    "reading",
    [
        Reading("another mechanism", derived={a: b}),
        Reading("read otherwise", text=x - a * u),
        Reading("b is the length a", {b: a}),
    ],
)
def test_readings_are_of_symbols_the_derivation_or_the_text(reading: Reading) -> None:
    """The kindest decides, and all are shown."""
    result = outcome(open_case(b * u, Reading("as read"), reading))
    assert list_verdicts(result) == ["misprint", "confirmed"]
    assert result.kindest.choice.meaning == reading.meaning
    assert not result.robust


def test_two_questions_have_every_pair_of_answers() -> None:
    case_ = open_case(b * v, Reading("b"), Reading("b is a", {b: a}))
    case_.paper.admits(["1"], Reading("v"), Reading("v is u", {v: u}))
    result = outcome(case_)
    assert len(result.alternatives) == 4
    assert result.kindest.choice.meaning == "b is a; v is u"


# joint readings: one answer to a question, wherever it is asked


def linked_case(
    first: sp.Expr, second: sp.Expr, *readings: Reading, separately: bool = False
) -> Case:
    """Two prints of x = a u and x_dot = a v that both name the open symbol b."""
    case_ = Case(
        Paper("made up", ""),
        MadeUp(
            {
                MadeUpClaim.SUM: derived_equation(MadeUpClaim.SUM, x - a * u, x),
                MadeUpClaim.SHARE.format("v"): derived_equation(
                    MadeUpClaim.SHARE.format("v"), c - a * v, c
                ),
            }
        ),
    )
    case_.paper.defines("1", x, first, MadeUpClaim.SUM)
    case_.paper.defines("2", c, second, MadeUpClaim.SHARE.format("v"))
    for numbers in (["1"], ["2"]) if separately else (["1", "2"],):
        case_.paper.admits(numbers, *readings)
    return case_


B_OR_A = Reading("b is the length a", {b: a}), Reading("b is twice the length a", {b: 2 * a})


def test_linked_equations_share_the_answer() -> None:
    outcomes = judge_linked_readings(linked_case(b * u / 2, b * v / 2, *B_OR_A), "1")
    assert {n: o.kindest.judgement.verdict for n, o in outcomes.items()} == {
        "1": "confirmed",
        "2": "confirmed",
    }
    assert {o.kindest.choice.meaning for o in outcomes.values()} == {"b is twice the length a"}
    assert (
        outcomes.keys()
        == judge_linked_readings(linked_case(b * u / 2, b * v / 2, *B_OR_A), "2").keys()
    )


def test_symbol_with_two_meanings_is_not_chosen() -> None:
    """A cheat: each print is right under one meaning, and no meaning makes both right."""
    outcomes = judge_linked_readings(linked_case(b * u, b * v / 2, *B_OR_A), "1")
    assert sorted(o.kindest.judgement.verdict for o in outcomes.values()) == [
        "confirmed",
        "misprint",
    ]
    assert {o.kindest.choice.meaning for o in outcomes.values()} == {"b is the length a"}, (
        "equally kind: the first"
    )
    cheating = linked_case(b * u, b * v / 2, *B_OR_A, separately=True)
    assert [judge_number(cheating, n).verdict for n in ("1", "2")] == [
        "confirmed",
        "confirmed",
    ]


def test_least_sum_of_severities_decides() -> None:
    """The first answer, alone kindest to (1), costs (2) more than the second costs (1)."""
    case_ = linked_case(b * u, b * v / 2 + d * sp.sin(b / a), *B_OR_A)
    first, second = (
        sum(h.judgement.severity[0] for h in pair)
        for pair in zip(*(judge_readings(case_, n).alternatives for n in ("1", "2")), strict=True)
    )
    chosen = judge_readings(case_, "1").kindest.choice.meaning
    assert chosen == B_OR_A[second < first].meaning


def test_overlapping_questions_are_answered_together() -> None:
    case_ = linked_case(b * u, b * v, *B_OR_A)
    case_.paper.defines("3", d, e, Definition("made up"))
    case_.paper.defines("4", e, d, Definition("made up"))
    case_.paper.admits(["2", "3"], Reading("v"), Reading("v is u", {v: u}))
    assert [case_.linked(n) for n in ("1", "2", "3", "4")] == [("1", "2", "3")] * 3 + [("4",)]
    joint = case_.joint_choices(("1", "2", "3"))
    assert len(joint) == 4
    for choices in joint:
        assert choices["1"].answers[0] is choices["2"].answers[0]
        assert choices["2"].answers[1] is choices["3"].answers[0]


def test_hinge_forces_of_both_halves_confirm_a_planet_balance() -> None:
    """The funnel takes the forces of both halves, not the inner half's alone."""
    outcome_ = judge_readings(only(CASES["wang2017"], "17"), "17")
    verdicts = list_verdicts(outcome_)
    assert verdicts == ["incomplete", "confirmed"]


def test_chain_and_equations_share_readings() -> None:
    case_ = CASES["wang2017"]
    literal, summed = (case_.choices("19")[i] for i in (0, 2))
    assert case_.read_chains({}) == case_.chains
    side, _ = case_.read_chains({"19": summed})
    added = (
        side.equations["19"].residual.free_symbols
        - case_.paper.equations["19"].residual.free_symbols
    )
    assert {str(s) for s in added} == {"F_Aoz"}
    assert case_.read_chains({"19": literal}) == case_.chains
    assert case_.select_choices({"19": summed.meaning, "20": ""}) == {
        "19": summed,
        "20": case_.choices("20")[0],
    }
    with pytest.raises(ValueError, match="shi2021 has no executable chains"):
        CASES["shi2021"].read_chains({})


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
def test_fragile_finding_depends_on_a_single_character(
    printed: sp.Expr, meant: sp.Expr, fragile: bool
) -> None:
    assert is_fragile(judged(printed, meant)) is fragile


def test_completed_equation_is_confirmed_as_rebuilt() -> None:
    case_ = case(derived_equation(MadeUpClaim.SUM, x - a * u, x))
    case_.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    assert judge_number(case_, "1").verdict == "confirmed"
    case_.paper.rebuilds("1", "the factor u")
    assert judge_number(case_, "1").verdict == "confirmed as rebuilt"


def test_stated_equation_is_untested_and_errors_are_noticed() -> None:
    case_ = case(stated_equation(MadeUpClaim.SUM, x - a * u, x))
    case_.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    assert judge_number(case_, "1").verdict == "untested"
    case_.paper.equations["1"] = replace(case_.paper.equations["1"], residual=x - b * u)
    assert judge_number(case_, "1").verdict == "misprint"


def definition(factor: sp.Expr, **values: str) -> str:
    paper = Paper("made up", "")
    paper.defines("1", x, factor * a, Definition("made up"))
    if values:
        paper.shows("1", "a table", **values)
    return judge_equation(paper.equations["1"], None, POINTS, WORDS).verdict


def test_a_definition_is_tested_by_printed_values() -> None:
    tenth = sp.Rational(1, 10)
    assert definition(6 * tenth) == "untested"
    assert definition(6 * tenth, testx="1.81", test_a="3.02") == "definition"
    assert definition(7 * tenth, testx="1.81", test_a="3.02") == "contradicted"
    assert definition(6 * tenth, testx="1.82", test_a="3.02") == "contradicted"
    with pytest.raises(ValueError, match="a table prints nothing of test_a"):
        definition(6 * tenth, testx="1.81")


def test_bounds_of_unprinted_terms_test_a_definition() -> None:
    """x = a^2 with a between b and 2 b is tested by printed values of x and b."""
    for expr, value, verdict in (
        (a**2, "2.5", "definition"),
        (a**2, "4.5", "contradicted"),
        (a, "2.5", "contradicted"),
    ):
        paper = Paper("made up", "")
        paper.defines("1", x, expr, Definition("made up"))
        paper.shows("1", "a table", {a: (b, 2 * b)}, testx=value, test_b="1")
        assert judge_equation(paper.equations["1"], None, POINTS, WORDS).verdict == verdict


def test_variance_printed_as_standard_deviation_is_noticed() -> None:
    """Table 1 gives forces that no deviation of 1907 N fits between."""
    printed = CASES["wang2017"].paper.equations["30"]
    assert judge_equation(printed, None, POINTS, WORDS).verdict == "definition"
    square = printed.defines - printed.residual
    for wrong in (sp.sqrt(square), -square):
        planted = replace(printed, residual=printed.defines - wrong)
        assert judge_equation(planted, None, POINTS, WORDS).verdict == "contradicted"


def test_wrong_angle_in_the_angle_curve_is_noticed() -> None:
    case_ = CASES["sun2019"]
    printed = case_.paper.equations["y"]
    assert judge_number(case_, "y").verdict == "confirmed"
    theta, phi = sorted(
        printed.residual.free_symbols - {printed.defines}, key=lambda s: str(s) != "theta"
    )
    for wrong in (theta + phi, theta, phi, 2 * (theta - phi)):
        equations = {
            **case_.paper.equations,
            "y": replace(printed, residual=printed.defines - wrong),
        }
        planted = replace(case_, paper=replace(case_.paper, equations=equations))
        assert judge_number(planted, "y").verdict in FAULTS, wrong


@pytest.mark.parametrize(
    ("name", "number"), [("wang2017", "29"), ("wang2017", "31"), ("shi2021", "k")]
)
def test_a_changed_number_in_a_definition_is_noticed(name: str, number: str) -> None:
    printed = CASES[name].paper.equations[number]
    assert judge_equation(printed, None, POINTS, WORDS).verdict == "definition"
    for term in sp.Add.make_args(sp.expand(printed.residual - (printed.defines or 0))):
        wrong = replace(printed, residual=printed.residual + term / 6)
        assert judge_equation(wrong, None, POINTS, WORDS).verdict == "contradicted", term


# where a thing is held


class Held(MadeUp):
    def constraint_residuals(self, claim: Any, formula: sp.Expr) -> dict[str, sp.Expr]:
        return {"slope at the wall": formula.diff(u).subs(u, 0)}


def test_displacement_must_vanish_at_supports() -> None:
    for shape, verdict in ((sp.sin(u), "contradicted"), (1 - sp.cos(u), "confirmed")):
        case_ = case(derived_equation(MadeUpClaim.SUM, x - a * shape, x), Held)
        case_.paper.defines("1", x, a * shape, MadeUpClaim.SUM)
        judgement = judge_number(case_, "1")
        assert judgement.verdict == verdict
        assert list(judgement.loose) == (["slope at the wall"] if verdict == "contradicted" else [])


def test_assumed_shape_of_the_shaft_needs_a_hinged_end() -> None:
    """Clamped or held elastically it would have another slope: only a bearing in which it turns
    freely admits it.
    """
    judged = judge_readings(only(CASES["shi2021"], "10"), "10")
    assert [tuple(h.judgement.loose) for h in judged.alternatives] == [
        ("slope at the bearing",)
    ] * 2 + [()]


def test_end_of_a_beam_starts_with_the_speed_of_the_body() -> None:
    overhang, end = judge_readings(CASES["shi2021"], "start").alternatives
    assert (overhang.judgement.verdict, end.judgement.verdict) == ("contradicted", "confirmed")


def test_first_missing_term_is_named_without_a_force() -> None:
    judgement = Judgement("incomplete", "", missing=(a * u, b))
    printed = derived_equation(MadeUpClaim.SUM, c - b)
    assert list_reasons(judgement, printed, {}) == (f"lacks {a * u}",)


def test_record_shows_remainder_of_each_reading() -> None:
    case_ = open_case(
        a * u, Reading("as derived"), Reading("two terms more", derived={a: a + b + c * sp.sin(v)})
    )
    first, second = record_equation(case_, "1")["depends"]
    assert (first["verdict"], first["finding"]) == ("confirmed", "no difference left")
    assert second["finding"].endswith(": 2 missing")


# terms told in differences


def test_missing_terms_are_written_as_differences() -> None:
    product = sp.expand(a * (b - c) * (d - c) * (u + v) ** 2)
    assert fold_terms(sp.Add.make_args(product), {u: -v, b: c, d: c}) == (
        a * (b - c) * (d - c) * (u + v) ** 2,
    )
    assert set(fold_terms((a * b, c * u), {b: c})) == {a * b, c * u}


# causes


def record(number: str, *why: str, terms: tuple[str, ...] = ()) -> dict[str, Any]:
    return {
        "paper": "p",
        "equation": number,
        "grade": "at fault",
        "reasons": list(why),
        "terms": [{"term": t} for t in terms],
        "claims": "sum",
        "correction": list(why),
    }


def test_equal_errors_in_equations_share_a_cause() -> None:
    causes = group_causes(
        [
            record("1", "b for a"),
            record("2", "b for a", "sign of c"),
            record("3"),
            record("4", "b for a"),
        ]
    )
    assert [(cause["cause"], cause["equations"]) for cause in causes] == [
        ("b for a", ["p: 1", "p: 2", "p: 4"]),
        ("sign of c", ["p: 2"]),
    ]


def test_shared_omission_is_the_cause() -> None:
    causes = group_causes(
        [
            record("1", "lacks moment", "lacks force", terms=("M",)),
            record("2", "lacks force", terms=("F",)),
        ]
    )
    assert [(cause["cause"], cause["equations"]) for cause in causes] == [
        ("force is left out", ["p: 1", "p: 2"])
    ]


def test_law_sentence_names_largest_share() -> None:
    law = {
        "violation": 5.0,
        "unit": "N",
        "shares": [
            {"equation": "2", "alone": 4.5, "shapley": 4.0},
            {"equation": "1", "alone": 0.5, "shapley": 1.0},
        ],
    }
    sentence = describe_law_cause(law, {"1": record("1"), "2": record("2", terms=("F*sin(a)",))})
    assert all(part in sentence for part in ("(2)", "from 5 to 0.5 N", "it lacks F*sin(a)"))
    assert describe_law_cause({"shares": []}, {}) == ""


# references


def test_reference_to_unrelated_equations_is_refuted() -> None:
    case_ = case(derived_equation(MadeUpClaim.SUM, x - a * u, x))
    case_.paper.defines("1", x, a * u, MadeUpClaim.SUM)
    case_.paper.defines("2", b, a * v, Definition("width"))
    case_.paper.refers([b], "1")
    case_.paper.refers([x, b], "1", "2")
    first, second = judge_references(case_)
    assert (first["verdict"], first["lacking"], first["instead"]) == (
        "cannot be meant",
        [str(b)],
        ["2"],
    )
    assert (second["verdict"], second["lacking"]) == ("can be meant", [])
