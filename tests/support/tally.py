"""How the audit fares with planted errors and harmless rewrites:
`python -m tests.support.tally [PAPER] [COUNT]`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import sympy as sp

from derive.audit.judge import Judgement
from tests.support import mutations
from tests.support.mutations import CASES, Mutant, judge_alone, outcome, untouched
from tests.support.rewrites import PLACES_KEPT, REWRITES


@dataclass(frozen=True)
class Tally:
    """Planted errors that change what is found; those in sound equations, and how many are told
    exactly; rewrites.
    """

    planted: int
    noticed: int
    in_sound: int
    corrected: int
    rewritten: int
    accused: int


def tally(paper: str, count: int) -> Tally:
    """The counts of one paper for so many planted errors."""
    errors = mutations.mutants(paper, count)
    sound = [
        m
        for m in errors
        if mutations.is_sound(paper, CASES[paper].paper.equations[m.equation.number])
    ]
    neutral = [
        (name, n)
        for name in REWRITES
        for n in mutations.derivable(paper)
        if _is_neutral(paper, name, n)
    ]
    return Tally(
        planted=len(errors),
        noticed=sum(is_noticed(paper, m) for m in errors),
        in_sound=len(sound),
        corrected=sum(is_told(paper, m) for m in sound),
        rewritten=len(neutral),
        accused=sum(is_accused(paper, name, n) for name, n in neutral),
    )


def is_noticed(paper: str, mutant: Mutant) -> bool:
    return outcome(judge_alone(paper, mutant.equation)) != outcome(
        untouched(paper, mutant.equation.number)
    )


def is_told(paper: str, mutant: Mutant) -> bool:
    """Whether an error in a sound equation is told as what it is: its correction, or the very terms
    that are gone.
    """
    judgement = judge_alone(paper, mutant.equation)
    if judgement.corrections and not judgement.missing and not judgement.unexplained:
        return min(map(len, judgement.corrections)) <= mutant.errors
    return (
        judgement.verdict == "incomplete"
        and not judgement.corrections
        and _is_gone(paper, mutant, judgement)
    )


def _is_gone(paper: str, mutant: Mutant, judgement: Judgement) -> bool:
    """Whether the missing terms are what the planted error took away, but for a sign or factor on
    the whole.
    """
    case = CASES[paper]
    before, after = (
        mutations.read(paper, e)
        for e in (case.paper.equations[mutant.equation.number], mutant.equation)
    )
    taken, reported = before - after, sp.Add(*judgement.missing)
    ratios = {round(float(point(taken) / point(reported)), 9) for point in case.points}
    return len(ratios) == 1


def is_accused(paper: str, name: str, number: str) -> bool:
    """Whether a harmless rewrite changes the verdict."""
    rewritten = REWRITES[name](CASES[paper].paper.equations[number])
    return judge_alone(paper, rewritten).verdict != untouched(paper, number).verdict


def _is_neutral(paper: str, name: str, number: str) -> bool:
    """Whether a rewrite changes the text, of a faulty equation without changing the places of its
    faults.
    """
    equation = CASES[paper].paper.equations[number]
    comparable = name in PLACES_KEPT or mutations.is_sound(paper, equation)
    return comparable and REWRITES[name](equation) != equation


if __name__ == "__main__":
    papers = sys.argv[1].split(",") if len(sys.argv) > 1 else list(CASES)
    for paper in papers:
        print(paper, tally(paper, int(sys.argv[2]) if len(sys.argv) > 2 else 100), flush=True)
