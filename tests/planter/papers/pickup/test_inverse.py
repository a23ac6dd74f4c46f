"""The inverse chain: it sees points alone, finds the law, the bars and the dwell again, and knows
what has none; its spline passes the points and keeps the digits of extremes."""

from __future__ import annotations

import numpy as np
import pytest

from planter.errors import InputError
from planter.numerics.arrays import TURN
from planter.papers.pickup import inverse
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.inverse import Inversion, PathSpline, find_prominent_extrema, invert_path
from tests.planter.papers.pickup.pickups import END, FAR, L1, L2, START, arm, steps, tips

POINTS = load_pickup("yu2023-path").points
CURVE = PathSpline(POINTS)


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


T = np.linspace(0, TURN, 2001)
AWAY = T[
    np.min(
        [np.abs((T - e + np.pi) % TURN - np.pi) for e in (START, END, np.radians(142.78), 0)],
        axis=0,
    )
    > 0.5
]


def invert_samples(count: int, offset: float = 0.0, **law: float) -> Inversion:
    t = steps(count, offset)
    return invert_path(tips(t, arm(t, **law)))


def error(inversion: Inversion, at: np.ndarray = T, **law: float) -> float:
    shift = (inversion.phi5_far - FAR + np.pi) % TURN - np.pi
    return float(np.abs(inversion.law.arm(at - shift) - arm(at, **law)).max())


def test_the_chain_cannot_see_a_law() -> None:
    names = set(vars(inverse))
    assert not names & {"CosineLaw", "PickupTrain", "Pickup", "build_train", "load_pickup"}


@pytest.mark.parametrize("offset", [0.0, 0.37, 0.5])
def test_a_dense_path_gives_the_law_back(offset: float) -> None:
    inversion = invert_samples(3600, offset)
    assert error(inversion) < 1e-9
    assert [inversion.L1 - L1, inversion.L2 - L2, inversion.phi5_far - FAR] == pytest.approx(
        [0, 0, 0], abs=1e-12
    )
    assert [inversion.law.dwell.start - START, inversion.law.dwell.end - END] == pytest.approx(
        [0, 0], abs=1e-9
    )


def test_error_falls_at_spline_order() -> None:
    errors = [error(invert_samples(count, 0.37), AWAY) for count in (60, 120, 240)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.5).all()
    bars = [abs(invert_samples(count, 0.37).L1 - L1) for count in (60, 120, 240)]
    assert (np.log2(np.array(bars[:-1]) / bars[1:]) > 3.5).all()


@pytest.mark.parametrize(
    ("p", "start", "end"), [(0.2, 200, 290), (-0.3, 100, 140), (0.3, 20, 60), (0.0, 300, 350)]
)
def test_dwells_are_recovered_from_the_path(p: float, start: float, end: float) -> None:
    law = {"p": p, "start": np.radians(start), "end": np.radians(end)}
    inversion = invert_samples(1200, 0.2, **law)
    assert error(inversion, **law) < 1e-6
    assert np.degrees([inversion.law.dwell.start, inversion.law.dwell.end]) == pytest.approx(
        [start, end], abs=1e-4
    )


def test_a_dwell_at_the_farthest_tip() -> None:
    """The plateau is the maximum itself; t then counts from its middle."""
    width = np.radians(40)
    t = steps(1800, 0.3)

    def hold_ends(x: np.ndarray) -> np.ndarray:
        wrapped = (x + np.pi) % TURN - np.pi
        beyond = np.sign(wrapped) * np.maximum(np.abs(wrapped) - width / 2, 0)
        return np.pi + beyond * np.pi / (np.pi - width / 2) + (x - wrapped)

    inversion = invert_path(tips(t, hold_ends(t)), tolerance=1e-13)
    assert inversion.law.dwell.width == pytest.approx(width, abs=1e-4)
    inner = T[(T > 0.5) & (T < TURN - 0.5)]
    assert (
        np.abs(inversion.law.arm(inner - (inversion.phi5_far - FAR)) - hold_ends(inner)).max()
        < 1e-4
    )


def test_a_path_without_dwell() -> None:
    def smooth(t: np.ndarray) -> np.ndarray:
        return np.pi + t + 0.3 * np.sin(t) + 0.05 * np.sin(2 * t)

    t = steps(900, 0.4)
    inversion = invert_path(tips(t, smooth(t)))
    assert inversion.law.dwell is None
    assert np.abs(inversion.law.arm(T) - smooth(T)).max() < 1e-8
    slope = 1 + 0.3 * np.cos(T) + 0.1 * np.cos(2 * T)
    assert np.abs(inversion.law.slopes(T)[0] - slope).max() < 1e-5


def test_the_start_of_the_points_does_not_matter() -> None:
    points = tips(steps(400), arm(steps(400)))
    first, other = invert_path(points), invert_path(np.roll(points, 123, axis=0))
    assert np.abs(first.law.arm(T) - other.law.arm(T)).max() < 1e-9


def test_a_moved_point_is_felt() -> None:
    points = tips(steps(400), arm(steps(400)))
    points[60] *= 1.0001
    assert error(invert_path(points)) > 1e-6


def test_uneven_points() -> None:
    t = steps(2000) + 0.3 * np.sin(steps(2000))
    assert error(invert_path(tips(t, arm(t)))) < 1e-8


def test_points_against_the_carrier_are_refused() -> None:
    with pytest.raises(InputError, match=r"counter-clockwise, .* turn the lines of the file round"):
        invert_path(tips(steps(100), arm(steps(100)))[::-1])


def test_a_path_with_two_far_points_is_refused() -> None:
    t = steps(200)
    lobes = np.column_stack([0.2 + 0.02 * np.cos(t), 0.1 * np.sin(t)])
    with pytest.raises(InputError, match=r"2 maxima and 2 minima \(at .*mm\)"):
        invert_path(lobes)


def test_path_around_the_sun_is_refused() -> None:
    t = steps(200)
    for r in (0.15 + 0.03 * np.cos(2 * t), 0.15 + 0.03 * np.cos(t), np.full(200, 0.1)):
        for sense in (1, -1):
            with pytest.raises(InputError, match="goes round the origin"):
                invert_path(np.column_stack([r * np.cos(t), sense * r * np.sin(t)]))
