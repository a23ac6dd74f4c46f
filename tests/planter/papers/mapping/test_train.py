"""The gear train: closure, mating pitch curves, and what is told of its gears: small radii, near
cusps, hollow pitch curves, each with its carrier angle."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from scipy.integrate import cumulative_trapezoid

from planter.errors import ComputationError
from planter.numerics.arrays import TURN
from planter.papers.mapping import model
from planter.papers.mapping import train as trains
from planter.papers.mapping.curve import AngleCurve, load_curve
from planter.papers.mapping.train import GEARS, RADII, Train, polar_curves
from tests.support.cli import answer

A = 0.07


def harmonic(e: float, points: int = 720) -> Train:
    """1/i = 1 + e cos(theta)."""
    theta = np.linspace(0, TURN, points + 1)
    return Train(AngleCurve(theta, -theta - e * np.sin(theta)), A)


DEFAULT = Train(load_curve("sun2019-curve"), A)


@pytest.mark.parametrize("e", [0.1, 0.6, 0.9, 0.99])
def test_split_parameter_is_an_elliptic_integral(e: float) -> None:
    exact = 2 / np.pi * np.sqrt(1 + e) * scipy.special.ellipe(2 * e / (1 + e))
    assert harmonic(e).x_s == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("train", [DEFAULT, harmonic(0.6), harmonic(0.99)])
def test_both_stages_close(train: Train) -> None:
    assert np.abs(train.closure_errors).max() < 1e-12


def test_another_split_parameter_leaves_the_first_stage_open() -> None:
    wrong = Train(DEFAULT.curve, A)
    wrong.__dict__["x_s"] = DEFAULT.x_s * (1 + 1e-6)
    assert abs(wrong.closure_errors[0]) > 1e-6
    assert abs(wrong.closure_errors[1]) < 1e-12


def test_arcs_of_mating_curves_are_equal() -> None:
    """From the polar curves alone."""
    psi, radii = polar_curves(harmonic(0.6), samples=100_000)
    x, y = radii * np.cos(psi), radii * np.sin(psi)
    lengths = np.hypot(np.diff(x), np.diff(y)).sum(axis=1)
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
    assert lengths[2] == pytest.approx(lengths[3], rel=1e-3)
    assert psi[:, -1] == pytest.approx([TURN] * 4, abs=1e-12)


def test_radii_reach_their_extremes_with_the_slope() -> None:
    smallest, largest = DEFAULT.radius_range
    gears = DEFAULT.gears(np.linspace(0, TURN, 20001))
    for k, name in enumerate(RADII):
        assert (smallest[k], largest[k]) == pytest.approx(
            (gears[name].min(), gears[name].max()), abs=1e-8
        )
        assert 0 < smallest[k] < largest[k] < A


def test_swapping_driver_and_driven_gives_the_inverse_train() -> None:
    """The curve of the carrier against the arm: its train has the radii of the stages the other way
    round.
    """
    train = harmonic(0.5)
    theta = np.linspace(0, TURN, 721)
    turned = -train.curve.at(theta)
    back = Train(AngleCurve(turned, -theta), A)
    driven, again = train.gears(theta), back.gears(turned)
    assert again["i"] == pytest.approx(1 / driven["i"], rel=1e-5)


def test_stopping_curve_is_refused_with_angle() -> None:
    theta = np.linspace(0, TURN, 361)
    with pytest.raises(ComputationError, match=r"reaches zero at carrier angle 1[67]\d"):
        Train(AngleCurve(theta, -theta - 1.01 * np.sin(theta)), A)


def test_rising_curve_has_gears_of_falling_curve() -> None:
    curve = DEFAULT.curve
    mirrored = Train(AngleCurve(curve.carrier, -curve.relative, 1), A)
    assert mirrored.x_s == pytest.approx(DEFAULT.x_s, rel=1e-13)
    assert np.array(mirrored.radius_range) == pytest.approx(np.array(DEFAULT.radius_range))


A = 0.07


def named(train: Train) -> set[str]:
    return {warning.name for warning in trains.warnings(train)}


def test_readme_example_warns_of_cusp() -> None:
    result = answer("train", "sun2019-curve", "--crank-mm", "101.6")
    by_name: dict[str, list] = {}
    for warning in result["warnings"]:
        by_name.setdefault(warning["name"], []).append(warning)
    (cusp,) = by_name["cusp"]
    assert cusp["carrier_deg"] == pytest.approx(310.5, abs=1)
    assert "follower 2 is nearly a cusp, of a radius of 0.1722 mm" in cusp["message"]
    assert "a module of 0.138 mm on" in cusp["message"]
    (ratio,) = by_name["ratio"]
    assert "the total ratio is 9.416" in ratio["message"]
    assert "driver 2 is only 16.8 mm of 70 mm" in ratio["message"]
    assert {
        gear
        for gear in GEARS
        for warning in by_name["hollow pitch curve"]
        if gear in warning["message"]
    } == set(GEARS)
    assert result["module_max_mm"] == pytest.approx(min(result["curvature_radius_min_mm"]) / 1.25)


def test_each_warning_has_a_cause() -> None:
    for swing in np.linspace(0.1, 0.95, 12):
        train = harmonic(float(swing), 72)
        at = train.gears(np.linspace(0, TURN, 2001))
        extreme = max(max(at[name].max(), 1 / at[name].min()) for name in ("i1", "i2"))
        assert ("ratio" in named(train)) == (extreme >= trains.MOST_RATIO)
        assert ("hollow pitch curve" in named(train)) == (not all(train.convex))


def test_largest_module_is_where_offset_curve_folds() -> None:
    """A curve beside another one, d away, has a cusp where the radius of curvature is d: it stops
    there.
    """
    train = harmonic(0.9, 72)
    dense = np.linspace(0, TURN, 100_001)
    gears = model.gears(train.curve.slopes(dense)[0], train.x_s, A)
    folds = []
    for k in range(4):
        angle = cumulative_trapezoid(gears[f"dpsi{k + 1}"], dense, initial=0)
        curve = gears[f"r{k + 1}"] * np.exp(1j * angle)
        step = np.gradient(curve)
        normal = 1j * step / np.abs(step)
        for module in (0.97, 1.03):
            m = module * trains.largest_module(train)
            for depth in (trains.DEDENDUM * m, -trains.ADDENDUM * m):
                offset_curve = np.gradient(curve + depth * normal)[5:-5]
                folds.append((module, bool(np.any((offset_curve / step[5:-5]).real < 0))))
    assert not any(fold for module, fold in folds if module < 1)
    assert any(fold for module, fold in folds if module > 1)


def test_rising_curve_warns_of_idler() -> None:
    theta = np.linspace(0, TURN, 73)
    rising = Train(AngleCurve(theta, theta + 0.1 * np.sin(theta), 1), A)
    (message,) = trains.warnings(rising)
    assert (message.name, message.carrier_deg) == ("sense", None)
    assert "idler" in message.message
