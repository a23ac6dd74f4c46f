"""The audit's parts: terms and their matching, edits, values at points."""

from collections.abc import Iterable, Iterator

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mpf
from sympy.core.relational import Relational

from derive.audit.case import Case, find_directions
from derive.audit.comparison import Comparison, _simple_ratio, find_missing_terms
from derive.audit.edits import Edit, EditValues, is_computable, propose_edits
from derive.audit.terms import (
    Match,
    common_factor,
    evaluate_at,
    holds,
    match_sums,
    overall_factor,
    to_monomials,
)
from derive.equations import Equation
from derive.evaluate import DIGITS, NotEvaluated, Point, UnknownNodeError
from derive.quantity import Quantity
from tests.support.made_up import (
    POINTS,
    WORDS,
    MadeUpClaim,
    a,
    b,
    c,
    d,
    e,
    quantity,
    t,
    u,
    v,
    x,
    x_dot,
)
from tests.support.mutations import CASES

# terms

AT = tuple(POINTS)


Terms = tuple[sp.Expr, ...]


def list_edits(expr: sp.Expr, present: Iterable[sp.Symbol] = ()) -> Iterator[Edit]:
    """Apply each single edit of an expression."""
    return (proposal.apply(expr) for proposal in propose_edits(expr, WORDS, present=present))


def match_terms(printed: Terms, derived: Terms) -> Match:
    return match_sums(to_monomials(sp.Add(*printed), AT), to_monomials(sp.Add(*derived), AT))


SIXTH = sp.Rational(6, 25) * a * u


@pytest.mark.parametrize(
    ("printed", "derived", "left_printed", "left_derived"),
    [
        ((a * u, -b), (-b, a * u), (), ()),
        ((a * u, -b), (a * u,), (-b,), ()),
        ((a * sp.sin(sp.pi - u, evaluate=False),), (a * sp.sin(u),), (), ()),
        ((a * u,), (3 * a * u,), (), (2 * a * u,)),
        ((-a * u,), (a * u,), (-a * u,), (a * u,)),
        ((3 * a * u,), (a * u,), (3 * a * u,), (a * u,)),
        ((2 * a * u,), (3 * a * u,), (2 * a * u,), (3 * a * u,)),
        ((SIXTH,), (2 * a * u,), (SIXTH,), (2 * a * u,)),
    ],
)
def test_equal_terms_are_struck_out(
    printed: Terms, derived: Terms, left_printed: Terms, left_derived: Terms
) -> None:
    assert match_terms(printed, derived) == Match(left_printed, left_derived)


def test_a_remainder_can_vanish_as_a_whole() -> None:
    left = match_terms((a * sp.sin(u) ** 2, a * sp.cos(u) ** 2), (a,))
    assert left.size == 3
    assert left.vanishes(AT)
    assert not Match((a,), (b,)).vanishes(AT)


def test_complex_value_gives_no_number() -> None:
    assert evaluate_at(sp.asin(2 + u), POINTS[0]) is None
    assert evaluate_at(a, POINTS[0]) == POINTS[0](a)


def test_difference_counts_unmatched_terms() -> None:
    left = match_terms((a * u, -b, 2 * c, x_dot), (a * u, b, 4 * c, e))
    assert (len(left.printed), left.unlike, len(left.derived)) == (2, 1, 3)
    assert (left.size, left.unmatched) == (4, 5)


def test_content_is_the_common_factor_of_all_terms() -> None:
    assert common_factor(a**2 * u - a * b * u) == a * u
    assert common_factor((a - b) / c) == 1 / c
    assert common_factor(a + 2 * b) == 1


# edits

FORMULA = a * sp.sin(u) - b * sp.cos(v) + x_dot * t + c * sp.atan(u * v)


@pytest.mark.parametrize(
    "meant",
    [
        -FORMULA,
        2 * FORMULA,
        FORMULA - 2 * a * sp.sin(u),
        FORMULA - 2 * a * sp.sin(u) - 2 * x_dot * t,
        FORMULA + 2 * b * sp.cos(v),
        FORMULA + a * sp.sin(u),
        FORMULA - a * sp.sin(u) / 2,
        FORMULA + (sp.pi / 180 - 1) * a * sp.sin(u),
        FORMULA + (180 / sp.pi - 1) * a * sp.sin(u),
        FORMULA.xreplace({a: b}),
        FORMULA.xreplace({c: e}),
        FORMULA.xreplace({x_dot: x}),
        FORMULA.xreplace({u: v, v: u}),
        FORMULA.xreplace({u: v}),
        FORMULA.xreplace({sp.sin(u): sp.cos(u)}),
        FORMULA.xreplace({sp.cos(v): sp.sin(v)}),
        FORMULA.xreplace({sp.sin(u): sp.sin(u / 2)}),
        FORMULA.xreplace({sp.sin(u): sp.sin(sp.pi / 180 * u)}),
        FORMULA.xreplace({sp.atan(u * v): u * v}),
        FORMULA.xreplace({sp.atan(u * v): sp.atan(sp.atan(u * v))}),
        FORMULA - a * sp.sin(u),
        FORMULA.xreplace({sp.sin(u): sp.sin(u + v)}),
        FORMULA.xreplace({sp.sin(u): sp.sin(u - v)}),
    ],
)
def test_each_kind_of_edit_is_tried(meant: sp.Expr) -> None:
    assert any(sp.expand(edit.result - meant) == 0 for edit in list_edits(FORMULA, present=[v]))


@pytest.mark.parametrize(
    ("printed", "meant"),
    [
        (a * (b + c - e), a * (b + c)),
        (a * sp.sin(u + v - t / t), a * sp.sin(u - v + 1)),
        (a * sp.sqrt(2 * u), a * sp.sqrt(u)),
        (a * (x_dot + b / t) ** 2, a * x_dot**2),
    ],
)
def test_edits_inside_a_bracket(printed: sp.Expr, meant: sp.Expr) -> None:
    """A summand too many, the sign of a group, a factor on one."""
    assert any(sp.expand(edit.result - meant) == 0 for edit in list_edits(printed))


def test_conditions_are_exchanged() -> None:
    cases = sp.Piecewise((a * u, v < 0), (2 * b, True))
    assert sp.Piecewise((2 * b, v < 0), (a * u, True)) in {
        edit.result for edit in list_edits(cases)
    }


def test_every_edit_differs_from_the_original() -> None:
    for edit in list_edits(FORMULA):
        assert edit.result != FORMULA, edit.text
        assert any(abs(p(edit.result) - p(FORMULA)) > mpf(10) ** -40 for p in POINTS), edit.text


BENT = (
    (a * sp.sin(u) - b) * (c + e * sp.sqrt(u * v)) / d
    + sp.Max(a, b) * sp.Abs(c - e) ** 3
    - sp.atan2(a, -b) * x
)


@pytest.mark.parametrize("formula", [FORMULA, BENT, a * sp.sin(u) * (b - c), sp.tan(u) + a])
def test_values_of_edits_are_those_of_their_results(formula: sp.Expr) -> None:
    assert is_computable(formula)
    proposals = list(propose_edits(formula, WORDS, present=[v]))
    values = list(EditValues(formula, POINTS).list_values(proposals))
    assert [proposal for proposal, _, _ in values] == proposals
    for proposal, at_points, sizes in values:
        result = proposal.apply(formula).result
        for point, value, size in zip(POINTS, at_points, sizes, strict=True):
            exact = evaluate_at(result, point)
            assert (
                np.isnan(value)
                if exact is None
                else value == pytest.approx(float(exact), rel=1e-12, abs=1e-14)
            )
            largest = max(
                abs(evaluate_at(summand, point) or 0) for summand in sp.Add.make_args(result)
            )
            assert (
                exact is None or size >= 0.49 * largest
            )  # two equal summands become one of twice the size


def test_floating_point_lacks_functions_of_tables() -> None:
    assert not is_computable(a + sp.Function("odd")(b))


def test_symbols_are_mistaken_for_those_of_their_dimension_only() -> None:
    texts = {edit.text for edit in list_edits(a * u - b * u)}
    assert f"{c} for {a}" in texts
    assert f"{t} for {a}" not in texts
    assert f"{t} for {a}" in {edit.text for edit in list_edits(a + u)}


def test_missing_summand_has_the_bracket_dimension() -> None:
    results = {edit.result for edit in list_edits(a * sp.sin(u), present=[v, t])}
    assert a * sp.sin(u + v) in results
    assert a * sp.sin(u + t) not in results


@pytest.mark.parametrize(("second", "factor"), [(6, 2), (5, None)])
def test_factor_must_hold_at_every_point(second: int, factor: int | None) -> None:
    points = (Point({a: 4, b: 2}), Point({a: second, b: 3}))
    assert _simple_ratio(Comparison(a, b, points), a, b) == factor


@pytest.mark.parametrize("terms", [(-b * v,), (-b * v, c * sp.cos(u)), ()])
def test_missing_terms_do_not_depend_on_notation(terms: tuple[sp.Expr, ...]) -> None:
    printed, same = a * sp.sin(u) * sp.cos(u), a * sp.sin(2 * u) / 2
    assert set(find_missing_terms(Comparison(printed, sp.Add(same, *terms), AT), WORDS)) == set(
        terms
    )


# directions

p, q = quantity("test_p", "rad"), quantity("test_q", "rad")


def turning(*residuals: sp.Expr, defines: Quantity | None = None) -> set[Quantity]:
    return set(
        find_directions(
            [Equation("n", r, "test", MadeUpClaim.SUM, defines=defines) for r in residuals]
        )
    )


def test_periodic_angle_is_a_direction() -> None:
    assert turning(a * sp.sin(p) + b * sp.cos(2 * p + u) - c) == {p}
    assert turning(sp.Piecewise((a * sp.sin(p), u > 0), (b * sp.tan(p), True))) == {p}
    assert turning(a * sp.sin(p) - b * sp.cos(q), c * q) == {p}
    assert turning(a * sp.sin(2 * (p + u)) - b) == {p}
    assert turning(a * sp.sin(u)) == set()


@pytest.mark.parametrize(
    "counted",
    [
        a * sp.sin(p / 2),
        a * p + b * sp.sin(p),
        p**2 - sp.cos(p),
        sp.Piecewise((p, u > 0), (sp.sin(p), True)),
    ],
)
def test_counted_angle_is_not_a_direction(counted: sp.Expr) -> None:
    assert turning(counted) == set()


def test_a_direction_may_be_defined_by_another() -> None:
    assert turning(q - 2 * p - 1, sp.cos(q) - sp.sin(p), defines=q) == {p, q}
    assert turning(q - p / 2, sp.cos(q) - sp.sin(p), defines=q) == {q}
    cases = sp.Piecewise((p - sp.pi, u > 0), (p, True))
    assert turning(q - cases, sp.cos(q) - sp.sin(p), defines=q) == {p, q}


# values at points


@pytest.mark.parametrize(
    "expr",
    [
        FORMULA,
        sp.sqrt(a / b) ** 3,
        sp.Abs(a - b),
        sp.atan2(-a, -b),
        sp.exp(u) * sp.log(1 + v),
        sp.Min(a, b, c),
        sp.pi * a,
        sp.Piecewise((a, u > v), (b, True)),
        sp.acos(u / 2) + sp.tan(v),
        sp.Rational(1, 3) * sp.cosh(u),
        sp.floor(7 * u),
    ],
)
def test_values_have_fifty_digits(expr: sp.Expr) -> None:
    point = POINTS[0]
    values_by_symbol = {s: sp.Rational(mpmath.nstr(point(s), 12)) for s in WORDS}
    expected = sp.N(expr.subs(values_by_symbol), DIGITS + 10)
    with mpmath.workdps(DIGITS + 10):
        assert abs(point(expr) - mpf(str(expected))) <= mpf(10) ** -DIGITS * abs(mpf(str(expected)))


def test_missing_values_raise_with_their_names() -> None:
    with pytest.raises(NotEvaluated, match="nowhere has no value"):
        POINTS[0](quantity("nowhere") + a)
    with pytest.raises(NotEvaluated, match="is not real"):
        POINTS[0](sp.sqrt(-a - b))
    with pytest.raises(UnknownNodeError, match="gamma cannot be evaluated"):
        POINTS[0](sp.gamma(u + sp.Rational(1, 3)))


@pytest.mark.parametrize(
    ("printed", "derived", "factor"),
    [
        (2 * a + 2 * b * u, a + b * u + c, 2),
        (2 * a + 2 * b * u - 2 * c, a + b * u + c, 2),
        (2 * a + b * u, a + b * u, 1),
        (2 * a, a, 1),
        (a, b, 1),
    ],
)
def test_overall_factor_is_common_to_most_terms(
    printed: sp.Expr, derived: sp.Expr, factor: int
) -> None:
    assert overall_factor(to_monomials(printed, AT), to_monomials(derived, AT)) == factor


# the points that the audit decides at


def one_sided(case: Case, points: list[Point]) -> set[str]:
    """Printed branch conditions that are the same at all points."""
    conditions: set[Relational] = set()
    for number, equation in case.paper.equations.items():
        if equation.legibility != "lost":
            for cases in case.pair(number)[0].residual.atoms(sp.Piecewise):
                conditions |= cases.atoms(Relational)
    return {str(c) for c in conditions if len({point.holds(c) for point in points}) == 1}


@pytest.mark.parametrize("name", CASES)
def test_every_printed_branch_is_taken_both_ways(name: str) -> None:
    assert one_sided(CASES[name], CASES[name].points) == set()
    assert one_sided(CASES["wang2017"], CASES["wang2017"].points[:1])


def test_residual_is_zero_only_beside_its_largest_term() -> None:
    gap = quantity("gap")
    residual = (a + b) * (a - b) + b**2 - a**2 + gap
    for size, is_zero in (("0", True), ("1e-50", True), ("1e-40", False), ("1e-20", False)):
        assert holds(residual, (Point({a: "0.3", b: "1.7", gap: size}),)) is is_zero
    assert not holds(gap - 2 * gap, (Point({gap: "1e-60"}),))
