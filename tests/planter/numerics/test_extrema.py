"""Extrema from samples: smooth, at kinks, at ends, in cycles, tied, and invalid values."""

from __future__ import annotations

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extrema
from planter.numerics.extrema import index_first_extremum

PERIOD = np.arange(48) * 2 * np.pi / 48


@pytest.mark.parametrize("place", [0.01, 1.234, 2.99])
def test_smooth_extremum_is_exact_to_rounding(place: float) -> None:
    result = extrema.find_minimum(lambda x: 5 - np.cos(x - place), np.linspace(0, 3, 31))
    assert result.value == pytest.approx(4.0, rel=1e-15)
    assert result.place == pytest.approx(place, abs=1e-7)
    upside_down = extrema.find_maximum(lambda x: np.cos(x - place) - 5, np.linspace(0, 3, 31))
    assert (upside_down.place, upside_down.value) == (result.place, -result.value)


def test_kink_is_located_within_tolerance() -> None:
    result = extrema.find_maximum(lambda x: -np.abs(x - 100.0371), np.linspace(100, 101, 11))
    assert result.value == pytest.approx(0.0, abs=1e-8 * 0.1)


def test_end_is_extremum_of_interval_only() -> None:
    places = np.linspace(0.0, 1.0, 21)
    assert extrema.find_minimum(np.exp, places) == extrema.ExtremePoint(0.0, 1.0)
    minimum = extrema.find_minimum(lambda x: np.cos(x + np.pi + 0.02), PERIOD, closed=True)
    assert minimum.value == pytest.approx(-1.0, rel=1e-15)
    assert minimum.place == pytest.approx(-0.02, abs=1e-7)


def test_deeper_minimum_wins_against_lower_sample() -> None:
    """The wide one is sampled at its bottom, the narrow one beside its own, which is the deeper
    one.
    """

    def function(x: Array) -> Array:
        return -np.exp(-(((x - 1.0) / 0.5) ** 2)) - 1.02 * np.exp(-(((x - 3.05) / 0.12) ** 2))

    places = np.linspace(0, 4, 41)
    assert abs(places[function(places).argmin()] - 1.0) < 1e-12
    result = extrema.find_minimum(function, places)
    assert result.value == pytest.approx(-1.02, rel=1e-6)
    assert result.place == pytest.approx(3.05, abs=1e-3)


def test_single_candidate_misses_deeper_minimum(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case: with no room beside the best sample the value is wrong."""
    monkeypatch.setattr(extrema, "MAX_CANDIDATES", 1)

    def function(x: Array) -> Array:
        return np.cos(3 * x)

    coarse = float(function(np.linspace(0, 2, 7)).min())
    result = extrema.find_minimum(function, np.linspace(0, 2, 7))
    assert coarse > result.value + 1e-3
    assert result.value == pytest.approx(-1.0, rel=1e-15)


def test_vectorised_function_evaluates_each_element() -> None:
    assert extrema.vectorise(lambda x: x**2)(np.array([1.0, -3.0])).tolist() == [1.0, 9.0]


def test_extremum_of_constant_is_first_sample() -> None:
    assert extrema.find_minimum(np.zeros_like, PERIOD, closed=True) == extrema.ExtremePoint(
        0.0, 0.0
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_value_raises_error(bad: float) -> None:
    with pytest.raises(ComputationError, match=r"it is (nan|inf) at 2\.5"):
        extrema.find_minimum(lambda x: np.where(x == 2.5, bad, x), np.array([1.0, 2.5, 4.0]))


def test_stationary_points_are_roots_of_derivative() -> None:
    def rates(x: Array) -> tuple[Array, Array]:
        return np.cos(2 * x), -2 * np.sin(2 * x)

    places = np.linspace(0, 2 * np.pi, 30)
    result, maxima = extrema.find_stationary_points(rates, places, rates(places)[0])
    assert result == pytest.approx(np.pi / 4 + np.pi / 2 * np.arange(4), rel=1e-15)
    assert maxima.tolist() == [True, False, True, False]
    nowhere, none = extrema.find_stationary_points(rates, places[:3], np.ones(3))
    assert (len(nowhere), len(none)) == (0, 0)


def test_jump_is_no_stationary_point() -> None:
    """Slopes of |x - 1|, in two pieces that meet at 1."""
    places, slopes = np.array([0.0, 1 - 1e-9, 1 + 1e-9, 2.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    joined = np.array([True, False, True])
    result, _ = extrema.find_stationary_points(
        lambda x: (np.sign(x - 1), np.zeros_like(x)), places, slopes, joined
    )
    assert len(result) == 0


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("noise", [0.0, 1e-14, -1e-14])
def test_tie_selects_first_angle(sign: int, noise: float) -> None:
    """A force that repeats every half cycle: rounding must not decide between its two peaks."""
    angles = 2 * np.pi * np.arange(360) / 360
    values = sign * (3 + np.cos(2 * angles - 0.7))
    values[200] += noise
    assert index_first_extremum(angles, values, sign) == 20
    values[210] += sign
    assert index_first_extremum(angles, values, sign) == 210


def test_tie_at_zero_stays_at_zero() -> None:
    angles = np.array([np.pi - 1e-13, 2 * np.pi - 1e-13, 1.0])
    assert index_first_extremum(angles, np.array([1.0, 1.0, 0.0]), 1) == 1
    assert index_first_extremum(angles, np.array([1.0, 0.5, 0.0]), 1) == 0


def test_constant_selects_start_of_cycle() -> None:
    assert index_first_extremum(np.arange(6.0), np.full(6, 7.0) + 1e-15 * np.arange(6), 1) == 0


def test_samples_near_peak_select_peak() -> None:
    angles = np.array([0.5 - 1e-5, 0.5, 0.5 + np.pi, 1.0])
    assert index_first_extremum(angles, np.array([1 - 1e-11, 1.0, 1.0, 0.0]), 1) == 1
