"""Outlines on pitch curves of every family and on circles, against swept racks and the textbook (ISO 53, ISO 21771)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from planter.errors import GeometryError
from planter.gears.geometry import pitch_curves
from planter.gears.geometry.cutting import ToothOrder, cut_teeth, size_pair
from planter.gears.geometry.flanks import Rack
from planter.gears.geometry.gear import KINDS, Gear
from tests.support import pairs
from tests.support.toothed import FREE, REFUSED, circle, circles, involute, stage, swept

GEARS = [
    ("eccentric_circle", 1, 32),
    ("ellipse", 8, 25),
    ("fourier", 0, 25),
    ("limacon", 8, 25),
    ("sine", 4, 25),
]
"""Of each family one: with hardly any undercut, with much, hollow and with loops of flanks and
fillets.
"""
ALIKE = [(family, seed) for family in sorted(pairs.FAMILIES) for seed in range(12)]


SEEDS = [(family, seed, (25, 32, 41, 60)[seed % 4]) for family, seed in ALIKE]


@pytest.mark.parametrize(
    ("family", "seed", "z"),
    [*GEARS, *(pytest.param(*curve, marks=pytest.mark.long) for curve in SEEDS)],
)
def test_pieces_join_to_a_simple_outline(family: str, seed: int, z: int) -> None:
    """One closed line, smooth but for tips and undercut flanks."""
    if (family, seed) in REFUSED:
        with pytest.raises(GeometryError, match=REFUSED[family, seed]):
            stage(family, seed, z)
        return
    for gear in stage(family, seed, z, FREE, (-1) ** seed).gears:
        ends = gear.sampled(np.array([0.0, 1.0]))
        after = np.roll(np.arange(len(gear.pieces.kind)), -1)
        np.testing.assert_allclose(ends.points[:, :, 1], ends.points[:, after, 0], atol=1e-12)
        (x, y), (u, v) = ends.tangents[:, :, 1], ends.tangents[:, after, 0]
        turn = np.abs(np.arctan2(x * v - y * u, x * u + y * v))
        kind, tip = gear.pieces.kind, KINDS.index("tip")
        assert np.degrees(turn[(kind != tip) & (kind[after] != tip)]).max() < 60
        assert shapely.Polygon(gear.sampled(np.arange(12) / 12).points.reshape(2, -1).T).is_valid
        assert gear.curve.length == pytest.approx(np.pi * gear.rack.module * gear.z, rel=1e-10)


def test_flanks_are_smooth_where_they_are_not_cut() -> None:
    gear = stage("eccentric_circle", 1, 32).gears[0]
    ends = gear.sampled(np.array([0.0, 1.0]))
    (x, y), (u, v) = ends.tangents[:, :, 1], np.roll(ends.tangents[:, :, 0], -1, axis=1)
    at_tip = (gear.pieces.kind == 2) | (np.roll(gear.pieces.kind, -1) == 2)
    assert np.abs(x * v - y * u)[~at_tip].max() < 1e-13


def test_tangents_and_curvatures_are_those_of_the_points() -> None:
    for piece in stage("sine", 4, 25).gears[1].outline()[:40:3]:
        s, h = np.linspace(0.1, 0.9, 5), 1e-5
        before, middle, after = (piece.at(s + step) for step in (-h, 0.0, h))
        chord, size = after - before, np.hypot(*(after - before).T)
        np.testing.assert_allclose(chord / size[:, None], piece.tangent(s), atol=1e-7)
        first, second = middle - before, after - middle
        turned = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / (size / 2) ** 3
        np.testing.assert_allclose(turned, piece.curvature(s), rtol=2e-2, atol=5)


@pytest.mark.parametrize(
    ("gear", "tooth"),
    [
        (lambda: circle(31, Rack(2e-3)), 3),
        (lambda: circle(10, Rack(2e-3)), 3),
        (lambda: stage("ellipse", 8, 25).gears[0], 24),
        (lambda: stage("eccentric_circle", 1, 32).gears[1], 20),
    ],
    ids=["circle", "undercut", "undercut at a joint", "joint"],
)
def test_a_swept_rack_leaves_the_outline(gear, tooth: int) -> None:
    assert swept(gear(), tooth, steps=1100) < 1e-5


def test_swept_rack_converges_quadratically_to_outline() -> None:
    coarse, fine = (swept(circle(31, Rack(2e-3)), 3, steps) for steps in (150, 300))
    assert 3.5 < coarse / fine < 4.5


def test_shifted_rack_leaves_another_outline() -> None:
    assert swept(circle(31, Rack(2e-3)), 3, steps=200, offset=5e-6) > 1e-3


@pytest.mark.long
@pytest.mark.parametrize(("family", "seed", "z"), GEARS)
def test_a_swept_rack_leaves_every_space(family: str, seed: int, z: int) -> None:
    gear = stage(family, seed, z).gears[0]
    if (gear.curve.bends(np.linspace(0, gear.curve.length, 500))[0] < 0).any():
        pytest.skip("a straight rack would cut beyond its envelope")
    assert max(swept(gear, tooth) for tooth in range(0, z, 2)) < 1e-5


def cut(curves: pitch_curves.CurvePair, z: int) -> tuple[Gear, Gear]:
    return cut_teeth(curves, replace(FREE, teeth=z), "pair", ("gear", "mate")).gears


def test_scaled_gears_are_similar() -> None:
    scaled = stage("limacon", 8, 25)
    curves = pitch_curves.build_stage_pair(
        pairs.stage("limacon", 8), pairs.parameters("limacon", 8)
    )
    other = cut(curves.scaled(1.7), 25)
    for a, b in zip(scaled.gears, other, strict=True):
        assert b.area == pytest.approx(1.7**2 * a.area, rel=1e-12)
        np.testing.assert_allclose(b.flanks.margins, a.flanks.margins, atol=1e-12)


def test_reversed_curve_exchanges_flanks() -> None:
    first, other = (
        stage("sine", 0, 25, FREE, sense).gears[0].flanks.margins.reshape(2, -1)
        for sense in (1, -1)
    )
    back = -np.arange(25) % 25
    np.testing.assert_allclose(first[0], other[1][back], atol=1e-12)
    assert np.abs(first[0] - other[0][back]).max() > 1e-3


def test_ellipses_with_odd_teeth_make_congruent_gears() -> None:
    """Undeformed: the mate is the same ellipse, its space where the gear has its tooth half a turn
    on.
    """
    family = "ellipse"
    parameters = pairs.parameters(family, 0).copy()
    parameters[-1] = 1.0
    curves = pitch_curves.build_stage_pair(pairs.stage_of(family, parameters), parameters)
    congruent = {}
    for z in (31, 32):
        first, second = cut(curves, z)
        congruent[z] = abs(first.area / second.area - 1) < 1e-12 and np.allclose(
            np.sort(first.flanks.margins), np.sort(second.flanks.margins), atol=1e-9
        )
    assert congruent == {31: True, 32: False}


@pytest.mark.parametrize("family", sorted(pairs.FAMILIES))
def test_whole_teeth_go_round(family: str) -> None:
    curves = pitch_curves.build_stage_pair(pairs.stage(family, 1), pairs.parameters(family, 1))
    original = size_pair(curves, replace(FREE, module=1.5e-3, keep="size"), family)
    scaled = size_pair(curves, replace(FREE, module=1.5e-3), family)
    for gear in (original, scaled):
        assert gear.pair.gear.length == pytest.approx(
            np.pi * gear.module * gear.teeth[0], rel=1e-12
        )
        assert gear.pair.mate.length == pytest.approx(gear.pair.gear.length, rel=1e-12)
    assert (original.scale, scaled.module) == (1.0, 1.5e-3)
    assert original.teeth == scaled.teeth == (round(curves.gear.length / np.pi / 1.5e-3),) * 2


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
