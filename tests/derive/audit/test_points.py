"""The points that the audit decides at: between them they take every branch that a paper prints,
both ways.
"""

import pytest
import sympy as sp
from sympy.core.relational import Relational

from derive.audit.case import Case
from derive.audit.judge import holds
from derive.evaluate import Point
from tests.support.mutations import CASES


def one_sided(case: Case, points: list[Point]) -> set[str]:
    """Printed branch conditions that are the same at all points."""
    legible = (n for n, e in case.paper.equations.items() if e.legibility != "lost")
    conditions = {
        relation
        for number in legible
        for cases in case.pair(number)[0].residual.atoms(sp.Piecewise)
        for _, condition in cases.args
        for relation in condition.atoms(Relational)
    }
    return {str(c) for c in conditions if len({point.holds(c) for point in points}) == 1}


@pytest.mark.parametrize("name", CASES)
def test_every_printed_branch_is_taken_both_ways(name: str) -> None:
    assert one_sided(CASES[name], CASES[name].points) == set()


def test_a_single_point_would_not_do() -> None:
    case = CASES["wang2017"]
    assert one_sided(case, case.points[:1])


def test_residual_is_zero_only_beside_its_largest_term() -> None:
    x, y, gap = sp.symbols("x y gap")
    residual = (x + y) * (x - y) + y**2 - x**2 + gap
    for size, is_zero in (("0", True), ("1e-50", True), ("1e-40", False), ("1e-20", False)):
        assert holds(residual, (Point({x: "0.3", y: "1.7", gap: size}),)) is is_zero
    assert not holds(gap - 2 * gap, (Point({gap: "1e-60"}),))
