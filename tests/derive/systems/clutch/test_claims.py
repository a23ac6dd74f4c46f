"""The clutch: its derivation as a set of claims, and its paper as printed."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import mpmath
import pytest
import sympy as sp

from derive.equations import Definition, Equation
from derive.papers.shi2021 import PAPER
from derive.quantity import DimensionError, Quantity, dimension
from derive.systems.clutch import motion
from derive.systems.clutch import quantities as q
from derive.systems.clutch import subject as clutch
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


def differing(equations: dict[str, Equation]) -> list[str]:
    """Numbers of the printed equations that are not the derived ones at 50 digits or in their
    relation.
    """
    differences = []
    for number_, printed in equations.items():
        ours = CLAIMS.get(str(printed.claims))
        if ours is None or printed.legibility == "lost":
            continue
        gap = printed.residual - ours.residual
        same = all(
            abs(value(gap, p)) < mpmath.mpf(10) ** -50 * size(printed.residual, p) for p in POINTS
        )
        if not (same and printed.relation == ours.relation):
            differences.append(number_)
    return differences


def test_every_symbol_is_described() -> None:
    equations = [*CLAIMS.values(), *PAPER.equations.values()]
    at_bearing = motion.bearing_conditions(q.x).values()
    symbols = set().union(
        *(e.residual.free_symbols for e in equations), *(e.free_symbols for e in at_bearing)
    )
    assert [s for s in symbols if not isinstance(s, Quantity)] == []
    assert not {s.name for s in vars(q).values() if isinstance(s, Quantity)} - {
        s.name for s in symbols
    }


def test_every_derived_equation_has_a_dimension() -> None:
    for equation in CLAIMS.values():
        dimension(equation.residual)


def test_equations_with_mixed_dimensions_are_listed() -> None:
    mixed = []
    for number_, equation in PAPER.equations.items():
        try:
            dimension(equation.residual)
        except DimensionError:
            mixed.append(number_)
    assert mixed == ["9"]


def test_every_claim_of_the_paper_is_derived() -> None:
    claims = {
        str(e.claims) for e in PAPER.equations.values() if not isinstance(e.claims, Definition)
    }
    assert claims <= CLAIMS.keys()
    assert all(claim == equation.number for claim, equation in CLAIMS.items())


def test_the_derivation_knows_no_paper() -> None:
    for module in Path(clutch.__file__).parent.glob("*.py"):
        assert "papers import" not in module.read_text(encoding="utf-8")


def test_differing_printed_equations_are_listed() -> None:
    assert differing(PAPER.equations) == [
        "contact",
        "Y_C",
        "A1",
        "semi-major",
        "semi-minor",
        "fillet",
        "curvature",
        "4b",
        "5a",
        "5b",
        "5c",
        "6",
        "7a",
        "8b",
        "start",
        "9",
        "B1",
        "B2",
        "12",
        "13b",
        "slip",
        "no slip",
    ]


@pytest.mark.parametrize("number_", ["1b", "2a", "A2", "3b", "7b", "10", "11", "14"])
def test_a_tampered_sign_is_noticed(number_: str) -> None:
    equation = PAPER.equations[number_]
    last = sp.Add.make_args(sp.expand(equation.residual))[-1]
    copy = replace(equation, residual=equation.residual - 2 * last)
    assert number_ in differing({number_: copy})


def test_a_reversed_relation_is_noticed() -> None:
    assert differing({"3a": replace(PAPER.equations["3a"], relation="<=")}) == ["3a"]


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
