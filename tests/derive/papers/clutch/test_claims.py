"""The clutch: its derivation as a set of claims, and its paper as printed."""

from __future__ import annotations

import random
from dataclasses import replace

import mpmath
import pytest

from derive.equations import Equation
from derive.papers.clutch import quantities as q
from derive.papers.clutch import subject as clutch
from derive.papers.shi2021 import PAPER
from tests.support.clutch import CLAIMS, derived, size, value
from tests.support.late import LateList

POINTS = LateList(lambda: [clutch.SUBJECT.admissible(random.Random(seed)) for seed in range(6)])
TOGETHER = "speed of body and shaft at the start, when they move together"
SPECIAL = {
    "angle between the faces at the least tip distance",
    "forces on the tooth without slip",
    TOGETHER,
}
HOLDS = {
    "=": lambda v: abs(v) < mpmath.mpf(10) ** -40,
    "<": lambda v: v < 0,
    "<=": lambda v: v <= 0,
    ">": lambda v: v > 0,
    ">=": lambda v: v >= 0,
}


def broken(claims: dict[str, Equation], point: clutch.Values) -> set[str]:
    return {
        c
        for c, e in claims.items()
        if not HOLDS[e.relation](value(e.residual, point) / size(e.residual, point))
    }


@pytest.mark.parametrize("place", range(6))
def test_admissible_points_obey_the_derivation(place: int) -> None:
    point = POINTS[place]
    assert broken(CLAIMS, point) == SPECIAL
    needed = set().union(
        *(e.residual.free_symbols for e in (*CLAIMS.values(), *PAPER.equations.values()))
    )
    assert {s.name for s in needed - point.keys()} == {"unread"}


def test_special_states_obey_their_equations() -> None:
    """Faces at the least tip distance; balance of the forces along the surface when F_y is what
    holds the tooth.
    """
    point = dict(POINTS[0])
    with mpmath.workdps(60):
        point[q.b1] -= value(CLAIMS["tooth tips go round the shaft"].residual, point)
        point[q.xi] = value(derived("angle between the faces of a tooth"), point)
        point[q.F_y] -= value(CLAIMS["forces on the tooth without slip"].residual, point)
        point[q.v_0] -= value(CLAIMS[TOGETHER].residual, point)
        assert abs(value(derived("acceleration of the slip"), point)) < mpmath.mpf(10) ** -45
    assert SPECIAL.isdisjoint(broken({c: CLAIMS[c] for c in SPECIAL}, point))


def test_the_reference_cycle_obeys_the_derivation() -> None:
    """What it breaks are conditions: the paper's tip distance, rounded down, and no slip at either
    end of contact.
    """
    for i, point in enumerate(clutch.SUBJECT.reference(5)):
        unmet = broken(CLAIMS, point) - SPECIAL
        assert unmet - {"load at which the tooth slips"} == {"tooth tips go round the shaft"}, i
        assert (point[q.N] > 1e-6) == (i < 4)


def test_a_tampered_derivation_is_noticed() -> None:
    equation = CLAIMS["contact load over time"]
    tampered = {"x": replace(equation, residual=equation.residual.subs(q.m1, 2 * q.m1))}
    assert broken(tampered, POINTS[0]) == {"x"}
