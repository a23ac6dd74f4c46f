"""The angle curve: periodic C2 cubic, exact extremes; points of both paths; the closest monotone
curve.
"""

import math

import numpy as np
import pytest
import scipy

from planter.errors import ComputationError
from planter.numerics.arrays import TURN
from planter.papers.mapping import model
from planter.papers.mapping.curve import AngleCurve, load_curve
from planter.papers.mapping.dyads import Dyad, solve_dyads
from planter.papers.mapping.file import PointsData, build_path_curve
from planter.papers.mapping.linkage import FourBar
from planter.papers.mapping.nearest import (
    Nearest,
    find_misses,
    find_nearest,
    interpolate_poses,
)
from tests.planter.papers.mapping.data import CORRECTED, si

DYADS = solve_dyads(si(CORRECTED)).dyads
LINKAGE = FourBar(*DYADS)
POINTS = PointsData(
    first_pose=1,
    first_carrier_deg=list(range(0, 61, 10)),
    second_pose=4,
    second_carrier_deg=[230, 240, 250],
    second_shift_deg=30,
    free_carrier_deg=[90, 120, 150, 180, 205, 305],
)


def test_curve_is_periodic_and_c2() -> None:
    curve = load_curve("sun2019-curve")
    assert curve.at(curve.carrier) == pytest.approx(curve.relative, abs=1e-14)
    theta = np.linspace(0, TURN, 100)
    assert curve.at(theta + TURN) == pytest.approx(curve.at(theta) - TURN, abs=1e-12)
    left, right = curve.slopes(curve.carrier - 1e-9), curve.slopes(curve.carrier + 1e-9)
    assert left[:2] == pytest.approx(right[:2], abs=1e-6)
    assert np.abs(left[2] - right[2]).max() > 0.1


def test_first_of_equal_slopes_is_the_extreme() -> None:
    """A curve that repeats four times a turn has each extreme four times, and rounding does not
    choose among them.
    """
    carrier = np.linspace(0, TURN, 33)
    relative = -carrier + 0.1 * np.sin(4 * carrier)
    for noise in (0, 1e-13):
        uneven = relative + noise * np.cos(np.arange(len(carrier)))
        assert [extreme.place for extreme in AngleCurve(carrier, uneven).extremes] == pytest.approx(
            [0, TURN / 8]
        )


def test_slopes_are_the_derivatives_of_the_curve() -> None:
    curve = load_curve("sun2019-curve")
    theta, step = np.linspace(0.03, 6.2, 40), 1e-5
    assert curve.slopes(theta)[0] == pytest.approx(
        -(curve.at(theta + step) - curve.at(theta - step)) / (2 * step), rel=1e-8
    )
    ahead, behind = curve.slopes(theta + step), curve.slopes(theta - step)
    assert curve.slopes(theta)[1] == pytest.approx((ahead[0] - behind[0]) / (2 * step), abs=1e-6)


def test_extremes_are_the_true_ones() -> None:
    curve = load_curve("sun2019-curve")
    smallest, largest = curve.extremes
    slopes = curve.slopes(np.linspace(0, TURN, 200001))[0]
    assert smallest.value <= slopes.min()
    assert largest.value >= slopes.max()
    assert (smallest.value, largest.value) == pytest.approx((slopes.min(), slopes.max()), abs=1e-8)
    assert curve.slopes(np.array([smallest.place]))[0] == pytest.approx(smallest.value)


def test_points_of_both_paths_and_between_give_the_default_curve() -> None:
    """The built-in points, made from the dyads alone; they are printed to 1e-6 deg."""
    curve = build_path_curve(LINKAGE, POINTS, (1, -1))
    printed = load_curve("sun2019-curve")
    assert np.degrees(curve.carrier) == pytest.approx(np.degrees(printed.carrier), abs=1e-9)
    assert np.degrees(curve.relative) == pytest.approx(np.degrees(printed.relative), abs=6e-7)
    assert curve.monotone


def test_the_arm_must_not_turn_more_than_once() -> None:
    """Points of the second path between those of the first would take a turn each."""
    changes = {"second_carrier_deg": [5, 15], "second_shift_deg": 0.0, "free_carrier_deg": []}
    too_far = POINTS.model_copy(update=changes)
    with pytest.raises(ComputationError, match="one closed turn"):
        build_path_curve(LINKAGE, too_far, (1, -1))


def test_curve_through_the_poses_passes_them_and_turns_back() -> None:
    poses = si(CORRECTED)
    curve = interpolate_poses(DYADS[0], poses)
    assert max(m.position_error_mm for m in find_misses(DYADS[0], poses, curve)) < 1e-5
    assert not curve.monotone


@pytest.fixture(scope="module")
def closest() -> Nearest:
    return find_nearest(DYADS[0], si(CORRECTED))


def test_compatible_poses_are_met_exactly(closest: Nearest) -> None:
    off = [m.position_error_mm + m.hinge_error_mm for m in closest.misses]
    assert max(off[k] for k in (0, 1, 4)) < 1e-6
    assert min(off[k] for k in (2, 3)) > 1


def test_misses_are_those_of_the_curve(closest: Nearest) -> None:
    """Again from the curve, by complex numbers."""
    poses, dyad = si(CORRECTED), DYADS[0]
    for miss, pose in zip(closest.misses, poses, strict=True):
        carrier = math.radians(miss.carrier_deg)
        phi = float(closest.curve.at(np.array([carrier]))[0]) + carrier
        hinge = complex(*dyad.centre) + dyad.radius * np.exp(1j * carrier)
        tip = hinge - np.exp(1j * phi) * complex(*dyad.point)
        expected_tip = complex(*pose[:2]) + np.exp(1j * pose[2]) * complex(*dyad.point)
        assert abs(tip - complex(*pose[:2])) == pytest.approx(
            miss.position_error_mm / 1e3, abs=1e-12
        )
        assert abs(hinge - expected_tip) == pytest.approx(miss.hinge_error_mm / 1e3, abs=1e-12)


def test_no_other_monotone_turn_is_closer(closest: Nearest) -> None:
    """Random steps and a second optimiser from many starts, on the two poses in conflict, find
    nothing better.
    """
    poses, dyad = si(CORRECTED), DYADS[0]
    target = np.vstack([poses[:, :2].T, model.place_point(poses, dyad.point).T])
    smallest = 0.125

    def cost(theta: np.ndarray, phi: np.ndarray) -> float:
        return float(((model.arm(theta, phi, dyad.vector) - target) ** 2).sum())

    met = np.radians([m.carrier_deg for m in closest.misses])
    met[2] += TURN  # the turn begins before pose 2
    phi = closest.curve.at(met) + met
    best = cost(met, phi)
    order = np.array([4, 3, 2])

    def with_penalty(z: np.ndarray) -> float:
        theta, arm = met.copy(), phi.copy()
        theta[[3, 2]], arm[[3, 2]] = z[:2], z[2:]
        y = arm - theta
        falls = np.append(-np.diff(y[order]), y[2] - (y[1] - TURN))
        steps = np.append(np.diff(theta[order]), met[1] + TURN - theta[2])
        return cost(theta, arm) + 10 * float(np.maximum(smallest * steps - falls, 0).sum())

    start = np.array([met[3], met[2], phi[3], phi[2]])
    assert with_penalty(start) == pytest.approx(best, abs=1e-6)
    rng = np.random.default_rng(1)
    solutions = [
        scipy.optimize.minimize(
            with_penalty,
            start + rng.normal(scale=0.2, size=4),
            method="Nelder-Mead",
            options={"maxiter": 1500},
        ).fun
        for _ in range(4)
    ]
    assert min(solutions) > best * (1 - 1e-3)


def test_achievable_poses_are_passed_exactly() -> None:
    """A carrier that makes whole turns under an arm that swings: the miss is rounding, in every
    pose.
    """
    dyad = Dyad(np.array([-0.2, -0.05]), np.array([0.1, 0.0]), 0.1)
    theta, phi = np.radians([0, 70, 150, 230, 300]), np.radians([0, 10, 5, -10, -5])
    tips = model.arm(theta, phi, dyad.vector)[:2]
    nearest = find_nearest(dyad, np.column_stack([tips.T, phi]))
    assert max(m.position_error_mm + m.hinge_error_mm for m in nearest.misses) < 1e-4
    assert nearest.curve.monotone
