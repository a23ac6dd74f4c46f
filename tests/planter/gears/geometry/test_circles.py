"""Teeth on circles against the textbook: involutes, thickness, undercut, contact ratio (ISO 53, ISO
21771).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.flanks import Rack
from tests.support.toothed import FREE, circle, circles, involute

ROUNDING = 1e-9


def draw_gear(seed: int) -> tuple[int, Rack]:
    """A number of teeth and a rack at random."""
    rng = np.random.default_rng(seed)
    module, angle = rng.uniform((5e-4, 14), (8e-3, 25))
    x, play = rng.uniform((-0.2, 0.0), (0.4, 0.15))
    return int(rng.integers(9, 90)), Rack(module, math.radians(angle), shift=x, play=play * module)


@pytest.mark.parametrize("seed", range(8))
def test_flanks_are_involutes_with_shift_and_backlash(seed: int) -> None:
    z, rack = draw_gear(seed)
    gear, alpha = circle(z, rack), rack.pressure_angle
    r = rack.module * z / 2
    base = r * math.cos(alpha)
    thick = rack.module * (math.pi / 2 + 2 * rack.shift * math.tan(alpha)) - rack.play / 2
    flanks = gear.sampled(np.linspace(0, 1, 9), np.flatnonzero(gear.pieces.kind == 1))
    radius = np.hypot(*flanks.points)
    middle = 2 * np.pi * gear.pieces.tooth[gear.pieces.kind == 1] / z
    aside = np.abs(
        np.mod(np.arctan2(*flanks.points[::-1]) - middle[:, None] + np.pi, 2 * np.pi) - np.pi
    )
    at = np.arccos(np.minimum(base / radius, 1.0))
    expected = thick / (2 * r) + involute(alpha) - (np.tan(at) - at)
    np.testing.assert_allclose(aside * radius, expected * radius, atol=ROUNDING * rack.module)
    tip = r + (1 + rack.shift) * rack.module
    assert radius.max() == pytest.approx(tip, rel=1e-12)
    assert gear.root_radius == pytest.approx(r - (1.25 - rack.shift) * rack.module, rel=1e-12)
    at_tip = math.acos(base / tip)
    land = 2 * tip * (thick / (2 * r) + involute(alpha) - involute(at_tip))
    np.testing.assert_allclose(gear.top_lands, land, rtol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_undercut_margin_agrees_with_minimum_tooth_count(seed: int) -> None:
    z, rack = draw_gear(seed)
    smallest = 2 * (1 - rack.shift) / math.sin(rack.pressure_angle) ** 2
    gear = circle(z, rack)
    np.testing.assert_allclose(gear.flanks.margins, 1 - smallest / z, atol=ROUNDING)
    assert (gear.flanks.margins < 0).any() == (z < smallest)


def test_undercut_is_refused_by_default_and_names_teeth() -> None:
    with pytest.raises(
        GeometryError, match=r"gear: the flanks of tooth 0, 1, 2, 3, 4, 5 and 8 more are undercut"
    ):
        circles(14, 40, ToothOrder())
    assert (
        circles(14, 40, FREE).mesh.contact_ratios.min()
        < circles(18, 40, ToothOrder()).mesh.contact_ratios.min()
    )


@pytest.mark.parametrize(
    ("z", "mate", "shift"), [(19, 19, 0.0), (24, 61, 0.0), (22, 35, 0.2), (30, 30, -0.3)]
)
def test_contact_ratio_of_spur_gears_ignores_backlash(z: int, mate: int, shift: float) -> None:
    alpha, m = math.radians(20), 2e-3
    tips = [
        (m * z / 2 + (1 + shift) * m, m * z / 2),
        (m * mate / 2 + (1 - shift) * m, m * mate / 2),
    ]
    path = sum(math.sqrt(t**2 - (r * math.cos(alpha)) ** 2) - r * math.sin(alpha) for t, r in tips)
    expected = path / (math.pi * m * math.cos(alpha))
    for play in (0.0, 1e-4):
        ratio = circles(z, mate, replace(FREE, shift=shift, play=play)).mesh.contact_ratios
        np.testing.assert_allclose(ratio, expected, rtol=1e-9)


def test_pressure_angle_and_lost_motion_are_those_of_circles() -> None:
    pair = circles(25, 50, ToothOrder(play=1e-4))
    assert np.degrees(pair.pressure_angles) == pytest.approx([20, 20], abs=1e-9)
    np.testing.assert_allclose(pair.lost_motion, 0.5e-4 / (1e-3 * 50), rtol=1e-9)


def test_pointed_tips_are_refused() -> None:
    with pytest.raises(
        GeometryError, match=r"mate: tooth \d has a top land of 0.038\d modules, where 0.2"
    ):
        circles(40, 9, replace(FREE, shift=-0.6))
