"""Extremes from samples: smooth ones, kinks, ends, periods, several at once, and what must be refused."""

from __future__ import annotations

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extremes
from planter.numerics.extremes import first_extreme

PERIOD = np.arange(48) * 2 * np.pi / 48


@pytest.mark.parametrize("place", [0.01, 1.234, 2.99])
def test_a_smooth_extreme_is_found_to_rounding(place: float) -> None:
    found = extremes.least(lambda x: 5 - np.cos(x - place), np.linspace(0, 3, 31))
    assert found.value == pytest.approx(4.0, rel=1e-15)
    assert found.place == pytest.approx(place, abs=1e-7)
    upside_down = extremes.largest(lambda x: np.cos(x - place) - 5, np.linspace(0, 3, 31))
    assert (upside_down.place, upside_down.value) == (found.place, -found.value)


def test_a_kink_is_found_to_what_is_promised() -> None:
    found = extremes.largest(lambda x: -np.abs(x - 100.0371), np.linspace(100, 101, 11))
    assert found.value == pytest.approx(0.0, abs=1e-8 * 0.1)


def test_an_end_is_an_extreme_of_an_interval_and_not_of_a_period() -> None:
    places = np.linspace(0.0, 1.0, 21)
    assert extremes.least(np.exp, places) == extremes.Extreme(0.0, 1.0)
    around = extremes.least(lambda x: np.cos(x + np.pi + 0.02), PERIOD, closed=True)
    assert around.value == pytest.approx(-1.0, rel=1e-15)
    assert around.place == pytest.approx(-0.02, abs=1e-7)


def test_the_deeper_of_two_hollows_where_samples_show_the_other() -> None:
    """The wide one is sampled at its bottom, the narrow one beside its own, which is the deeper one."""

    def function(x: Array) -> Array:
        return -np.exp(-(((x - 1.0) / 0.5) ** 2)) - 1.02 * np.exp(-(((x - 3.05) / 0.12) ** 2))

    places = np.linspace(0, 4, 41)
    assert abs(places[function(places).argmin()] - 1.0) < 1e-12
    found = extremes.least(function, places)
    assert found.value == pytest.approx(-1.02, rel=1e-6)
    assert found.place == pytest.approx(3.05, abs=1e-3)


def test_without_refinement_the_sample_would_be_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tampered case: with no room beside the best sample the value is wrong."""
    monkeypatch.setattr(extremes, "TRIED", 1)

    def function(x: Array) -> Array:
        return np.cos(3 * x)

    coarse = float(function(np.linspace(0, 2, 7)).min())
    found = extremes.least(function, np.linspace(0, 2, 7))
    assert coarse > found.value + 1e-3
    assert found.value == pytest.approx(-1.0, rel=1e-15)


def test_a_function_of_one_place() -> None:
    assert extremes.each(lambda x: x**2)(np.array([1.0, -3.0])).tolist() == [1.0, 9.0]


def test_a_constant_keeps_its_first_sample() -> None:
    assert extremes.least(np.zeros_like, PERIOD, closed=True) == extremes.Extreme(0.0, 0.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_named(bad: float) -> None:
    with pytest.raises(ComputationError, match=r"it is (nan|inf) at 2\.5"):
        extremes.least(lambda x: np.where(x == 2.5, bad, x), np.array([1.0, 2.5, 4.0]))


def test_stationary_places_are_those_of_the_derivative() -> None:
    def rates(x: Array) -> tuple[Array, Array]:
        return np.cos(2 * x), -2 * np.sin(2 * x)

    places = np.linspace(0, 2 * np.pi, 30)
    found, maxima = extremes.stationary(rates, places, rates(places)[0])
    assert found == pytest.approx(np.pi / 4 + np.pi / 2 * np.arange(4), rel=1e-15)
    assert maxima.tolist() == [True, False, True, False]
    nowhere, none = extremes.stationary(rates, places[:3], np.ones(3))
    assert (len(nowhere), len(none)) == (0, 0)


def test_a_jump_between_pieces_is_no_stationary_place() -> None:
    """Slopes of |x - 1|, in two pieces that meet at 1."""
    places, slopes = np.array([0.0, 1 - 1e-9, 1 + 1e-9, 2.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    joined = np.array([True, False, True])
    found, _ = extremes.stationary(lambda x: (np.sign(x - 1), np.zeros_like(x)), places, slopes, joined)
    assert len(found) == 0


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("noise", [0.0, 1e-14, -1e-14])
def test_of_ties_the_first_angle_counts(sign: int, noise: float) -> None:
    """A force that repeats every half cycle: rounding must not decide between its two peaks."""
    angles = 2 * np.pi * np.arange(360) / 360
    values = sign * (3 + np.cos(2 * angles - 0.7))
    values[200] += noise
    assert first_extreme(angles, values, sign) == 20
    values[210] += sign
    assert first_extreme(angles, values, sign) == 210


def test_a_tie_at_zero_is_not_a_cycle_later() -> None:
    angles = np.array([np.pi - 1e-13, 2 * np.pi - 1e-13, 1.0])
    assert first_extreme(angles, np.array([1.0, 1.0, 0.0]), 1) == 1
    assert first_extreme(angles, np.array([1.0, 0.5, 0.0]), 1) == 0


def test_a_constant_has_its_extreme_where_the_cycle_begins() -> None:
    assert first_extreme(np.arange(6.0), np.full(6, 7.0) + 1e-15 * np.arange(6), 1) == 0


def test_beside_a_peak_its_own_place_counts() -> None:
    angles = np.array([0.5 - 1e-5, 0.5, 0.5 + np.pi, 1.0])
    assert first_extreme(angles, np.array([1 - 1e-11, 1.0, 1.0, 0.0]), 1) == 1
