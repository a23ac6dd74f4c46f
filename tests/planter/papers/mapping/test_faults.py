"""What is told of the gears of a train: small radii, near cusps, hollow pitch curves, each with its
carrier angle.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from planter.numerics.arrays import TURN
from planter.papers.mapping import model
from planter.papers.mapping import train as trains
from planter.papers.mapping.curve import AngleCurve
from planter.papers.mapping.train import GEARS, Train
from tests.support.cli import answer

A = 0.07


def harmonic(swing: float, points: int = 73) -> Train:
    theta = np.linspace(0, TURN, points)
    return Train(AngleCurve(theta, -theta - swing * np.sin(theta)), A)


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


def test_gentle_gears_have_no_warnings() -> None:
    assert trains.warnings(harmonic(0.1)) == []
    assert named(harmonic(0.6)) != set()


def test_each_warning_has_a_cause() -> None:
    for swing in np.linspace(0.1, 0.95, 12):
        train = harmonic(float(swing))
        at = train.gears(np.linspace(0, TURN, 2001))
        extreme = max(max(at[name].max(), 1 / at[name].min()) for name in ("i1", "i2"))
        assert ("ratio" in named(train)) == (extreme >= trains.MOST_RATIO)
        assert ("hollow pitch curve" in named(train)) == (not all(train.convex))


def test_largest_module_is_where_offset_curve_folds() -> None:
    """A curve beside another one, d away, has a cusp where the radius of curvature is d: it stops
    there.
    """
    train = harmonic(0.9)
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
