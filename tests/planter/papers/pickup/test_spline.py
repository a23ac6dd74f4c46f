"""Closed cubic B-spline: passes its points, closes with two derivatives, obeys the cyclic system,
can be dragged.
"""

import numpy as np
import pytest
import scipy

from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.inverse import PathSpline, find_prominent_extrema
from tests.planter.papers.pickup.pickups import arm, steps, tips

POINTS = load_pickup("yu2023-path").points
CURVE = PathSpline(POINTS)


def test_curve_is_periodic_cubic_through_points() -> None:
    assert np.abs(CURVE(CURVE.knots[:-1]) - POINTS).max() < 1e-15
    ring = np.vstack([POINTS, POINTS[:1]])
    chords = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(ring, axis=0).T))])
    other = scipy.interpolate.CubicSpline(chords, ring, bc_type="periodic")
    u = np.linspace(0, CURVE.length, 777)
    assert np.abs(CURVE(u) - other(u)).max() < 1e-14
    for order in (0, 1, 2):
        assert CURVE(0.0, order) == pytest.approx(CURVE(CURVE.length, order), abs=1e-9)


def test_control_points_solve_the_cyclic_rows() -> None:
    """Rows of the text with indices of the knot at hand: a d(i-1) + b d(i) + c d(i+1) = e."""
    n = len(POINTS)
    step = np.diff(CURVE.knots)
    controls = np.roll(np.asarray(CURVE.curve.c)[:n], -1, axis=0)
    for i in range(n):
        b2, b1, point, after = (step[(i + k) % n] for k in (-2, -1, 0, 1))
        a = point**2 / (b2 + b1 + point)
        c = b1**2 / (b1 + point + after)
        b = point * (b2 + b1) / (b2 + b1 + point) + b1 * (point + after) / (b1 + point + after)
        row = a * controls[i - 1] + b * controls[i] + c * controls[(i + 1) % n]
        assert row == pytest.approx((b1 + point) * POINTS[i], abs=1e-14)


def test_extremes_are_roots_of_the_distance() -> None:
    t = steps(60, 0.4)
    curve = PathSpline(tips(t, np.pi + t + 0.3 * np.sin(t)))
    far, nearest = sorted(curve.extremes(1e-7), key=lambda e: -e.distance)
    dense = np.hypot(*curve(np.linspace(0, curve.length, 200001)).T)
    assert [far.distance, nearest.distance] == pytest.approx([dense.max(), dense.min()], abs=1e-9)
    assert far.distance >= dense.max() - 1e-15
    for extreme in (far, nearest):
        assert curve(extreme.u) @ curve(extreme.u, 1) == pytest.approx(0, abs=1e-12)
    assert (far.highest, nearest.highest) == (True, False)


def test_ripple_below_the_tolerance_is_no_extreme() -> None:
    t = steps(400)
    points = tips(t, np.pi + t + 0.3 * np.sin(t))
    points *= 1 + 1e-4 * np.cos(np.pi * np.arange(400))[:, None]
    assert len(PathSpline(points).extremes(2e-4)) == 2
    assert len(PathSpline(points).extremes(1e-12)) > 2


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("seed", range(20))
def test_prominent_extrema_equal_repeated_removal(seed: int, closed: bool) -> None:
    rng = np.random.default_rng(seed)
    values = rng.integers(0, 50, 2 * rng.integers(1, 15)) / 50
    values[::2] += 0.2
    left = list(range(len(values)))
    while len(left) > 1:
        pairs = [
            (abs(values[i] - values[j]), i, j)
            for i, j in zip(left, left[1:] + left[:1] * closed, strict=False)
        ]
        step, i, j = min(pairs)
        if step >= 0.3:
            break
        left = [k for k in left if k not in (i, j)]
    assert find_prominent_extrema(values, 0.3, closed).tolist() == left


def test_squares_near_an_extreme_keep_their_digits() -> None:
    t = steps(200, 0.4)
    curve = PathSpline(tips(t, np.pi + t + 0.3 * np.sin(t)))
    far = next(e for e in curve.extremes(1e-7) if e.highest)
    x = np.array([1e-9, 2e-9, 4e-9])
    gone = -curve.square_less(far.u + x, far)
    assert gone[1:] / gone[:-1] == pytest.approx(4, rel=1e-6)
    plain = far.distance**2 - np.sum(curve(far.u + x) ** 2, axis=1)
    assert np.abs(plain / gone - 1).max() > 1e-3


def test_the_built_in_points_lie_on_the_built_in_law() -> None:
    assert np.abs(POINTS - tips(steps(25), arm(steps(25)))).max() < 5.1e-10
