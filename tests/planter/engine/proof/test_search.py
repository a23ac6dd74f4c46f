"""Proofs on a small response of known optimum, with branches, kinks and a period; tampered ones
fail.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from planter.engine.proof import objective
from planter.engine.proof.enclosures import ResponseProgram
from planter.engine.proof.intervals import Ball, Branches, Unbounded
from planter.engine.proof.jets import ANYWHERE, Jet, Space
from planter.engine.proof.objective import Maximum
from planter.engine.proof.programs import record_program
from planter.engine.proof.roots import enclose_roots
from planter.engine.proof.search import BranchAndBound
from planter.kernels import Array
from tests.planter.engine.proof.toys import Bounded, enclose_samples

LOWER, UPPER = np.array([0.1, 0.9, -0.04]), np.array([0.6, 1.3, 0.1])
SAMPLES = 24


def evaluate(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """F = 2 x0 |sin(phi - x2)| + (x1 - x2^2) cos(2 phi): two halves of a turn, each with kinks
    where phi = x2.
    """
    phi, *x = inputs
    return [x[0] * xp.absolute(xp.sin(phi - x[2])) + (x[1] - x[2] ** 2) / 2 * xp.cos(2 * phi)]


BENT = ResponseProgram(
    3,
    (record_program(evaluate, 4, (3, 0, 1, 2)),),
    (Fraction(0), Fraction(-1, 2)),
    Fraction(1, 2),
    is_continuous=True,
)


def force(x: Array) -> Array:
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    return 2 * x[0] * np.abs(np.sin(phi - x[2])) + (x[1] - x[2] ** 2) * np.cos(2 * phi)


def value(x: Array) -> float:
    enclosed_force = force(x)
    return float(0.6 * np.ptp(enclosed_force) + 0.4 * enclosed_force.var())


def bounding(lower: Array, upper: Array) -> objective.ObjectiveBounds:
    (force,) = enclose_samples(BENT, Space(lower, upper), SAMPLES)
    extremes = [Maximum(samples, samples) for samples in (force * 0.6, force * -0.6)]
    return objective.bound_objective(
        objective.enclose_square(force - force.sum() / force.lanes).sum() / force.lanes * 0.4,
        extremes,
    )


def found_by_hand() -> Array:
    """Along the edge where the first parameter is largest and the second least, by a fine grid and
    golden sections.
    """
    edge = [np.array([UPPER[0], LOWER[1], x]) for x in np.linspace(LOWER[2], UPPER[2], 2001)]
    smallest = min(edge, key=value)[2]
    solution = minimize_scalar(
        lambda x: value(np.array([UPPER[0], LOWER[1], x])),
        bounds=(smallest - 1e-4, smallest + 1e-4),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return np.array([UPPER[0], LOWER[1], solution.x])


OPTIMUM = found_by_hand()
BEST = value(OPTIMUM)


def proved(
    box: tuple[Array, Array] = (LOWER, UPPER), seconds: float = 60.0, goal: float = 1e-6
) -> BranchAndBound:
    search = BranchAndBound(Bounded(bounding), *box)
    search.run(BEST - goal, seconds)
    return search


def test_samples_enclose_both_sides_of_branches() -> None:
    rng = np.random.default_rng(2)
    for share in (1.0, 0.1):
        half = share * (UPPER - LOWER) / 2
        middle = (LOWER + UPPER) / 2
        samples = enclose_samples(BENT, Space(middle - half, middle + half), SAMPLES)[0].value[
            ANYWHERE
        ]
        for _ in range(100):
            exact = force(middle + rng.uniform(-1, 1, 3) * half)[: SAMPLES // 2]
            assert (samples.low <= exact + 1e-14).all()
            assert (exact - 1e-14 <= samples.high).all()


def slopes_at_the_kink() -> Ball:
    """Of the sample at phi = 0 in x2, over a box in which |sin x2| has its kink."""
    (samples,) = enclose_samples(BENT, Space(LOWER, UPPER), SAMPLES)
    return samples.gradient[ANYWHERE][2, 0]


def test_slopes_enclose_both_sides_of_a_branch() -> None:
    slopes = slopes_at_the_kink()
    assert slopes.low < -2 * UPPER[0] * np.cos(LOWER[2])
    assert slopes.high > 2 * UPPER[0] * np.cos(UPPER[2])


def test_single_side_does_not_enclose_both(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        Branches, "further", lambda self: (np.empty(0, dtype=int), np.empty((0, 0)))
    )
    slopes = slopes_at_the_kink()
    assert slopes.low > -1 or slopes.high < 1


def test_bounds_of_objective_and_slopes_hold_at_random_designs() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        middle = LOWER + rng.random(3) * (UPPER - LOWER)
        half = 0.05 * rng.random() * (UPPER - LOWER)
        bounds = bounding(middle - half, middle + half)
        assert value(middle) <= bounds.reached + 1e-14
        for _ in range(20):
            x, y = (middle + rng.uniform(-1, 1, 3) * half for _ in range(2))
            assert bounds.lower_bound <= value(x) + 1e-14
            low, high = bounds.slopes.low, bounds.slopes.high
            step = y - x
            largest = np.where(step > 0, high, low) @ step
            assert value(y) - value(x) <= largest + 1e-13


def test_the_optimum_is_proved() -> None:
    proof = proved()
    assert BEST - 1e-6 <= proof.weakest.lower_bound <= BEST + 1e-14
    assert proof.met >= BEST - 1e-9
    assert 1 < proof.boxes < 400


def test_box_without_optimum_is_not_the_total() -> None:
    """The bound of a part is above the optimum of the whole; a false optimum that is too high is
    never proved.
    """
    part = proved((LOWER, np.array([UPPER[0] - 0.1, *UPPER[1:]])))
    assert part.weakest.lower_bound > BEST + 1e-3
    above = BranchAndBound(Bounded(bounding), LOWER, UPPER)
    assert above.run(BEST + 0.01, 1.0) <= BEST + 1e-14
    assert above.met < BEST + 0.01


@pytest.mark.parametrize("tamper", ["slopes", "least"])
def test_a_wrong_sign_gives_a_bound_above_the_optimum(tamper: str) -> None:
    def wrong(lower: Array, upper: Array) -> objective.ObjectiveBounds:
        bounds = bounding(lower, upper)
        slopes = -bounds.slopes if tamper == "slopes" else bounds.slopes
        bound = (
            bounds.lower_bound if tamper == "slopes" else 2 * bounds.reached - bounds.lower_bound
        )
        return objective.ObjectiveBounds(bound, bounds.reached, slopes, bounds.looseness)

    assert BranchAndBound(Bounded(wrong), LOWER, UPPER).run(BEST - 1e-6, 20.0) > BEST


def test_unbounded_box_is_halved_until_time_ends() -> None:
    def partly(lower: Array, upper: Array) -> objective.ObjectiveBounds:
        if (upper - lower)[0] > 0.3:
            raise Unbounded("a denominator may vanish")
        return bounding(lower, upper)

    assert BranchAndBound(Bounded(partly), LOWER, UPPER).run(BEST - 1e-6, 60.0) >= BEST - 1e-6
    hurried = BranchAndBound(Bounded(partly), LOWER, UPPER).run(BEST - 1e-6, 0.0)
    assert hurried == 0.0


def test_root_is_enclosed_with_derivatives() -> None:
    """a^3 + x0 a = x1: derivatives by those of the implicit function."""
    upper = LOWER + (UPPER - LOWER) / 4
    space = Space(LOWER, upper)
    x = space.parameters()

    def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
        return [a[0] ** 3 + x[0] * a[0] - x[1]], [[3 * a[0] ** 2 + x[0]]]

    (root,), rng = enclose_roots(space, np.array([[0.8]]), residual), np.random.default_rng(6)
    for _ in range(100):
        p = LOWER + rng.random(3) * (upper - LOWER)
        a = float(np.roots([1, 0, p[0], -p[1]])[-1].real)
        slope = 3 * a * a + p[0]
        first = np.array([-a / slope, 1 / slope])
        second = -6 * a / slope * np.outer(first, first)
        second[0, :] -= first / slope
        second[:, 0] -= first / slope
        assert contains(root.value[ANYWHERE], a)
        assert contains(root.gradient[ANYWHERE][:, 0], first)
        assert contains(root.hessian[:, 0], second[np.tril_indices(2)])
    assert root.value.rad[0, 0] < 1e-14


def contains(ball: Ball, value: Array | float) -> bool:
    return bool(((ball.low <= value) & (value <= ball.high)).all())


def test_roots_of_two_equations_are_enclosed_in_every_lane() -> None:
    """(a cos b, a sin b) = (x0 + lane, x1): polar coordinates."""
    lower, upper = np.array([1.0, 0.5]), np.array([1.1, 0.6])
    space, lanes = Space(lower, upper), np.array([0.0, 1.0])
    x, shift = space.parameters(), space.constant(Ball.exact(lanes))

    def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
        radius, angle = a
        cos, sin = angle.call("cos"), angle.call("sin")
        return [radius * cos - x[0] - shift, radius * sin - x[1]], [
            [cos, -radius * sin],
            [sin, radius * cos],
        ]

    roots, rng = (
        enclose_roots(space, np.array([[1.2, 2.1], [0.5, 0.3]]), residual),
        np.random.default_rng(3),
    )
    for _ in range(50):
        px, py = (lower + rng.random(2) * (upper - lower))[:, None] + np.array([lanes, 0 * lanes])
        r2, r = px**2 + py**2, np.hypot(px, py)
        exact = [
            (r, (px / r, py / r), (py**2 / r**3, -px * py / r**3, px**2 / r**3)),
            (
                np.arctan2(py, px),
                (-py / r2, px / r2),
                (2 * px * py / r2**2, (py**2 - px**2) / r2**2, -2 * px * py / r2**2),
            ),
        ]
        for jet, (value, first, second) in zip(roots, exact, strict=True):
            assert contains(jet.value[ANYWHERE], value)
            assert contains(jet.gradient[ANYWHERE], np.array(first))
            assert contains(jet.hessian, np.array(second))
    assert max(jet.value.rad[0].max() for jet in roots) < 1e-13


def test_greatest_value_of_crossing_lines_is_bounded_from_below() -> None:
    """max(x, -x) is 0 at the least: the line that is greatest at the centre bounds it, and no slope
    has one sign.
    """
    space = Space(np.array([-1.0]), np.array([2.0]))
    (x,) = space.parameters()
    lines = x * space.constant(Ball.exact([1.0, -1.0]))
    bounds = objective.bound_objective(space.lift(0), [Maximum(lines, lines)])
    assert bounds.lower_bound <= 0.0
    assert bounds.slopes.low[0] <= -1.0
    assert bounds.slopes.high[0] >= 1.0
    alone = objective.bound_objective(space.lift(0), [Maximum(lines.taken([0]), lines.taken([0]))])
    assert alone.slopes.low[0] == pytest.approx(1.0), "a line that is left out is missed"


def test_uncertain_root_is_refused() -> None:
    space = Space(np.array([-1.0]), np.array([1.0]))
    (x,) = space.parameters()
    with pytest.raises(Unbounded):
        enclose_roots(space, np.array([[0.5]]), lambda a: ([a[0] ** 2 - x], [[2 * a[0]]]))
