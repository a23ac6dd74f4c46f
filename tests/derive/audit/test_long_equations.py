"""Equations of more than a thousand operations: an error in one of hundreds of terms is found and
put back.
"""

from __future__ import annotations

from functools import cache

import pytest
import sympy as sp
from sympy import Expr

from derive import Mechanism, quantities
from derive.audit.case import Case
from derive.audit.judge import MOST_OPERATIONS, Judgement, judge_equation
from derive.audit.paper import Paper
from derive.audit.user_mechanism.trial import trial
from derive.equations import UNCLAIMED, Claimed, Equation, derived_equation
from tests.support.made_up import MadeUpClaim

LINKS = 6


@cache
def build_chain() -> Case:
    """A hanging chain of point masses, its joint angles relative to the link before."""
    rows = [
        f"m_{i} | kg | mass {i} | {1 + i / 10}\n l_{i} | m | link {i} | {1 - i / 10}"
        for i in range(1, LINKS + 1)
    ]
    q = quantities("g | m/s2 | free fall | 9.8\n" + "\n".join(rows))
    m = Mechanism("long_chain", q, gravity=q.g)
    end, body, angles = m.O, m.ground, list[Expr]()
    for i in range(1, LINKS + 1):
        angles.append(m.coordinate(f"theta_{i}", "rad", "angle of a link from the one before it"))
        frame = m.frame(f"link_{i}", sp.Add(*angles))
        tip = m.point(f"P_{i}", end, frame, 0, -getattr(q, f"l_{i}"))
        link = m.body(f"link_{i}", frame, getattr(q, f"m_{i}"), tip)
        m.pin(f"joint_{i}", link, body, end)
        end, body = tip, link
    return trial(m, Paper("chain", "A chain"), 0.1)


def write_balance() -> Expr:
    """Return the moments about the first joint: weights, and inertia by cosines and sines of angles
    between links.
    """
    named = {symbol.name: symbol for point in build_chain().points for symbol in point.values()}
    links = range(1, LINKS + 1)
    angle, rate, acceleration = (
        {i: sp.Add(*(named[f"theta_{k}{dots}"] for k in range(1, i + 1))) for i in links}
        for dots in ("", "_dot", "_ddot")
    )
    terms = [
        named[f"m_{k}"] * named["g"] * named[f"l_{i}"] * sp.sin(angle[i])
        for k in links
        for i in range(1, k + 1)
    ]
    for k in links:
        for i in range(1, k + 1):
            for j in range(1, k + 1):
                between = angle[i] - angle[j]
                inertia = sp.cos(between) * acceleration[j] + sp.sin(between) * rate[j] ** 2
                terms.append(
                    sp.expand(
                        named[f"m_{k}"] * named[f"l_{i}"] * named[f"l_{j}"] * inertia, deep=False
                    )
                )
    return sp.Add(*terms)


def judge(printed: Expr, derived: Expr | None = None) -> Judgement:
    case = build_chain()
    claim: Claimed = UNCLAIMED if derived is None else MadeUpClaim.SUM
    meant = None if derived is None else derived_equation(claim, derived)
    return judge_equation(Equation("1", printed, "test", claim), meant, case.points, case.words)


def find_term(balance: Expr) -> Expr:
    """Return a term of five factors, a sum of accelerations among them."""
    return next(
        t
        for t in balance.args
        if len(t.args) == 5 and t.has(sp.cos) and any(f.is_Add for f in t.args)
    )


def test_long_equation_is_confirmed() -> None:
    balance = write_balance()
    assert sp.count_ops(balance) > MOST_OPERATIONS
    assert judge(balance).verdict == judge(balance, balance).verdict == "confirmed"


@pytest.mark.parametrize("is_derived", [False, True])
def test_flipped_sign_in_a_long_equation_is_put_back(is_derived: bool) -> None:
    balance = write_balance()
    term = find_term(balance)
    judgement = judge(balance - 2 * term, balance if is_derived else None)
    assert judgement.verdict == "misprint"
    assert (f"sign of {-term}",) in [
        tuple(map(str, correction)) for correction in judgement.corrections
    ]
    assert judgement.corrected is not None
    assert judgement.corrected.residual == balance


@pytest.mark.parametrize("is_derived", [False, True])
def test_lost_term_of_a_long_equation_is_put_back(is_derived: bool) -> None:
    balance = write_balance()
    term = find_term(balance)
    judgement = judge(balance - term, balance if is_derived else None)
    assert judgement.verdict == "incomplete"
    assert judge(balance - term + sp.Add(*judgement.missing), balance).verdict == "confirmed"


def test_two_errors_in_a_long_equation_are_contradicted() -> None:
    balance = write_balance()
    first, second = balance.args[3], balance.args[40]
    assert judge(balance - 2 * first - second).verdict == "contradicted"
