"""Equations without a claim: they hold of the subject's own values, or the smallest edit that makes
them is found.
"""

import pytest
import sympy as sp

from derive.audit.judge import Judgement, judge_by_values, judge_equation
from derive.equations import UNCLAIMED, Equation
from derive.evaluate import Point
from tests.support.made_up import WORDS, a, b, c, quantity, u, v, values

FORCE = quantity("test_F")


def points() -> list[Point]:
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


def judged(residual: sp.Expr, defines: bool = False) -> Judgement:
    symbol = FORCE if defines else None
    printed = Equation("1", FORCE - residual, "test", UNCLAIMED, defines=symbol)
    return judge_equation(printed, None, points(), [*WORDS, FORCE])


@pytest.mark.parametrize(
    "right", [2 * a * u - b * sp.cos(v), (4 * a * u - 2 * b * sp.sin(v + sp.pi / 2)) / 2]
)
def test_true_equation_is_confirmed_in_any_notation(right: sp.Expr) -> None:
    assert judged(right).verdict == judged(right, defines=True).verdict == "confirmed"


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
    judgement = judged(wrong, defines=True)
    assert judgement.verdict == "misprint"
    assert (correction,) in judgement.corrections


def test_uncorrectable_equation_is_contradicted_with_remainder() -> None:
    judgement = judged(3 * a * u - 5 * b)
    assert judgement.verdict == "contradicted"
    assert "is left of terms of up to" in judgement.finding


def test_error_that_was_not_searched_for_says_so() -> None:
    """One wrong sign among many terms that are zero together: few enough to be edited, or too
    many.
    """
    zeros = [sp.sin(k * a) ** 2 + sp.cos(k * a) ** 2 - 1 for k in range(1, 1301)]
    long, too_long = (
        judged(2 * a * u + b * sp.cos(v) + sp.Add(*zeros[:count])) for count in (200, 1300)
    )
    assert (long.verdict, too_long.verdict) == ("misprint", "contradicted")
    assert [str(text) for (text,) in long.corrections] == ["sign of -test_b*cos(test_v)"]
    assert "not searched" in too_long.finding
    assert "not searched" not in judged(3 * a * u - 5 * b).finding


def test_lacking_term_is_named() -> None:
    """The term is added to the residual, and to what a definition gives its symbol."""
    residual, definition = judged(-b * sp.cos(v)), judged(-b * sp.cos(v), defines=True)
    assert residual.verdict == definition.verdict == "incomplete"
    assert (residual.missing, definition.missing) == ((-2 * a * u,), (2 * a * u,))
    assert "2*test_a*test_u" in str(definition.finding)
    for judgement in (residual, definition):
        assert judgement.corrected is not None
        assert all(abs(point(judgement.corrected.residual)) < 1e-40 for point in points())


def test_two_lacking_terms_are_not_named() -> None:
    assert judged(c * sp.sin(u)).verdict == "contradicted"


def test_edit_to_a_tautology_is_no_correction() -> None:
    assert "test_F for" not in str(judged(sp.Integer(3) * c).corrections)


def test_equation_without_value_is_untested() -> None:
    nowhere = quantity("test_nowhere")
    printed = Equation("1", FORCE - nowhere, "test", UNCLAIMED)
    assert judge_by_values(printed, tuple(points()), WORDS).finding.startswith(
        "test_nowhere has no value"
    )
    condition = Equation("1", FORCE - a, "test", UNCLAIMED, relation="<")
    assert judge_by_values(condition, tuple(points()), WORDS).verdict == "untested"
