"""The audit can fail: errors planted in papers and derivations change its verdicts, harmless
rewrites do not.
"""

import random
import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import islice
from typing import Any

import pytest
import sympy as sp

from derive.audit.judge import Judgement, judge_equation
from derive.audit.terms import expand_sum
from derive.equations import Equation
from tests.support import mutations
from tests.support.errors import KINDS, REVERSED
from tests.support.mutations import CASES, judge_alone, outcome, untouched
from tests.support.rewrites import PLACES_KEPT, REWRITES
from tests.support.sampled import sampled

PLANTED = 16
"""Errors that are planted in each paper; the suite judges the first, the long tests the others and
many more.
"""
MANY = 120
DERIVATIONS = 4
PLANTED_IN_CONTRADICTED = 6
EXACT = 0.9
"""Share of the errors in sound equations that is told as what it is: the rest leaves no trace of
what stood there.
"""
PAPERS = tuple(CASES)


def on_some_papers(names: Iterable[str], step: int) -> list[Any]:
    """Return ways to rewrite with papers: all of them by -m long, in the suite each on one paper of
    `every`.
    """
    return [
        pytest.param(paper, name, marks=[pytest.mark.long] * bool((i + k) % step))
        for i, name in enumerate(names)
        for k, paper in enumerate(PAPERS)
    ]


REWRITTEN = on_some_papers(REWRITES, 2)
REWRITTEN_WHERE_FAULTY = on_some_papers(PLACES_KEPT, len(PAPERS))
PLACES = sampled([0], range(3))
"""Of the equations of a paper, drawn for each way to rewrite."""
SOUND = ("confirmed", "confirmed as rebuilt", "untested")


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("index", sampled([0], range(PLANTED)))
def test_planted_error_changes_the_finding(paper: str, index: int) -> None:
    mutant = mutations.mutants(paper, PLANTED)[index]
    before, after = untouched(paper, mutant.equation.number), judge_alone(paper, mutant.equation)
    assert outcome(after) != outcome(before), (
        f"({mutant.equation.number}) {mutant.kind}: {mutant.change}"
    )
    assert before.verdict not in SOUND or after.verdict not in SOUND


@pytest.mark.parametrize("index", sampled([0, 1], range(PLANTED_IN_CONTRADICTED)))
def test_planted_error_changes_a_contradicted_finding(index: int) -> None:
    planted = (
        (p, m)
        for p in PAPERS
        for m in mutations.mutants(p, PLANTED_IN_CONTRADICTED, mutations.contradicted(p))
    )
    paper, mutant = next(islice(planted, index, None))
    before, after = untouched(paper, mutant.equation.number), judge_alone(paper, mutant.equation)
    assert before.verdict == "contradicted"
    assert outcome(after) != outcome(before), (
        f"({mutant.equation.number}) {mutant.kind}: {mutant.change}"
    )


@pytest.mark.long
@pytest.mark.parametrize("paper", PAPERS)
def test_many_errors_are_explained_and_rewrites_ignored(paper: str) -> None:
    errors = mutations.mutants(paper, MANY)
    for error in errors:
        number = error.equation.number
        assert outcome(judge_alone(paper, error.equation)) != outcome(untouched(paper, number))
    sound = [error for error in errors if mutations.is_sound(paper, printed(paper, error))]
    assert sum(is_explained(paper, error) for error in sound) >= EXACT * len(sound)
    for name, rewrite in REWRITES.items():
        for number in mutations.derivable(paper):
            equation = CASES[paper].paper.equations[number]
            if name in PLACES_KEPT or mutations.is_sound(paper, equation):
                again = judge_alone(paper, rewrite(equation))
                assert again.verdict == untouched(paper, number).verdict, (name, number)


@pytest.mark.parametrize("paper", PAPERS)
def test_most_errors_are_explained_correctly(paper: str) -> None:
    planted = [
        m
        for m in mutations.mutants(paper, PLANTED)[::4]
        if mutations.is_sound(paper, printed(paper, m))
    ]
    explained = [m for m in planted if is_explained(paper, m)]
    assert len(explained) >= EXACT * len(planted) - 1, [
        (m.equation.number, m.change) for m in planted if m not in explained
    ]


def is_explained(paper: str, mutant: mutations.Mutant) -> bool:
    """Whether an error in a sound equation is told as what it is: its correction, or the very terms
    that are gone.
    """
    judgement = judge_alone(paper, mutant.equation)
    if judgement.corrections and not judgement.missing and not judgement.unexplained:
        return min(map(len, judgement.corrections)) <= mutant.errors
    if judgement.verdict != "incomplete" or judgement.corrections:
        return False
    before, after = (mutations.read(paper, e) for e in (printed(paper, mutant), mutant.equation))
    # up to a sign or factor on the whole
    taken, reported = before - after, sp.Add(*judgement.missing)
    points = CASES[paper].points
    return len({round(float(point(taken) / point(reported)), 9) for point in points}) == 1


def printed(paper: str, mutant: mutations.Mutant) -> Equation:
    return CASES[paper].paper.equations[mutant.equation.number]


def test_errors_of_every_kind_are_planted_in_some_paper() -> None:
    kinds = {m.kind for paper in PAPERS for m in mutations.mutants(paper, PLANTED)}
    assert kinds == set(KINDS)


@pytest.mark.parametrize(("paper", "name"), REWRITTEN)
@pytest.mark.parametrize("place", PLACES)
def test_rewrite_of_confirmed_equation_stays_confirmed(paper: str, name: str, place: int) -> None:
    for equation in _sample_equation(paper, name, place, sound=True):
        assert outcome(judge_alone(paper, REWRITES[name](equation))) == outcome(
            untouched(paper, equation.number)
        ), equation.number


@pytest.mark.parametrize(("paper", "name"), REWRITTEN_WHERE_FAULTY)
@pytest.mark.parametrize("place", PLACES)
def test_rewrite_of_faulty_equation_changes_only_positions(
    paper: str, name: str, place: int
) -> None:
    for equation in _sample_equation(paper, name, place, sound=False):
        before, after = (
            untouched(paper, equation.number),
            judge_alone(paper, REWRITES[name](equation)),
        )
        assert _shape(after) == _shape(before), equation.number


@pytest.mark.parametrize(
    "paper",
    [
        pytest.param(p, marks=pytest.mark.long if p in ("wang2017", "yu2023") else ())
        for p in PAPERS
    ],
)
def test_rewrites_are_harmless(paper: str) -> None:
    for name, rewrite in REWRITES.items():
        for equation in _derivable(paper, sound=True):
            other = rewrite(equation)
            if other.relation == equation.relation:
                assert not mutations.changes(paper, other), f"({equation.number}) {name}"


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("index", range(DERIVATIONS))
def test_an_error_in_the_derivation_is_never_confirmed(paper: str, index: int) -> None:
    rng = random.Random(f"{paper} {index} derived")
    chosen = rng.choice([e for e in _derivable(paper, sound=True) if _terms(paper, e)])
    printed, derived = CASES[paper].pair(chosen.number)
    assert derived is not None
    term = rng.choice(_terms(paper, chosen))
    for change in (term, 2 * term):
        spoiled = replace(derived, residual=sp.expand(derived.residual - change, trig=False))
        judgement = judge_equation(printed, spoiled, CASES[paper].points, CASES[paper].words)
        assert judgement.verdict not in SOUND, f"({chosen.number}) without {change}"


def _sample_equation(paper: str, name: str, place: int, sound: bool) -> list[Equation]:
    """One equation to rewrite in one way, if the paper has as many; the long tests rewrite all."""
    derivable = _derivable(paper, sound)
    return random.Random(f"{paper} {name}").sample(derivable, len(derivable))[place : place + 1]


def _derivable(paper: str, sound: bool) -> list[Equation]:
    equations = [CASES[paper].paper.equations[n] for n in mutations.derivable(paper)]
    return [e for e in equations if mutations.is_sound(paper, e) is sound]


def _terms(paper: str, equation: Equation) -> list[sp.Expr]:
    """Terms of the derivation but for the symbol that it defines."""
    derived = CASES[paper].pair(equation.number)[1]
    terms = [t for t in expand_sum(derived.residual) if t != derived.defines]
    return terms if derived.defines is not None or len(terms) > 1 else []


def _shape(judgement: Judgement) -> tuple[object, ...]:
    """A judgement without the texts of places."""
    kinds = {
        tuple(re.sub(r"(^sign of|on|of) .*", r"\1", _faced(edit)) for edit in c)
        for c in judgement.corrections
    }
    return judgement.verdict, kinds, len(judgement.missing), len(judgement.unexplained)


def _faced(edit: str) -> str:
    """A correction of a relation as it is for one order of the two sides."""
    meant, _, exchanged = edit.partition(" for ")
    return min(edit, f"{REVERSED[meant]} for {REVERSED[exchanged]}") if meant in REVERSED else edit
