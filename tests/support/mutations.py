"""Printed equations on trial with an error planted in them, each proven to change what is said."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from derive import papers
from derive.audit.case import AS_READ, Case
from derive.audit.comparison import align_sides
from derive.audit.judge import Judgement
from derive.audit.paper import Paper, Question
from derive.audit.verdicts import find_cases
from derive.discovery import import_modules
from derive.equations import Equation
from derive.evaluate import DIGITS, NotEvaluated, Point
from derive.generated_folder import GENERATED
from derive.quantity import DimensionError, dimension
from tests.support.errors import KINDS
from tests.support.made_up import judge_number

CASES = {case.paper.name: case for case in find_cases(import_modules(papers)).values()}
SLOW = 20
"""Equations that are not confirmed and have more terms than this, both sides together, are slow to
judge.
"""
EQUAL = mpf(10) ** -42


@dataclass(frozen=True)
class Mutant:
    """A printed equation with one error in it, and what the error is."""

    kind: str
    change: str
    equation: Equation

    @property
    def errors(self) -> int:
        """How many errors it is made of."""
        return self.change.count(", ") + 1 if self.kind == "several" else 1


@cache
def judge_alone(name: str, equation: Equation) -> Judgement:
    """The judgement on an equation in the place of the printed one of its number."""
    open_questions = questions(name, equation.number)
    alone = replace(
        CASES[name].paper, equations={equation.number: equation}, questions=open_questions
    )
    return judge_number(_like(name, alone), equation.number)


def questions(name: str, number: str) -> list[Question]:
    """What a paper leaves open of one of its equations."""
    return [
        replace(q, numbers=(number,)) for q in CASES[name].paper.questions if number in q.numbers
    ]


def at_its_points(name: str, paper: Paper) -> Case:
    """The case of another paper with what the subject of a known one says, at the same points."""
    subject = CASES[name]
    case = replace(subject, paper=paper)
    vars(case).update(
        {key: getattr(subject, key) for key in ("claims", "points", "cycle", "nearby")}
    )
    return case


def _like(name: str, paper: Paper) -> Case:
    """The case of a paper with another text, of which it speaks in the same words."""
    case = at_its_points(name, paper)
    vars(case).update({key: getattr(CASES[name], key) for key in ("words", "directions")})
    return case


@cache
def untouched(name: str, number: str) -> Judgement:
    """The judgement on an equation as printed."""
    return judge_alone(name, CASES[name].paper.equations[number])


def outcome(
    judgement: Judgement,
) -> tuple[str, frozenset[tuple[str, ...]], frozenset[Expr], frozenset[Expr]]:
    """What has to change: verdict, corrections, terms that the print lacks or that have no
    explanation.
    """
    return (
        judgement.verdict,
        frozenset(judgement.corrections),
        frozenset(judgement.missing),
        frozenset(judgement.unexplained),
    )


def _pair(name: str, equation: Equation) -> tuple[Equation, Equation | None]:
    alone = replace(CASES[name].paper, equations={equation.number: equation})
    return _like(name, alone).pair(equation.number)


def read(name: str, equation: Equation) -> Expr:
    """The residual of an equation in the quantities that it is judged in."""
    return _pair(name, equation)[0].residual


@cache
def derivable(name: str) -> tuple[str, ...]:
    """Numbers of the equations that can be read, are derived and quick to judge with an error in
    them.

    Slow are those that are not confirmed and have many terms, or mix dimensions: there any symbol
    may be meant.
    """
    return tuple(
        n
        for n, e in CASES[name].paper.equations.items()
        if e.legibility != "lost" and _is_quick(name, e)
    )


def _is_quick(name: str, equation: Equation) -> bool:
    printed, derived = _pair(name, equation)
    if derived is None:
        return False
    few = sum(map(_size, (printed.residual, derived.residual))) <= SLOW
    return is_sound(name, equation) or (few and is_consistent(printed))


def _size(expr: Expr) -> int:
    return len(sp.Add.make_args(sp.expand(expr, trig=False)))


@cache
def is_sound(name: str, equation: Equation) -> bool:
    """Whether an equation is confirmed, found without judging it: its derivation gives the same at
    every point.
    """
    printed, derived = _pair(name, equation)
    if derived is None or printed.relation != derived.relation:
        return False
    return align_sides(
        printed, derived, tuple(CASES[name].points), printed.defines in CASES[name].directions
    ).same


def is_consistent(equation: Equation) -> bool:
    """Whether all terms of an equation have one dimension."""
    try:
        dimension(equation.residual)
    except DimensionError:
        return False
    return True


@cache
def contradicted(name: str) -> tuple[str, ...]:
    """Numbers of derivable equations in which something printed has no explanation, as the audit
    recorded it.
    """
    return tuple(n for n in derivable(name) if (name, n) in _contradicted())


@cache
def _contradicted() -> frozenset[tuple[str, str]]:
    recorded = json.loads((GENERATED / "audit.json").read_text(encoding="utf-8"))["equations"]
    return frozenset(
        (e["paper"], e["equation"]) for e in recorded if e["verdict"] == "contradicted"
    )


@cache
def mutants(name: str, count: int, among: tuple[str, ...] | None = None) -> tuple[Mutant, ...]:
    """Different errors in derivable equations of a paper, kind after kind, each proven to change
    what is said.
    """
    rng = random.Random(f"{name} {among}")
    pools = {kind: _pool(name, kind, derivable(name) if among is None else among) for kind in KINDS}
    for pool in pools.values():
        rng.shuffle(pool)
    chosen_mutants: list[Mutant] = []
    while len(chosen_mutants) < count and any(pools.values()):
        for pool in pools.values():
            chosen = next((m for m in _drained(pool) if changes(name, m.equation)), None)
            chosen_mutants += [chosen] if chosen and len(chosen_mutants) < count else []
    return tuple(chosen_mutants)


def _drained(pool: list[Mutant]) -> Iterator[Mutant]:
    while pool:
        yield pool.pop()


def _pool(name: str, kind: str, numbers: tuple[str, ...]) -> list[Mutant]:
    """Every error of a kind in equations of a paper."""
    case = CASES[name]
    return [
        Mutant(kind, change, mutated)
        for number in numbers
        for change, mutated in KINDS[kind](case.paper.equations[number], case.words)
        if is_sound(name, case.paper.equations[number]) or is_consistent(mutated)
    ]


def changes(name: str, equation: Equation) -> bool:
    """Whether an equation says something else than the printed one, at 50 digits at some admissible
    point.
    """
    printed = CASES[name].paper.equations[equation.number]
    if equation.relation != printed.relation:
        return True
    if is_right_somehow(name, equation):
        return False
    before, after = (_pair(name, e)[0].residual for e in (printed, equation))
    points = CASES[name].points
    factors = (
        [mpf(1)]
        if printed.defines
        else _factors(before, after, points[0], both=printed.relation == "=")
    )
    return all(any(_differs(p, before, after, factor) for p in points) for factor in factors)


def is_right_somehow(name: str, equation: Equation) -> bool:
    """Whether an equation is what is derived, under one of the readings that its paper admits or a
    whole turn on.

    One with a symbol that has no value counts as such: nothing can be said of it.
    """
    alone = replace(
        CASES[name].paper,
        equations={equation.number: equation},
        questions=questions(name, equation.number),
    )
    case = _like(name, alone)
    pairs = [
        case.pair(equation.number, choice) for choice in case.choices(equation.number) or [AS_READ]
    ]
    at = tuple(case.points)
    try:
        return any(
            d is not None and align_sides(p, d, at, p.defines in case.directions).same
            for p, d in pairs
        )
    except NotEvaluated:
        return True


def _factors(before: Expr, after: Expr, point: Point, both: bool) -> list[mpf]:
    """Factors on the whole that would change nothing: a sign, and the ratio at a point."""
    try:
        with mpmath.workdps(DIGITS):
            ratio = point(before) / point(after)
    except (NotEvaluated, ZeroDivisionError):
        ratio = mpf(1)
    return [f for f in (mpf(1), mpf(-1), ratio) if abs(f) > EQUAL and (both or f > 0)]


def _differs(point: Point, expression: Expr, other: Expr, factor: mpf) -> bool:
    first = point(expression)
    size = max(abs(point(t)) for t in sp.Add.make_args(expression))
    try:
        with mpmath.workdps(DIGITS):
            second = factor * point(other)
    except NotEvaluated:
        return all(s in point for s in other.free_symbols)
    return abs(first - second) > EQUAL * max(size, abs(second))
