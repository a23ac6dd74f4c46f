"""Equations are judged where the machine uses them, conditions by when they hold."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mpmath
import pytest
import sympy as sp
from mpmath import mpf
from sympy import atan, cos, pi, sin, tan

from derive.audit.case import NEAR, SEEDS, Case
from derive.audit.judge import Judgement
from derive.audit.paper import Paper
from derive.audit.terms import have_same_truth, holds
from derive.audit.user_mechanism.trial import trial
from derive.discovery import load_user_modules
from derive.equations import Equation, Relation, derived_equation
from derive.evaluate import Point
from derive.formulas import Formulas
from derive.papers import shi2021, yu2023
from derive.papers.clutch import quantities as clutch
from derive.quantity import Quantity, quantities
from tests.support import own
from tests.support.made_up import (
    POINTS,
    MadeUp,
    MadeUpClaim,
    a,
    b,
    c,
    judge_number,
    judged,
    quantity,
    u,
    v,
)

phi, across, lengthwise, zero = (
    quantity(n, k) for n, k in (("phi", "rad"), ("across", "m"), ("along", "m"), ("zero", "m"))
)


@dataclass(frozen=True)
class Turning(MadeUp):
    """A made-up arm: random points all around, a cycle in the third quadrant alone, and a length
    that is zero there.
    """

    consistent: bool = True

    def admissible(self, rng: random.Random) -> dict[Quantity, mpf]:
        return self.at(
            mpf(rng.uniform(-3.1, 3.1)), mpf(rng.uniform(0.5, 1.5)), mpf(rng.uniform(0.5, 1))
        )

    def reference(self, points: int) -> list[dict[Quantity, mpf]]:
        return [
            self.at(-mpmath.pi + (k + 1) * mpf(1) / (points + 1), mpf(1), mpf(0))
            for k in range(points)
        ]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        if not self.consistent:
            return None
        return [
            self.at(mpf(rng.uniform(-3, -2)), 1 + NEAR * mpf(rng.random()), NEAR) for _ in range(5)
        ]

    @staticmethod
    def at(angle: mpf, length: mpf, offset: mpf) -> dict[Quantity, mpf]:
        with mpmath.workdps(60):
            return {
                phi: angle,
                a: length,
                zero: offset,
                lengthwise: length * mpmath.cos(angle),
                across: length * mpmath.sin(angle),
            }


DIRECTION = derived_equation(MadeUpClaim.SUM, phi - sp.atan2(across, lengthwise), phi)


def arm(meant: Equation = DIRECTION, consistent: bool = True) -> Case:
    return Case(Paper("made up", ""), Turning({MadeUpClaim.SUM: meant}, consistent=consistent))


def judgement(case: Case) -> Judgement:
    return judge_number(case, "1")


@pytest.mark.parametrize("consistent", [True, False])
@pytest.mark.parametrize(
    ("printed", "verdict"),
    [
        (atan(across / lengthwise) - pi, "confirmed"),
        (-pi / 2 - atan(lengthwise / across), "confirmed"),
        (-pi / 2 + atan(lengthwise / across), "misprint"),
        (pi / 2 - atan(lengthwise / across), "misprint"),
        (atan(across / lengthwise) - pi + zero / a, "misprint"),
    ],
)
def test_rewriting_need_only_hold_on_the_cycle(
    printed: sp.Expr, verdict: str, consistent: bool
) -> None:
    """The last is wrong, though not on the cycle itself, where a length is zero."""
    case = arm(consistent=consistent)
    case.paper.defines("1", phi, printed, MadeUpClaim.SUM)
    result = judgement(case)
    if verdict == "confirmed":
        assert result.verdict == "confirmed"
        assert "not everywhere" in result.finding
        assert "at test_a" not in result.finding
        assert "across = " in result.finding
    else:
        assert result.verdict in ("misprint", "incomplete", "contradicted")


def test_rewriting_without_claim_is_judged_on_the_cycle_too() -> None:
    case = arm()
    case.paper.defines("1", phi, atan(across / lengthwise) - pi)
    assert judgement(case).verdict == "confirmed"
    case = arm(consistent=False)
    case.paper.defines("1", phi, atan(across / lengthwise) - pi + zero / a)
    assert judgement(case).verdict in ("misprint", "contradicted")


def test_term_zero_only_on_the_cycle_is_missing() -> None:
    case = arm(derived_equation(MadeUpClaim.SUM, phi - across / a - zero / a, phi))
    case.paper.defines("1", phi, across / a, MadeUpClaim.SUM)
    result = judgement(case)
    assert (result.verdict, result.missing) == ("incomplete", (zero / a,))


def test_derivation_is_compared_where_it_holds() -> None:
    third = sp.And(lengthwise < 0, across < 0)
    meant = replace(
        derived_equation(MadeUpClaim.SUM, phi - (atan(across / lengthwise) - pi), phi), where=third
    )
    case = arm(meant)
    assert len(case.points_where(third)) == len(SEEDS)
    assert all(point.holds(third) for point in case.points_where(third))
    assert case.points_where(lengthwise > 10) == case.points
    case.paper.defines("1", phi, -pi / 2 - atan(lengthwise / across), MadeUpClaim.SUM)
    result = judgement(case)
    assert (result.verdict, result.finding) == ("confirmed", "no difference left")


@pytest.mark.parametrize(
    ("number", "printed", "verdict"),
    [
        (
            "phi4, other quadrants",
            yu2023.PAPER.equations["phi4, other quadrants"].residual,
            "confirmed",
        ),
        ("phi4, third quadrant", yu2023.phi4 + pi / 2 + atan(yu2023.x_S / yu2023.y_S), "confirmed"),
        ("phi4, third quadrant", yu2023.phi4 - pi / 2 + atan(yu2023.x_S / yu2023.y_S), "misprint"),
        ("phi4, other quadrants", yu2023.phi4 + atan(yu2023.y_S / yu2023.x_S), "incomplete"),
    ],
)
def test_tip_direction_is_in_the_right_quadrant(
    number: str, printed: sp.Expr, verdict: str
) -> None:
    case = yu2023.CASE
    equation = replace(case.paper.equations[number], residual=printed)
    alone = replace(case, paper=replace(case.paper, equations={number: equation}, questions=[]))
    assert judge_number(alone, number).verdict == verdict


@pytest.mark.parametrize(
    "name", ["slider_crank", pytest.param("manipulator", marks=pytest.mark.long)]
)
def test_nearby_values_are_consistent(name: str) -> None:
    """All that is derived of a driven mechanism, and of one that moves by itself, holds there; data
    are not its own.
    """
    with load_user_modules(own.EXAMPLES / f"{name}.py") as (module,):
        case = trial(module.m, Paper("near", "Near"))
    assert len(case.nearby) >= 5
    for claim, equation in case.claims.items():
        assert holds(equation.residual, tuple(case.nearby)), claim
    data = module.m.given.values()
    moved = {q for q in data if case.nearby[0](q) != case.cycle[0](q)}
    assert moved == set(data) - {
        q for q in data if q.name not in module.m.given.data and q != module.m.angle
    }
    assert all(
        abs(case.nearby[0](q) - case.cycle[0](q)) <= 2 * NEAR * (abs(case.cycle[0](q)) or 1)
        for q in data
        if q != module.m.angle
    )


def test_formulas_have_nearby_values() -> None:
    q = quantities("r | mm | radius | 20 | 10 30\nA | m2 | area of it")
    disc = Formulas("disc", given=q)
    disc.defines(q.A, 3 * q.r**2)
    case = trial(disc, Paper("near", "Near"))
    assert all(holds(equation.residual, tuple(case.nearby)) for equation in case.claims.values())
    assert len({point.digits(q.r) for point in (*case.nearby, *case.cycle)}) == len(
        case.nearby
    ) + len(case.cycle)


# conditions


@pytest.mark.parametrize(
    ("printed", "relation", "verdict"),
    [
        (a / u - (b - c), "<=", "confirmed"),
        ((b - c) - a / u, ">=", "confirmed"),
        (3 * a - 3 * u * (b - c), "<=", "confirmed"),
        (a / u - (b - c), ">=", "misprint"),
        (a / u - (b - c), "<", "misprint"),
        (a / u - (b + c), "<=", "misprint"),
        (a * u - (b - c), "<=", "contradicted"),
        ((b - c) - a / u, "<=", "misprint"),
    ],
)
def test_equivalent_conditions_are_confirmed(
    printed: sp.Expr, relation: Relation, verdict: str
) -> None:
    result = judged(printed, a - u * (b - c), (relation, "<="))
    assert result.verdict == verdict
    if verdict == "contradicted":
        assert result.corrections == ()
    if verdict == "misprint":
        assert all(len(correction) == 1 for correction in result.corrections)


def test_sign_changing_factor_is_not_equivalent() -> None:
    assert have_same_truth(a * cos(v), a, tuple(POINTS))
    turned = tuple(Point(point.values() | {v: mpf(3)}) for point in POINTS)
    assert not have_same_truth((a - b) * cos(v), a - b, turned)
    assert have_same_truth(-(a - b) * cos(v), a - b, turned)
    assert not have_same_truth((a - b) * (a - 2 * b), a - b, tuple(POINTS))


@pytest.mark.parametrize(
    ("printed", "verdict"),
    [
        (clutch.f / cos(clutch.phi) - (clutch.F1 - clutch.F2), "confirmed"),
        (clutch.f / cos(clutch.phi) - (clutch.F1 + clutch.F2), "misprint"),
        (clutch.f * cos(clutch.phi) - (clutch.F1 - clutch.F2), "contradicted"),
        (clutch.f / sin(clutch.phi) - (clutch.F1 - clutch.F2), "misprint"),
    ],
)
def test_taper_condition_divided_by_a_cosine(printed: sp.Expr, verdict: str) -> None:
    case = shi2021.CASE
    equation = replace(case.paper.equations["4c"], residual=printed, relation="<=")
    alone = replace(case, paper=replace(case.paper, equations={"4c": equation}, questions=[]))
    assert judge_number(alone, "4c").verdict == verdict


def test_increasing_function_is_equivalent() -> None:
    points = tuple(Point({u: mpf(k) / 10, v: mpf(5) / (k + 3)}) for k in range(1, 8))
    assert have_same_truth(v * tan(u) - 1, u - atan(1 / v), points)
    assert not have_same_truth(v * sin(u) - 1, u - atan(1 / v), points)
