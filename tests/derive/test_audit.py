"""The audit's parts on small made-up equations, and that it knows no paper."""

import ast
import random
import re
from dataclasses import replace
from pathlib import Path

import mpmath
import pytest
import sympy as sp
from mpmath import mpf

import derive.audit
from derive.audit.edits import edits
from derive.audit.judge import Judgement, judge
from derive.audit.terms import Match, expanded, matched, remainder_vanishes, value
from derive.dimensions import _BASE
from derive.equations import Equation, Relation
from derive.evaluate import DIGITS, NotEvaluated, Point
from derive.paper import Paper
from derive.pipeline import TRIALS
from derive.quantity import Quantity
from tests.support.mutations import derivable, is_sound, outcome, subject, untouched

SOURCES = sorted(Path(derive.audit.__path__[0]).glob("*.py"))
TRANSCRIBED = sorted(p for folder in ("papers", "systems") for p in (SOURCES[0].parents[1] / folder).glob("*.py"))


def _quantity(name: str, unit: str = "m") -> Quantity:
    return Quantity(name, unit, "made up", "test")


a, b, c, d, e = (_quantity(f"test_{n}") for n in "abcde")
u, v, t = _quantity("test_u", "1"), _quantity("test_v", "1"), _quantity("test_t", "s")
x, x_dot = _quantity("testx"), _quantity("testx_dot", "m/s")
WORDS = [a, b, c, d, e, u, v, t, x, x_dot]


def _point(seed: int) -> Point:
    rng = random.Random(seed)
    return Point({s: sp.Rational(rng.randint(10**9, 10**10), 10**10) for s in WORDS})


POINTS = [_point(seed) for seed in (1, 2, 3)]


def _judged(printed: sp.Expr, derived: sp.Expr, relations: tuple[Relation, Relation] = ("=", "=")) -> Judgement:
    first, second = (
        Equation("n", r, "test", "made up", relation=k) for r, k in zip((printed, derived), relations, strict=True)
    )
    return judge(first, second, POINTS, WORDS)


# verdict words


def test_confirmed_however_it_is_written() -> None:
    assert _judged(
        (a + b) ** 2 - c**2 * sp.sin(u) ** 2, a**2 + 2 * a * b + b**2 + c**2 * (sp.cos(u) ** 2 - 1)
    ) == Judgement("confirmed", "no difference left")


def test_confirmed_with_the_sides_exchanged() -> None:
    assert _judged(b - a, a - b).verdict == "confirmed"
    assert _judged(b - a, a - b, (">", "<")).verdict == "confirmed"
    assert _judged(a - b, a - b, ("<", "<")).verdict == "confirmed"


def test_misprint_with_its_only_correction() -> None:
    found = _judged(a * sp.sin(u) + b * t / t - c, a * sp.cos(u) + b - c)
    assert (found.verdict, found.corrections) == ("misprint", ((f"cos for sin of {u}",),))


def test_misprint_with_two_edits() -> None:
    found = _judged(a * sp.sin(u) - b * sp.exp(v) + c, a * sp.cos(u) + b * sp.exp(v) + c)
    assert found.verdict == "misprint"
    assert (f"cos for sin of {u}", f"sign of {-b * sp.exp(v)}") in found.corrections
    assert {len(edit) for edit in found.corrections} == {2}


def test_every_smallest_correction_is_listed() -> None:
    found = _judged(a * u + a * v - c, b * u + b * v - c)
    assert found.corrections == ((f"{b} for {a} throughout",),)
    found = _judged(a * sp.cos(u - v) - c, a * sp.cos(u + v) - c)
    assert {(f"sign of {u}",), (f"sign of {-v}",)} <= set(found.corrections)


def test_a_wrong_relation_is_part_of_every_correction() -> None:
    assert _judged(a - b, a - b, ("<", ">")).corrections == (("> for <",),)
    assert _judged(a - b, a - b, ("<", "<=")).corrections == (("<= for <",),)
    found = _judged(a - b * sp.sin(u), a - b * sp.cos(u), ("<", ">"))
    assert found.verdict == "misprint"
    assert ("> for <", f"cos for sin of {u}") in found.corrections


def test_incomplete_with_the_missing_terms() -> None:
    found = _judged(a - b, a - b - c * u - 3 * d * v)
    assert (found.verdict, set(found.missing)) == ("incomplete", {-c * u, -3 * d * v})


def test_incomplete_after_an_edit() -> None:
    found = _judged(a - b * sp.sin(u), a - b * sp.cos(u) - c * u - d * v)
    assert (found.verdict, set(found.missing)) == ("incomplete", {-c * u, -d * v})
    assert found.corrections == ((f"cos for sin of {u}",),)


def test_contradicted_where_nothing_explains_a_printed_term() -> None:
    found = _judged(a - b * sp.exp(u) * u**3, a - c * sp.log(1 + v) - d)
    assert found.verdict == "contradicted"
    assert found.unexplained == (-b * sp.exp(u) * u**3,)


def test_reconstructed_and_definition() -> None:
    lost = Equation("n", sp.S.Zero, "test", "made up", "lost")
    assert judge(lost, replace(lost, residual=a), POINTS, WORDS).verdict == "reconstructed"
    assert judge(replace(lost, legibility="printed", residual=a - b), None, POINTS, WORDS).verdict == "definition"


@pytest.mark.parametrize("mixed", [a + t, a - b * t, sp.sin(a), a - b * x_dot])
def test_never_confirmed_when_dimensions_are_mixed(mixed: sp.Expr) -> None:
    found = _judged(mixed, mixed)
    assert found.verdict != "confirmed"
    assert "not dimensionally consistent" in found.finding


def test_a_printed_value_that_is_not_real_is_a_difference_and_no_crash() -> None:
    found = _judged(sp.asin(2 + u) - v, sp.asin(u) - v)
    assert found.verdict != "confirmed"
    found = _judged(sp.asin(2 * u / (u + v) + 1 / u) - v, sp.asin(u / (u + v)) - v)
    assert found.verdict != "confirmed"


def test_a_symbol_without_a_value_is_no_difference_but_an_error() -> None:
    with pytest.raises(NotEvaluated, match="nowhere has no value"):
        _judged(a - _quantity("nowhere"), a - b)


# terms


def test_equal_terms_are_struck_out() -> None:
    assert matched((a * u, -b), (-b, a * u), POINTS) == Match((), ())
    assert matched((a * u, -b), (a * u,), POINTS) == Match((-b,), ())


def test_terms_match_however_they_are_written() -> None:
    assert matched((a * sp.sin(sp.pi - u, evaluate=False),), (a * sp.sin(u),), POINTS).equal


def test_a_part_of_a_coefficient_that_is_missing() -> None:
    assert matched((a * u,), (3 * a * u,), POINTS) == Match((), (2 * a * u,))


def test_a_wrong_sign_and_a_coefficient_too_large_leave_both_terms() -> None:
    assert matched((-a * u,), (a * u,), POINTS) == Match((-a * u,), (a * u,))
    assert matched((3 * a * u,), (a * u,), POINTS) == Match((3 * a * u,), (a * u,))


def test_a_remainder_can_vanish_as_a_whole() -> None:
    left = matched((a * sp.sin(u) ** 2, a * sp.cos(u) ** 2), (a,), POINTS)
    assert not left.equal
    assert remainder_vanishes(left, POINTS)
    assert not remainder_vanishes(Match((a,), (b,)), POINTS)


def test_terms_of_nothing() -> None:
    assert expanded(sp.S.Zero) == ()
    assert set(expanded(a * (b - c))) == {a * b, -a * c}


def test_value_of_what_is_not_real() -> None:
    assert value(sp.asin(2 + u), POINTS[0]) is None
    assert value(a, POINTS[0]) == POINTS[0](a)


# edits

FORMULA = a * sp.sin(u) - b * sp.cos(v) + x_dot * t + c * sp.atan(u * v)


@pytest.mark.parametrize(
    "meant",
    [
        -FORMULA,
        2 * FORMULA,
        FORMULA - 2 * a * sp.sin(u),
        FORMULA + 2 * b * sp.cos(v),
        FORMULA + a * sp.sin(u),
        FORMULA - a * sp.sin(u) / 2,
        FORMULA + (sp.pi / 180 - 1) * a * sp.sin(u),
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
    ],
)
def test_each_kind_of_edit_is_tried(meant: sp.Expr) -> None:
    assert any(sp.expand(edit.result - meant) == 0 for edit in edits(FORMULA, WORDS))


def test_conditions_are_exchanged() -> None:
    cases = sp.Piecewise((a, u < 0), (b, True))
    assert sp.Piecewise((b, u < 0), (a, True)) in {edit.result for edit in edits(cases, WORDS)}


def test_every_edit_differs_from_the_original() -> None:
    for edit in edits(FORMULA, WORDS):
        assert edit.result != FORMULA, edit.what
        assert any(abs(p(edit.result) - p(FORMULA)) > mpf(10) ** -40 for p in POINTS), edit.what


def test_symbols_are_mistaken_for_those_of_their_dimension_only() -> None:
    texts = {edit.what for edit in edits(a * u - b * u, WORDS)}
    assert f"{c} for {a}" in texts
    assert f"{t} for {a}" not in texts
    assert f"{t} for {a}" in {edit.what for edit in edits(a + u, WORDS)}


# values at points


@pytest.mark.parametrize(
    "expr",
    [FORMULA, sp.sqrt(a / b) ** 3, sp.Abs(a - b), sp.atan2(-a, -b), sp.exp(u) * sp.log(1 + v), sp.Min(a, b, c),
     sp.pi * a, sp.Piecewise((a, u > v), (b, True)), sp.acos(u / 2) + sp.tan(v), sp.Rational(1, 3) * sp.cosh(u),
     sp.floor(7 * u)],
)  # fmt: skip
def test_values_have_fifty_digits(expr: sp.Expr) -> None:
    point = POINTS[0]
    known = {s: sp.Rational(mpmath.nstr(point(s), 12)) for s in WORDS}
    expected = sp.N(expr.subs(known), DIGITS + 10)
    with mpmath.workdps(DIGITS + 10):
        assert abs(point(expr) - mpf(str(expected))) <= mpf(10) ** -DIGITS * abs(mpf(str(expected)))


def test_values_that_do_not_exist_are_errors_that_name_them() -> None:
    with pytest.raises(NotEvaluated, match="nowhere has no value"):
        POINTS[0](_quantity("nowhere") + a)
    with pytest.raises(NotEvaluated, match="is not real"):
        POINTS[0](sp.sqrt(-a - b))
    with pytest.raises(NotEvaluated, match="gamma cannot be evaluated"):
        POINTS[0](sp.gamma(u + sp.Rational(1, 3)))


def test_a_new_value_of_a_symbol_is_used() -> None:
    point = Point({a: 2, b: 3})
    assert point(a * b) == 6
    point.set(a, 5)
    assert point(a * b) == 15


# no paper is known to the audit


def test_the_audit_names_no_paper_and_no_equation() -> None:
    names = {paper.PAPER.name for paper, _ in TRIALS}
    numbers = {n for paper, _ in TRIALS for n in paper.PAPER.equations} - set(_BASE)
    for path in SOURCES:
        text = path.read_text()
        assert not [n for n in names if n in text], path.name
        quoted = {
            n.value for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Constant) and isinstance(n.value, str)
        }
        assert not quoted & numbers, path.name


def test_no_verdict_stands_in_transcriptions_or_derivations() -> None:
    words = re.compile(r"\b(confirmed|misprint|incomplete|contradicted|reconstructed)\b", re.IGNORECASE)
    for path in TRANSCRIBED:
        assert not words.findall(path.read_text()), path.name


@pytest.mark.parametrize("name", [paper.PAPER.name for paper, _ in TRIALS])
def test_a_copy_under_another_name_with_other_numbers_gets_the_same_verdicts(name: str) -> None:
    own = subject(name)
    renamed = {number: f"copy {i}" for i, number in enumerate(own.paper.equations)}
    copied = {new: replace(own.paper.equations[old], number=new, source="copy") for old, new in renamed.items()}
    readings = {renamed[old]: reading for old, reading in own.readings.items()}
    copy = replace(own, paper=Paper("copy", "a copy", copied), readings=readings, derive_claims=lambda: own.claims)
    for number in _quick(name):
        found = judge(*copy.pair(renamed[number]), own.points, copy.words)
        assert outcome(found) == outcome(untouched(name, number)), number


def _quick(name: str) -> list[str]:
    return list(derivable(name))


def test_findings_and_corrections_do_not_stand_in_the_sources() -> None:
    texts = "\n".join(path.read_text() for path in TRANSCRIBED)
    for paper, _ in TRIALS:
        name = paper.PAPER.name
        for number in derivable(name):
            if not is_sound(name, subject(name).paper.equations[number]):
                for text in (edit for edits_ in untouched(name, number).corrections for edit in edits_):
                    assert text not in texts, text
