"""Proofs on a small response of known optimum, with branches, kinks and a period; tampered ones
fail.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from planter.engine.proof import objective
from planter.engine.proof.intervals import Ball, Branches, Unbounded
from planter.engine.proof.jets import ANYWHERE, Space
from planter.engine.proof.objective import Maximum
from planter.engine.proof.proof_results import GlobalBound
from planter.engine.proof.search import BranchAndBound, Incumbent, SharedObjective, prove_bound
from planter.kernels import Array
from planter.task import AUTO, Means
from tests.planter.engine.proof.toys import (
    BENT,
    LOWER,
    RING_BEST,
    SAMPLES,
    UPPER,
    Bounded,
    Ring,
    build_bent,
    enclose_samples,
    force,
    value,
)

bounding = build_bent(SAMPLES)


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
    search = BranchAndBound(bounding, *box)
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
    above = BranchAndBound(bounding, LOWER, UPPER)
    assert above.run(BEST + 0.01, 0.2) <= BEST + 1e-14
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


RING_BOX = np.array([-1.5, -1.0]), np.array([1.2, 1.3])


def prove_ring(means: Means) -> GlobalBound:
    objective = float((RING_BEST @ RING_BEST - 1) ** 2 + 0.1 * RING_BEST[0])
    incumbent = Incumbent(RING_BEST, {"x": float(RING_BEST[0]), "y": 0.0}, objective, 1)
    with SharedObjective(Ring(), Ring, means) as shared:
        return replace(prove_bound(shared, RING_BOX, incumbent, seconds=60.0).result, seconds=0.0)


@pytest.mark.fault
def test_number_of_workers_changes_no_digit() -> None:
    serial = prove_ring(AUTO)
    assert serial.proved
    assert serial.boxes > 100
    assert prove_ring(Means(1)) == prove_ring(Means(2)) == serial
