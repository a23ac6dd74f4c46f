"""Teeth in mesh: contacts, gaps, polygons, pairs that bear, remedies; and wrong gears are found."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.optimize import brentq

from planter.errors import GeometryError
from planter.gears.geometry import cutting, pitch_curves, polygons
from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.mesh import SIDES, BearingPairs, Mesh, find_changes
from planter.gears.geometry.pitch_curves import POLAR, build_stage_pair
from planter.gears.geometry.polygons import FINE_CHORDS, Overlay
from planter.gears.geometry.stage import Stage
from planter.kernels import Array
from planter.numerics import piecewise
from tests.support import pairs
from tests.support.toothed import FREE, REFUSED, circles, involute, stage

PLAY = 5e-5
COS = math.cos(math.radians(20))
MESHES = [
    ("eccentric_circle", 1, 32),
    ("ellipse", 8, 25),
    ("fourier", 0, 25),
]
EVERY = [
    (family, seed, (25, 32, 41, 60)[seed % 4])
    for family in sorted(pairs.FAMILIES)
    for seed in range(10)
    if (family, seed) not in REFUSED
]


@pytest.mark.parametrize(
    ("family", "seed", "z"),
    [*MESHES, *(pytest.param(*curve, marks=pytest.mark.long) for curve in EVERY)],
)
def test_flanks_are_conjugate(family: str, seed: int, z: int) -> None:
    """Without play; with it the gap is that of the rack everywhere, and teeth always touch."""
    assert np.abs(stage(family, seed, z).contacts.errors).max() < 1e-11
    loose = stage(family, seed, z, replace(FREE, play=PLAY))
    np.testing.assert_allclose(loose.contacts.gaps, PLAY / 2 * COS, atol=1e-13)
    assert loose.overlaps.max() == 0 or family in ("fourier", "limacon", "sine")
    if loose.mesh.laps.min() > PLAY:
        for side in (-1.0, 1.0):
            facing = loose.contacts.faced.side == side
            assert len(np.unique(loose.contacts.faced.at[facing])) == len(loose.mesh.positions)


def test_lost_motion_is_the_gap_over_the_arm_of_the_normal() -> None:
    pair = stage("ellipse", 0, 31, replace(FREE, play=PLAY))
    mesh, s = pair.mesh, pair.mesh.positions
    x, y, tx, ty = mesh.gear.curve.at(s)[:4]
    lean = np.arctan2(x * tx + y * ty, x * ty - y * tx)
    arm = mesh.pair.distance - np.hypot(x, y)
    for column, side in ((0, -1), (1, 1)):
        expected = PLAY / 2 * COS / (arm * np.cos(math.radians(20) + side * lean))
        lost = pair.lost_motion.reshape(-1, 2)[:, column]
        np.testing.assert_allclose(lost, expected, atol=1e-6)
        assert np.abs(lost - expected).max() < 0.02 * expected.max()


@pytest.mark.parametrize("more", [1e-7, 2e-5, 6e-4])
def test_circles_farther_apart_agree_with_involutes(more: float) -> None:
    """Base circles stay, and the angle of contact grows to that of the new distance."""
    pair = circles(25, 50, ToothOrder(play=PLAY))
    base, farther = 25e-3 * COS, pair.farther(more)
    assert farther is not None
    a = pair.mesh.pair.distance + more
    angle = math.acos(3 * base / a)
    opened = 3 * base * (involute(angle) - involute(math.radians(20)))
    expected = (opened + PLAY / 2 * COS) / (2 * base)
    np.testing.assert_allclose(farther.lost_motion, np.full((720, 2), expected), rtol=1e-9)
    tips = math.sqrt(27e-3**2 - base**2) + math.sqrt(52e-3**2 - (2 * base) ** 2)
    path = tips - a * math.sin(angle)
    np.testing.assert_allclose(farther.contact_ratios, path / (math.pi * 2e-3 * COS), rtol=1e-12)


def test_circles_lose_contact_at_contact_ratio_unity() -> None:
    pair, base = circles(25, 50, ToothOrder(play=PLAY)), 25e-3 * COS

    def ratio(more: float) -> float:
        a = pair.mesh.pair.distance + more
        tips = math.sqrt(27e-3**2 - base**2) + math.sqrt(52e-3**2 - (2 * base) ** 2)
        return (tips - math.sqrt(a**2 - (3 * base) ** 2)) / (math.pi * 2e-3 * COS)

    limit = brentq(lambda more: ratio(more) - 1, 0, 3e-3)
    assert pair.farther(limit - 2e-6) is not None
    assert [pair.farther(more) for more in (limit + 2e-6, 3.9e-3)] == [None] * 2


def test_sides_of_lost_motion_stop_the_mate_as_polygons() -> None:
    """Turned by the lost motion to either side, polygons of the mate touch those of the gear and do
    not overlap.
    """
    pair = stage("ellipse", 0, 31, replace(FREE, play=PLAY))
    farther = pair.farther(2e-4)
    assert farther is not None
    overlay, where, some = (
        Overlay.from_mesh(farther.mesh),
        pair.mesh.positions,
        np.arange(0, 720, 90),
    )
    first, second = overlay.placed(where[some])
    axis = [(farther.mesh.pair.distance, 0.0)] * len(some)
    for column, sense in ((0, -1), (1, 1)):
        lost = sense * farther.lost_motion[some, column]
        for share, touches in ((0.98, False), (1.02, True)):
            turned = [
                shapely.affinity.rotate(part, share * turn, centre, use_radians=True)
                for part, turn, centre in zip(second, lost, axis, strict=True)
            ]
            assert (shapely.area(shapely.intersection(first, turned)) > 1e-12).tolist() == [
                touches
            ] * len(some)


def test_polygons_keep_the_gap_and_overlap_nowhere() -> None:
    for pair in (
        stage("eccentric_circle", 1, 32, replace(FREE, play=PLAY)),
        circles(23, 41, ToothOrder(play=PLAY)),
    ):
        gap = pair.polygon_gaps
        assert gap.min() >= PLAY / 2 * COS - 1e-13
        assert gap.max() < PLAY / 2 * COS + 2e-6
        assert pair.overlaps.max() == 0
    touching = stage("eccentric_circle", 1, 32)
    assert touching.overlaps.max() < 1e-16
    assert touching.polygon_gaps.max() < 1e-6


def test_contact_ratio_below_unity_is_refused() -> None:
    """On circles the rolling length that two pairs share is the contact ratio's excess over one, in
    pitches.
    """
    mesh = circles(20, 30, ToothOrder()).mesh
    np.testing.assert_allclose(mesh.laps, (mesh.contact_ratios[0] - 1) * mesh.pitch, rtol=1e-9)
    with pytest.raises(
        GeometryError,
        match=r"the contact ratio of tooth \d+ of gear with tooth \d+ of mate is 0.74",
    ):
        circles(40, 40, ToothOrder(addendum=0.4))


def test_sliding_agrees_with_pitch_point_distance() -> None:
    pair = circles(20, 30, ToothOrder())
    path = math.pi * 2e-3 * COS * pair.mesh.contact_ratios[0]
    tip = math.sqrt(22e-3**2 - (20e-3 * COS) ** 2) - 20e-3 * math.sin(math.radians(20))
    assert Contacts(pair.mesh, pair.mesh.ends).sliding.max() == pytest.approx(
        max(tip, path - tip) * (1 + 20 / 30), rel=1e-9
    )


def test_mate_turns_once_in_several_gear_turns() -> None:
    curves = pitch_curves.build_contact_pair(lobe(2), 0.09, np.linspace(0, 2 * np.pi, 3), turns=2)
    assert curves.mate.length == pytest.approx(2 * curves.gear.length, rel=1e-13)
    pair = cut_teeth(curves, replace(FREE, teeth=30), "pair", ("gear", "mate"))
    assert pair.sized.teeth == (30, 60)
    assert np.abs(pair.contacts.errors).max() < 1e-11
    assert pair.overlaps.max() < 1e-14


def lobe(turns: int):
    """A contact with a cosine for its ratio, whose mate turns once in so many turns."""
    distance, share = 0.09, 0.15

    def contact(t: Array) -> Array:
        f = (1 + share * np.cos(t)) / turns
        df, ddf = -share * np.sin(t) / turns, -share * np.cos(t) / turns
        r = distance * f / (1 + f)
        dr = distance * df / (1 + f) ** 2
        ddr = distance * (ddf / (1 + f) ** 2 - 2 * df**2 / (1 + f) ** 3)
        return np.array([r, dr, ddr, f, df, (t + share * np.sin(t)) / turns])

    return contact


@pytest.fixture(scope="module")
def sound() -> ToothedPair:
    return stage("eccentric_circle", 1, 32, replace(FREE, play=1e-6))


def overlaps(overlay: Overlay) -> bool:
    return bool(overlay.overlaps(overlay.mesh.positions).max() > 0)


def cut_mate(pair: ToothedPair, **changes: object) -> Mesh:
    """The mesh with a mate that was cut otherwise."""
    flanks = replace(pair.mesh.mate.flanks, **changes)
    return replace(pair.mesh, mate=Gear("mate", flanks))


def test_half_a_tooth_offset_is_detected(sound: ToothedPair) -> None:
    assert not overlaps(Overlay.from_mesh(cut_mate(sound)))
    slipped = Overlay.from_mesh(cut_mate(sound, phase=0.0))
    with pytest.raises(GeometryError, match=r"the teeth overlap by 0\.\d+ modules"):
        cutting.check_penetration(slipped.mesh, slipped.deepest, "pair")


def test_depth_agrees_with_nearer_axes() -> None:
    """Flanks of circles, brought nearer by little, reach into each other by that times the sine of
    the angle.
    """
    mesh, nearer = circles(25, 50, FREE).mesh, 1e-5
    close = replace(mesh, pair=replace(mesh.pair, distance=mesh.pair.distance - nearer))
    depths = Overlay.from_mesh(close, FINE_CHORDS).depths(mesh.positions[:20])
    np.testing.assert_allclose(depths, nearer * math.sin(math.radians(20)), rtol=0.1)
    cutting.check_penetration(mesh, Overlay.from_mesh(mesh, FINE_CHORDS).deepest, "pair")
    with pytest.raises(GeometryError, match=r"the teeth overlap by 0\.001\d+ modules"):
        cutting.check_penetration(close, Overlay.from_mesh(close, FINE_CHORDS).deepest, "pair")


def test_axes_too_near_are_detected(sound: ToothedPair) -> None:
    closer = replace(sound.mesh.pair, distance=sound.mesh.pair.distance - 1e-5)
    mesh = replace(sound.mesh, pair=closer)
    assert overlaps(Overlay.from_mesh(mesh))
    contacts = Contacts(mesh, mesh.facing(mesh.positions))
    assert contacts.gaps.min() < -2e-6
    assert np.abs(contacts.errors).max() > 1e-6


@pytest.mark.parametrize(("first", "last"), [(0, None), (300, 308), (302, 303)])
def test_moved_outline_is_detected(sound: ToothedPair, first: int, last: int | None) -> None:
    """A whole gear is turned; a tooth, a point of a flank are moved along and outwards."""
    outline, mate = Overlay.from_mesh(sound.mesh).outlines
    if last is None:
        moved = shapely.affinity.rotate(outline, -1e-4, (0, 0), use_radians=True)
    else:
        points = shapely.get_coordinates(outline)
        for shift in ([[0, 1], [-1, 0]], np.eye(2)):
            part = points[first:last]
            part += 5e-6 * part / np.hypot(*part.T)[:, None] @ shift
        moved = shapely.Polygon(points)
    assert overlaps(Overlay(sound.mesh, (moved, mate)))


def test_a_flank_of_another_rack_is_not_conjugate(sound: ToothedPair) -> None:
    mesh = cut_mate(sound, rack=replace(sound.mesh.gear.rack, pressure_angle=math.radians(20.01)))
    assert np.abs(Contacts(mesh, mesh.facing(mesh.positions)).errors).max() > 1e-7


PAIRS = [("ellipse", 8, 25, 1), ("eccentric_circle", 1, 32, -1)]


def mean(pair: ToothedPair, side: int, values: Array) -> Array:
    """Means over a period of rows that are taken at `nodes`."""
    return np.asarray(values @ nodes(pair, side)[1])


def nodes(pair: ToothedPair, side: int) -> tuple[Array, Array]:
    """Rolling lengths between which no pair of a side comes, goes or passes the pitch point, with
    weights of means.
    """
    mesh = pair.mesh
    at, sides = find_changes(mesh)
    period = mesh.period * mesh.pitch
    ends = np.unique(np.mod(at[sides == SIDES[side]], period))
    places, weights = piecewise.gauss_panels(np.append(ends, ends[0] + period), 2)
    return places.ravel(), weights.ravel() / period


@pytest.mark.parametrize(("family", "seed", "z", "sense"), PAIRS)
def test_pairs_bear_where_their_flanks_touch(family: str, seed: int, z: int, sense: int) -> None:
    """The pitch point is on the normal of every solved contact, at the distance that is told."""
    pair = stage(family, seed, z, FREE, sense)
    mesh = pair.mesh
    at = mesh.positions[::9] + 1e-7
    faced, beyond = mesh.facing(at), BearingPairs.from_mesh(mesh, at).beyond
    points = Contacts(mesh, faced).points
    for k, place in enumerate(at):
        radius = float(np.hypot(*mesh.gear.curve.at(mesh.pair.sense * at[k : k + 1])[:2])[0])
        for side, margin in zip(SIDES, beyond, strict=True):
            arms = points[:, (faced.at == place) & (faced.side == side)] - np.array(
                [[radius], [0.0]]
            )
            solved = np.sort(-side * np.sign(arms[1]) * np.hypot(*arms))
            assert margin[: len(solved), k] == pytest.approx(solved, abs=1e-13)
            assert np.isnan(margin[len(solved) :, k]).all()
    assert np.nanmin(np.abs(BearingPairs.from_mesh(mesh, at + 1e-5).beyond - beyond)) > 5e-6


@pytest.mark.parametrize(("family", "seed", "z", "sense"), PAIRS)
@pytest.mark.parametrize("side", [0, 1])
def test_as_many_pairs_bear_as_the_contact_ratio_says(
    family: str, seed: int, z: int, sense: int, side: int
) -> None:
    pair = stage(family, seed, z, FREE, sense)
    bearing = BearingPairs.from_mesh(pair.mesh, nodes(pair, side)[0])
    count = mean(pair, side, np.isfinite(bearing.beyond[side]).sum(axis=0))
    assert count == pytest.approx(
        pair.mesh.contact_ratios[pair.mesh.pairs.side == SIDES[side]].mean(), abs=1e-9
    )


@pytest.mark.parametrize(("z", "mate", "shift"), [(31, 31, 0.0), (24, 57, 0.3), (40, 19, -0.2)])
def test_circular_gear_losses_agree_with_textbooks(z: int, mate: int, shift: float) -> None:
    """H_v = pi (u + 1)/(z u) (1 - e + e1^2 + e2^2): Niemann, Winter: Maschinenelemente II, pairs
    sharing alike.

    It is the power lost per power and coefficient of friction, the normal force being the same at
    all times.
    """
    pair = circles(z, mate, ToothOrder(shift=shift, allow_undercut=True))
    first, second = (arcs[0] / pair.mesh.pitch for arcs in pair.mesh.arcs)
    u, radii = mate / z, (1e-3 * z, 1e-3 * mate)
    textbook = math.pi * (u + 1) / (z * u) * (1 - first - second + first**2 + second**2)
    for side in (0, 1):
        bearing = BearingPairs.from_mesh(pair.mesh, nodes(pair, side)[0])
        per_distance = sum(1 / r for r in radii) / math.cos(pair.order.pressure_angle)
        assert mean(pair, side, bearing.equal.away[side]) * per_distance == pytest.approx(
            textbook, rel=1e-11
        )
        assert mean(pair, side, bearing.nearest.away[side]) * per_distance < 0.9 * textbook
        assert mean(pair, side, bearing.farthest.away[side]) * per_distance > 1.1 * textbook


@pytest.mark.parametrize("sense", [1, -1])
def test_arc_of_a_polar_angle_leads_there(sense: int) -> None:
    curve = stage("ellipse", 8, 25, FREE, sense).mesh.gear.curve
    polar = np.linspace(-9, 9, 400)
    assert curve.at(curve.arc(polar))[POLAR] == pytest.approx(polar, abs=1e-13)


DEPTH = 0.0083885404
"""Depth in modules to which teeth on a hollow curve run into each other."""


def hollow(eccentricity: float, teeth: int, tip_radius: float = 1.0) -> ToothedPair:
    """A deformed eccentric circle that is hollow on either side."""
    parameters = np.array([0.031, eccentricity, 1.9])
    stage: Stage = pairs.stage_of("eccentric_circle", parameters)
    return cut_teeth(
        build_stage_pair(stage, parameters),
        replace(FREE, teeth=teeth, tip_radius=tip_radius),
        "pair",
        ("gear", "mate"),
    )


def test_suggested_racks_are_just_sufficient() -> None:
    curves = hollow(0.012, 31)
    with pytest.raises(
        GeometryError, match=r"overlap by .* modules, .* mm, at the polar angle .* would do$"
    ) as message:
        cutting.check_pair_penetration(curves)
    first, clearance, second = map(
        float, re.findall(r"(?:radius|clearance) of ([\d.]+)", str(message.value))
    )
    offered = [
        replace(FREE, tip_radius=first),
        replace(FREE, clearance=clearance, tip_radius=second),
    ]
    short = [
        replace(FREE, tip_radius=first + 0.01),
        replace(offered[1], clearance=clearance - 0.01),
    ]
    assert second == 0.37
    assert [cutting.passes_limits(curves, order) for order in (*offered, *short)] == [
        True,
        True,
        False,
        False,
    ]


def test_advised_rack_does_not_interfere_when_cut_again() -> None:
    """Four times as many chords and positions see no more than the limit: the advice does not rest
    on coarse ones.
    """
    curves = hollow(0.012, 31, tip_radius=0.17)
    fine = {kind: 4 * count for kind, count in polygons.FINE_CHORDS.items()}
    at = np.linspace(-2, 2, 801) * curves.mesh.pitch + curves.deepest.place
    depth = polygons.Overlay.from_mesh(curves.mesh, fine).depths(at).max()
    assert 0 < depth < cutting.MAX_PENETRATION * curves.sized.module
    assert depth == pytest.approx(curves.deepest.value, abs=2e-4 * curves.sized.module)


@pytest.mark.parametrize("module_mm", [0.1, 100.0])
def test_penetration_is_the_same_at_any_size(module_mm: float) -> None:
    parameters = np.array([0.031, 0.0115, 1.9])
    curves = build_stage_pair(pairs.stage_of("eccentric_circle", parameters), parameters)
    size = np.pi * 31 * module_mm * 1e-3 / curves.gear.length
    pair = cut_teeth(curves.scaled(size), replace(FREE, teeth=31), "pair", ("gear", "mate"))
    assert pair.sized.module == pytest.approx(module_mm * 1e-3, rel=1e-12)
    assert pair.deepest.value / pair.sized.module == pytest.approx(DEPTH, rel=1e-8)
    with pytest.raises(GeometryError, match=r"overlap by 0\.008\d+ modules"):
        cutting.check_penetration(pair.mesh, pair.deepest, "pair")


def test_missing_remedy_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "MAX_CLEARANCE", 0.3)
    assert cutting.suggest_racks(hollow(0.015, 41)).startswith(
        "no smaller tip radius of the rack and no clearance"
    )
