"""Verdicts on small made-up equations."""

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from derive.audit.judge import Judgement, judge_by_values, judge_equation
from derive.equations import UNCLAIMED, Equation
from derive.evaluate import Point
from derive.quantity import DimensionError, dimension, of_unit
from tests.support.made_up import (
    POINTS,
    WORDS,
    MadeUpClaim,
    a,
    b,
    c,
    d,
    e,
    judged,
    quantity,
    t,
    u,
    v,
    values,
    x,
    x_dot,
)

FACTORS = 1, 2, sp.Rational(-1, 3), sp.pi / 180, -sp.sqrt(2)
DEFAULTS = (), ("=", "=")
FOUND = [
    # printed, meant, verdict, the only correction, missing terms, relations
    (a * sp.sin(u) + b * t / t - c, a * sp.cos(u) + b - c, "misprint", {f"cos for sin of {u}"}),
    (a * u**2 - c * u * v, a * (u + v) ** 2 - c * u * v, "misprint", {f"{u + v} for {u}"}),
    (
        a * sp.cos(u) + b * sp.exp(v) + c * u * v - d * v**2 / 2 + e,
        a * sp.sin(u) - b * sp.exp(v) + c * u * v - d * v**2 + e,
        "misprint",
        {f"sin for cos of {u}", f"sign of {b * sp.exp(v)}", f"factor 2 on {-d * v**2 / 2}"},
    ),
    (2 * a - b * u + c, a - b * u + c, "misprint", {f"factor 1/2 on {2 * a}"}),
    (a - b, a - b, "misprint", {"> for <"}, (), ("<", ">")),
    (a - b, a - b, "misprint", {"<= for <"}, (), ("<", "<=")),
    (-2 * (a - b * u), a - b * u, "misprint", {"> for <"}, (), ("<", "<")),
    (a - b, a - b - c * u - 3 * d * v, "incomplete", (), {-c * u, -3 * d * v}),
    (a * u - b * v, a * u - b * v + c * u * v, "incomplete", (), {c * u * v}),
    (
        a - b * sp.sin(u),
        a - b * sp.cos(u) - c * u - d * v,
        "incomplete",
        {f"cos for sin of {u}"},
        {-c * u, -d * v},
    ),
    (x - a * sp.sin(u) * sp.cos(u), x - a * sp.sin(2 * u) / 2 - b * v, "incomplete", (), {-b * v}),
    *(
        row
        for f in FACTORS[:3]
        for row in (
            (sp.expand(f * (a - b * v)), a - b * v - c * u, "incomplete", (), {-f * c * u}),
            (
                sp.expand(f * (a * sp.sin(u) - b * v + c)),
                a * sp.cos(u) - b * v + c,
                "misprint",
                {f"cos for sin of {u}"},
            ),
        )
    ),
]
AGREEING = [
    # printed, meant, relations, and whether they say the same
    (b - a, a - b, ("=", "="), True),
    (b - a, a - b, (">", "<"), True),
    (a - b, a - b, ("<", "<"), True),
    (a * u - b * v, a * c * u - b * c * v, ("=", "="), True),
    (a * u / b - v, a * u - b * v, ("=", "="), True),
    (a * u + b * v, a * c * u - b * c * v, ("=", "="), False),
    (a * u - v * b, a * c * u - b * c * v, ("<", "<"), True),  # c is positive throughout
    (a * u - v * b, b * c * v - a * c * u, ("<", "<"), False),
    *((f * (a - b * u), a - b * u, ("=", "="), True) for f in FACTORS),
    (2 * (a - b * u), a - b * u, ("<", "<"), True),
    (-2 * (a - b * u), a - b * u, (">", "<"), True),
    (u * (a - b), a - b, ("=", "="), False),
]


@pytest.mark.parametrize("row", FOUND)
def test_error_has_a_single_correction(row: tuple[Any, ...]) -> None:
    printed, meant, verdict, correction, missing, relations = (*row, *DEFAULTS[len(row) - 4 :])
    judgement = judged(printed, meant, relations)
    assert (judgement.verdict, set(judgement.missing)) == (verdict, set(missing))
    assert [set(edits) for edits in judgement.corrections] == ([correction] if correction else [])


@pytest.mark.parametrize(("printed", "meant", "relations", "same"), AGREEING)
def test_confirmed_however_it_is_turned(
    printed: sp.Expr, meant: sp.Expr, relations: tuple[Any, Any], same: bool
) -> None:
    assert (judged(printed, meant, relations).verdict == "confirmed") is same


def test_confirmed_however_it_is_written() -> None:
    assert judged(
        (a + b) ** 2 - c**2 * sp.sin(u) ** 2, a**2 + 2 * a * b + b**2 + c**2 * (sp.cos(u) ** 2 - 1)
    ) == Judgement("confirmed", "no difference left")


def test_misprint_with_two_edits() -> None:
    judgement = judged(a * sp.sin(u) - b * sp.exp(v) + c, a * sp.cos(u) + b * sp.exp(v) + c)
    assert judgement.verdict == "misprint"
    assert (f"cos for sin of {u}", f"sign of {-b * sp.exp(v)}") in judgement.corrections
    assert {len(edit) for edit in judgement.corrections} == {2}


def test_every_smallest_correction_is_listed() -> None:
    judgement = judged(a * u + a * v - c, b * u + b * v - c)
    assert judgement.corrections == ((f"{b} for {a} throughout",),)
    judgement = judged(a * sp.cos(u - v) - c, a * sp.cos(u + v) - c)
    assert {(f"sign of {u}",), (f"sign of {-v}",)} <= set(judgement.corrections)


def test_a_wrong_relation_is_part_of_every_correction() -> None:
    assert judged(a - b, a - b, ("<", ">")).corrections == (("> for <",),)
    assert judged(a - b, a - b, ("<", "<=")).corrections == (("<= for <",),)
    judgement = judged(a - b * sp.sin(u), a - b * sp.cos(u), ("<", ">"))
    assert judgement.verdict == "misprint"
    assert ("> for <", f"cos for sin of {u}") in judgement.corrections


def test_unexplained_term_is_contradicted() -> None:
    judgement = judged(a - b * sp.exp(u) * u**3, a - c * sp.log(1 + v) - d)
    assert judgement.verdict == "contradicted"
    assert judgement.unexplained == (-b * sp.exp(u) * u**3,)


def test_reconstructed_and_untested() -> None:
    lost = Equation("n", sp.S.Zero, "test", MadeUpClaim.SUM, "lost")
    assert judge_equation(lost, replace(lost, residual=a), POINTS, WORDS).verdict == "reconstructed"
    assert (
        judge_equation(
            replace(lost, legibility="printed", residual=a - b), None, POINTS, WORDS
        ).verdict
        == "untested"
    )


@pytest.mark.parametrize("mixed", [a + t, a - b * t, sp.sin(a), a - b * x_dot])
def test_never_confirmed_when_dimensions_are_mixed(mixed: sp.Expr) -> None:
    judgement = judged(mixed, mixed)
    assert judgement.verdict != "confirmed"
    assert "not dimensionally consistent" in judgement.finding


def test_complex_printed_value_is_a_difference() -> None:
    judgement = judged(sp.asin(2 + u) - v, sp.asin(u) - v)
    assert judgement.verdict != "confirmed"
    judgement = judged(sp.asin(2 * u / (u + v) + 1 / u) - v, sp.asin(u / (u + v)) - v)
    assert judgement.verdict != "confirmed"


def test_symbol_without_value_is_not_judged() -> None:
    judgement = judged(a - quantity("nowhere"), a - b)
    assert judgement.verdict == "not judged"
    assert judgement.finding.startswith("nowhere has no value")


def test_a_summand_too_many_also_in_a_bracket() -> None:
    assert judged(a * u - b + c, a * u - b).corrections == ((f"without {c}",),)
    judgement = judged(a * (x_dot + b / t) ** 2 - c * x_dot**2, a * x_dot**2 - c * x_dot**2)
    assert (f"without {b / t}",) in judgement.corrections


def test_sign_and_factor_of_a_group() -> None:
    judgement = judged(a * u - b * v - c + d, a * u + b * v + c + d)
    assert judgement.verdict == "misprint"
    assert min(map(len, judgement.corrections)) == 1
    judgement = judged(a * u - 2 * b * v - 2 * c + d - e, a * u - b * v - c + d - e)
    assert (judgement.verdict, len(judgement.corrections[0])) == ("misprint", 1)


def test_root_factor_of_a_derived_term() -> None:
    judgement = judged(a * u - b, a * u - sp.sqrt(3) * b, defines=x)
    assert judgement.corrections == ((f"factor sqrt(3) on {-b}",),)
    assert judged(a * u - b, a * u - sp.Rational(1001, 1000) * b, defines=x).verdict != "confirmed"


# what is no error


def test_a_direction_is_the_same_a_whole_turn_on() -> None:
    for turns, verdict in (
        (2, "confirmed"),
        (-4, "confirmed"),
        (1, "misprint"),
        (sp.Rational(1, 2), "misprint"),
    ):
        printed, meant = (
            Equation("n", u - e, "test", MadeUpClaim.SUM, defines=u) for e in (v + turns * sp.pi, v)
        )
        judgement = judge_equation(printed, meant, POINTS, WORDS, frozenset({u})).verdict
        assert (judgement == "confirmed") is (verdict == "confirmed"), turns
        assert judge_equation(printed, meant, POINTS, WORDS).verdict != "confirmed", turns


def test_a_definition_may_have_both_sides_the_other_way_round() -> None:
    printed, meant = (
        Equation("n", e, "test", MadeUpClaim.SUM, defines=x) for e in (a * u - x, x - a * u)
    )
    assert judge_equation(printed, meant, POINTS, WORDS).verdict == "confirmed"
    assert (
        judge_equation(replace(printed, residual=a * u + x), meant, POINTS, WORDS).verdict
        == "misprint"
    )


def test_factor_on_a_definition_is_an_error() -> None:
    judgement = judged(2 * a * u, a * u, defines=x)
    assert (judgement.verdict, judgement.corrections) == (
        "misprint",
        (("factor 1/2 on the whole",),),
    )
    assert judged(sp.pi * a * u, a * u, defines=x).verdict != "confirmed"


def test_no_edit_takes_a_real_value_away() -> None:
    """With the cases the other way round the arc cosine of a case became real at some points and an
    edit there.
    """
    cases = (
        ((sp.S.Zero, u < v), ((1 + 1 / u) * v, True)),
        (((1 + 1 / u) * v, u >= v), (sp.S.Zero, True)),
    )
    for printed in (sp.Piecewise(*case) for case in cases):
        judgement = judged(
            printed,
            sp.Piecewise((sp.S.Zero, u < v), ((1 + 1 / u) * (v - sp.pi / 2), True)),
            defines=t,
        )
        assert (judgement.verdict, judgement.corrections) == ("contradicted", ())


def test_zero_products_have_the_dimension_of_anything() -> None:
    def product(*factors: sp.Expr) -> sp.Expr:
        return sp.Mul(*factors, evaluate=False)

    for zero in (
        product(sp.S.Zero, a),
        product(sp.S.Zero, sp.Integer(2)),
        product(sp.S.Zero, sp.sqrt(3)),
        product(product(0, a), t),
    ):
        assert dimension(zero) is None, zero
        assert dimension(sp.Add(zero, t, evaluate=False)) == of_unit("s"), zero
        assert judged(sp.Add(a, -b, zero, evaluate=False), a - b).verdict == "confirmed", zero
    with pytest.raises(DimensionError):
        dimension(product(sp.S.One, a) + t)


def test_three_terms_too_many_are_three_edits() -> None:
    judgement = judged(a * u - b * v + c * u + d * v + e * u * v, a * u - b * v)
    assert judgement.verdict == "misprint"
    assert {len(correction) for correction in judgement.corrections} == {3}
    assert all("without" in text for text in judgement.corrections[0])


def test_severity_orders_verdicts_and_numbers_of_edits() -> None:
    mildest = [
        Judgement("confirmed", ""),
        Judgement("misprint", "", (("one",),)),
        Judgement("misprint", "", (("one", "two"),)),
        Judgement("incomplete", "", missing=(a,)),
        Judgement("incomplete", "", missing=(a, b)),
        Judgement("contradicted", "", (), (a,)),
        Judgement("contradicted", "", (), (a,), (b,)),
    ]
    assert sorted(mildest, key=lambda judgement: judgement.severity) == mildest
    grades = [judgement.severity[0] for judgement in mildest]
    assert grades[0] < grades[1] == grades[2] < grades[3]


# equations without a claim

FORCE = quantity("test_F")


def list_points() -> list[Point]:
    """Made-up values, and one that follows from them: F = 2 a u - b cos(v)."""
    drawn_points = []
    for seed in (1, 2, 3):
        known_values = values(seed)
        drawn_points.append(
            Point(
                known_values
                | {
                    FORCE: 2 * known_values[a] * known_values[u]
                    - known_values[b] * sp.cos(known_values[v])
                }
            )
        )
    return drawn_points


def judge_unclaimed(residual: sp.Expr, defines: bool = False) -> Judgement:
    symbol = FORCE if defines else None
    printed = Equation("1", FORCE - residual, "test", UNCLAIMED, defines=symbol)
    return judge_equation(printed, None, list_points(), [*WORDS, FORCE])


@pytest.mark.parametrize(
    "right", [2 * a * u - b * sp.cos(v), (4 * a * u - 2 * b * sp.sin(v + sp.pi / 2)) / 2]
)
def test_true_equation_is_confirmed_in_any_notation(right: sp.Expr) -> None:
    assert (
        judge_unclaimed(right).verdict
        == judge_unclaimed(right, defines=True).verdict
        == "confirmed"
    )


@pytest.mark.parametrize(
    ("wrong", "correction"),
    [
        (2 * a * u + b * sp.cos(v), "sign of test_b*cos(test_v)"),
        (2 * a * u - b * sp.sin(v), "cos for sin of test_v"),
        (a * u - b * sp.cos(v), "factor 2 on test_a*test_u"),
        (2 * c * u - b * sp.cos(v), "test_a for test_c"),
    ],
)
def test_error_is_reported_with_the_correction(wrong: sp.Expr, correction: str) -> None:
    judgement = judge_unclaimed(wrong, defines=True)
    assert judgement.verdict == "misprint"
    assert (correction,) in judgement.corrections


def test_uncorrectable_equation_is_contradicted_with_remainder() -> None:
    judgement = judge_unclaimed(3 * a * u - 5 * b)
    assert judgement.verdict == "contradicted"
    assert "is left of terms of up to" in judgement.finding


def test_error_that_was_not_searched_for_says_so() -> None:
    """One wrong sign among many terms that are zero together: few enough to be edited, or too
    many.
    """
    zeros = [sp.sin(k * a) ** 2 + sp.cos(k * a) ** 2 - 1 for k in range(1, 1301)]
    long, too_long = (
        judge_unclaimed(2 * a * u + b * sp.cos(v) + sp.Add(*zeros[:count])) for count in (200, 1300)
    )
    assert (long.verdict, too_long.verdict) == ("misprint", "contradicted")
    assert [str(text) for (text,) in long.corrections] == ["sign of -test_b*cos(test_v)"]
    assert "not searched" in too_long.finding
    assert "not searched" not in judge_unclaimed(3 * a * u - 5 * b).finding


def test_lacking_term_is_named() -> None:
    """The term is added to the residual, and to what a definition gives its symbol."""
    residual, definition = (
        judge_unclaimed(-b * sp.cos(v)),
        judge_unclaimed(-b * sp.cos(v), defines=True),
    )
    assert residual.verdict == definition.verdict == "incomplete"
    assert (residual.missing, definition.missing) == ((-2 * a * u,), (2 * a * u,))
    assert "2*test_a*test_u" in str(definition.finding)
    for judgement in (residual, definition):
        assert judgement.corrected is not None
        assert all(abs(point(judgement.corrected.residual)) < 1e-40 for point in list_points())


def test_two_lacking_terms_are_not_named() -> None:
    assert judge_unclaimed(c * sp.sin(u)).verdict == "contradicted"


def test_edit_to_a_tautology_is_no_correction() -> None:
    assert "test_F for" not in str(judge_unclaimed(sp.Integer(3) * c).corrections)


def test_equation_without_value_is_untested() -> None:
    nowhere = quantity("test_nowhere")
    printed = Equation("1", FORCE - nowhere, "test", UNCLAIMED)
    assert judge_by_values(printed, tuple(list_points()), WORDS).finding.startswith(
        "test_nowhere has no value"
    )
    condition = Equation("1", FORCE - a, "test", UNCLAIMED, relation="<")
    assert judge_by_values(condition, tuple(list_points()), WORDS).verdict == "untested"
