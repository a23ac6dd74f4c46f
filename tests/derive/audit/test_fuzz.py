"""Every equation of an example paper, tried without its claim, changed in one place, and in symbols
of its own.

The audit never ends early, confirms nothing wrong, and accuses nothing right: whether a changed
equation is right is told by its values alone, on random mechanisms and along the example's own
turn.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache

import pytest
import sympy as sp

from derive.audit.case import Case
from derive.audit.comparison import solve_for
from derive.audit.edits import propose_edits
from derive.audit.judge import FAULTS
from derive.audit.paper import Paper
from derive.audit.record import Record
from derive.audit.terms import holds
from derive.audit.user_mechanism.trial import build_paper_chain
from derive.discovery import load_user_modules
from derive.equations import UNCLAIMED, Equation, what
from derive.quantity import Quantity
from tests.support import own
from tests.support.made_up import record_equation

PAPERS = sorted(path.stem for path in own.EXAMPLES.glob("*_paper.py"))
NUMBERS = [(paper, number) for paper in PAPERS for number in "123456"]
SAMPLE = [
    pytest.param(paper, number, marks=() if number in "14" else pytest.mark.long)
    for paper, number in NUMBERS
]
"""All of them, those outside a fast run marked."""
FEW, MANY = 1, 40
"""Changes of each equation that are tried in a fast run, and in a long one."""


@cache
def example(name: str) -> Case:
    with load_user_modules(own.EXAMPLES / f"{name}.py") as (module,):
        case: Case = module.CASE
    return case


def alone(
    case: Case, printed: Equation, reading: Mapping[sp.Symbol, sp.Expr] | None = None
) -> Record:
    """The record of one equation of a paper; points are those of the example."""
    paper = replace(case.paper, equations={printed.number: printed}, reading=dict(reading or {}))
    single = replace(case, paper=paper)
    shared = {name: getattr(case, name) for name in ("points", "cycle", "claims")}
    single.__dict__.update(shared)
    return record_equation(single, printed.number)


def unclaimed(printed: Equation) -> Equation:
    return replace(printed, claims=UNCLAIMED)


def is_right(case: Case, printed: Equation) -> bool:
    return holds(printed.residual, (*case.points, *case.cycle))


def changed(case: Case, printed: Equation, count: int, seed: int) -> Iterator[tuple[str, Equation]]:
    """An equation with a sign, a factor, a function or a symbol exchanged: what is changed, and the
    result.
    """
    symbol = printed.defines
    expression = printed.residual if symbol is None else solve_for(printed.residual, symbol)
    proposals = propose_edits(expression, case.words, overall=False)
    edits = [proposal.apply(expression) for proposal in proposals]
    candidates = [edit for edit in edits if edit.result.free_symbols - {symbol}]
    for edit in random.Random(seed).sample(candidates, min(count, len(candidates))):
        yield (
            str(edit.text),
            replace(printed, residual=edit.result if symbol is None else symbol - edit.result),
        )


@pytest.mark.parametrize(("paper", "number"), NUMBERS)
def test_equation_without_claim_is_judged_by_values(paper: str, number: str) -> None:
    case = example(paper)
    printed = case.paper.equations[number]
    judged_record, claimed = alone(case, unclaimed(printed)), alone(case, printed)
    assert (
        (judged_record["verdict"] == "confirmed")
        is (claimed["verdict"] == "confirmed")
        is is_right(case, printed)
    )
    assert judged_record["verdict"] == "confirmed" or (
        judged_record["verdict"] in FAULTS and judged_record["reasons"]
    )


@pytest.mark.parametrize(("paper", "number"), SAMPLE)
def test_foreign_symbols_change_no_verdict(paper: str, number: str) -> None:
    """Mapped, they are read as what they stand for; unmapped, nothing is known of them."""
    case = example(paper)
    printed = case.paper.equations[number]
    symbols = sorted((s for s in printed.residual.free_symbols if isinstance(s, Quantity)), key=str)
    names = {
        s: case.paper.symbol(f"Q_{k}", s.unit, "a symbol of the paper")
        for k, s in enumerate(symbols)
    }
    defines = None if printed.defines is None else names[printed.defines]
    foreign = replace(printed, residual=printed.residual.xreplace(names), defines=defines)
    back = {name: symbol for symbol, name in names.items()}
    for own_one, foreign_one, lost in (
        (printed, foreign, "not judged"),
        (unclaimed(printed), unclaimed(foreign), "untested"),
    ):
        expected, judged_record = alone(case, own_one), alone(case, foreign_one, back)
        assert [judged_record[key] for key in ("verdict", "correction")] == [
            expected[key] for key in ("verdict", "correction")
        ]
        assert alone(case, foreign_one)["verdict"] == lost


def check_changes(paper: str, number: str, count: int) -> None:
    case = example(paper)
    for change, printed in changed(case, case.paper.equations[number], count, seed=int(number)):
        right = is_right(case, printed)
        for variant in (printed, unclaimed(printed)):
            judged_record = alone(case, variant)
            assert (judged_record["verdict"] == "confirmed") is right, (
                change,
                judged_record["finding"],
            )
            assert right or judged_record["verdict"] in FAULTS, (change, judged_record["finding"])


@pytest.mark.parametrize(("paper", "number"), SAMPLE)
def test_changed_equation_is_faulted(paper: str, number: str) -> None:
    check_changes(paper, number, FEW)


@pytest.mark.long
@pytest.mark.parametrize(("paper", "number"), NUMBERS)
def test_every_changed_equation_is_faulted(paper: str, number: str) -> None:
    check_changes(paper, number, MANY)


def test_unevaluable_equation_does_not_affect_laws() -> None:
    case = example("slider_crank_paper")
    subject = case.subject
    paper = replace(case.paper, equations=dict(case.paper.equations))
    before = build_paper_chain(paper, subject)  # type: ignore[arg-type]
    paper.equation("odd", next(iter(case.words)) - sp.Function("odd")(case.words[-1]))
    assert build_paper_chain(paper, subject).equations == before.equations  # type: ignore[arg-type]


# rates and accelerations


def symbols(case: Case) -> dict[str, Quantity]:
    mechanism = case.subject.mechanism  # type: ignore[attr-defined]
    return {str(q): q for q in (*mechanism.loops.all, *mechanism.given.values(), *case.words)}


RATES = [
    ("beta_dot", "-omega*r*cos(phi)/(l*cos(beta))", "confirmed"),
    ("beta_dot", "-omega*r*cos(phi)/(s - r*cos(phi))", "confirmed"),
    ("beta_dot", "omega*r*cos(phi)/(l*cos(beta))", "misprint"),
    ("beta_dot", "-omega*r*sin(phi)/(l*cos(beta))", "misprint"),
    ("s_dot", "-omega*r*sin(phi) - l*beta_dot*sin(beta)", "confirmed"),
    ("s_dot", "-omega*r*sin(phi - beta)/cos(beta)", "confirmed"),
    ("s_dot", "-omega*r*sin(phi + beta)/cos(beta)", "misprint"),
    ("beta_ddot", "(omega**2*r*sin(phi) + l*beta_dot**2*sin(beta))/(l*cos(beta))", "confirmed"),
    ("beta_ddot", "omega**2*r*sin(phi)/(l*cos(beta))", "incomplete"),
    (
        "a_rod_x",
        "-omega**2*r*cos(phi) - c*beta_dot**2*cos(beta) - c*beta_ddot*sin(beta)",
        "confirmed",
    ),
    ("a_rod_x", "-omega**2*r*cos(phi) - c*beta_dot**2*cos(beta)", "incomplete"),
]
"""What is printed of a rate or an acceleration, and the verdict."""


@pytest.mark.parametrize(("name", "text", "verdict"), RATES)
def test_rates_and_accelerations_may_be_claimed(name: str, text: str, verdict: str) -> None:
    case = example("slider_crank_paper")
    symbols_by_name = symbols(case)
    printed = sp.sympify(text, locals=symbols_by_name)
    assert printed.free_symbols <= set(symbols_by_name.values())
    paper = Paper("rates", "Rates")
    paper.defines("1", symbols_by_name[name], printed, what(name))
    judged_record = alone(case, paper.equations["1"])
    assert judged_record["verdict"] == verdict, judged_record["finding"]
    assert judged_record["claims"] == f"what {name} is"
