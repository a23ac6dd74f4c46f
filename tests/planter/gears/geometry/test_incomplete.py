"""Incomplete gears: exact joins, no interference all round the turn, drive and dwell as the
outlines allow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.integrate import simpson
from scipy.optimize import brentq

from planter.errors import GeometryError
from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.intermittent_gears import IntermittentPair, build_intermittent_pair
from planter.gears.geometry.intermittent_proof import SIDES, IncompleteGearCycle, RowMesh
from planter.gears.geometry.locking_arcs import Rolling

R, WAVE, SHIFT, FIRST, LAST = 0.03, 0.1, 0.2, -2.4, 2.5
_T = np.linspace(FIRST, LAST, 20001)
PLAY = 4e-5
MODULE = 2.29e-3
SEEN = 1e-9 * 1e-6
"""What the issue allows the outlines to share [m2]."""


def radius(t: np.ndarray) -> np.ndarray:
    """A wavy curve, neither end like the other."""
    return R * (1 + WAVE * np.cos(t + SHIFT))


def turned(distance: float) -> float:
    """How far its mate turns over the teeth, by hand."""
    return float(simpson(radius(_T) / (distance - radius(_T)), x=_T))


A = brentq(lambda a: turned(a) - 2 * np.pi, 1.5 * R, 3 * R, xtol=1e-16)
"""The centre distance at which that is once."""


def rolling(distance: float = A) -> Rolling:
    return Rolling.from_radius(radius, (FIRST, LAST), np.array([FIRST, LAST]), distance)


@pytest.fixture(scope="module")
def pair() -> IntermittentPair:
    return build_intermittent_pair(
        rolling(), MODULE, ToothOrder(play=PLAY, process="wire"), "wavy", ("one", "two")
    )


@pytest.fixture(scope="module")
def turn(pair: IntermittentPair) -> IncompleteGearCycle:
    return IncompleteGearCycle(pair)


def test_the_curves_roll(pair: IntermittentPair) -> None:
    """Both pitch points lie in one place of the line of centres, and the mate turns by the integral
    of the ratio.
    """
    curves = pair.rolling
    at = np.linspace(0, curves.length, 50)
    angles = []
    for curve, s, place in zip(
        curves.pair.curves,
        (curves.lead + at, curves.behind + curves.length - at),
        curves.places(at),
        strict=True,
    ):
        x, y = curve.at(s)[:2]
        angles.append((x + 1j * y) * np.exp(1j * place[0]) + place[1])
    assert np.abs(angles[0] - angles[1]).max() < 1e-14
    assert np.abs(angles[0].imag).max() < 1e-14
    assert curves.turned == pytest.approx(turned(A), abs=1e-11)


def test_mate_without_a_full_turn_is_refused() -> None:
    with pytest.raises(GeometryError, match="must turn by 360 deg"):
        build_intermittent_pair(
            rolling(1.05 * A), MODULE, ToothOrder(process="wire"), "wavy", ("one", "two")
        )


def test_pieces_join_exactly_and_outlines_are_simple(pair: IntermittentPair) -> None:
    for gear in pair.gears:
        assert gear.joins < 1e-14
        assert shapely.Polygon(gear.points).is_valid
        shares = np.linspace(0, 1, 9)
        for piece in gear.outline():
            assert np.hypot(*piece.tangent(shares).T) == pytest.approx(1, abs=1e-9)


def test_arcs_lie_about_the_driving_axis_while_they_hold(pair: IntermittentPair) -> None:
    mate = pair.rolling.dwell_positions(np.array([0.5]))[1][:, 0]
    arcs = [piece for piece in pair.mate.trimmed if piece.kind == "concave arc"]
    assert arcs
    for piece in arcs:
        z = piece.at(np.linspace(0, 1, 11)) @ np.array([1, 1j]) * np.exp(1j * mate[0]) + mate[1]
        assert np.abs(z) == pytest.approx(pair.radius + pair.arc_clearance, abs=1e-15)
        assert (piece.curvature(np.zeros(1)) < 0).all()
    (convex,) = [piece for piece in pair.gear.trimmed if piece.kind == "convex arc"]
    assert np.hypot(*convex.at(np.linspace(0, 1, 11)).T) == pytest.approx(pair.radius, abs=1e-15)


def test_intermittent_pair_is_free_of_interference(turn: IncompleteGearCycle) -> None:
    assert len(turn.rolled) >= 720
    assert turn.rolling.max() < SEEN
    assert turn.dwell_overlaps.max() < SEEN


def test_teeth_drive_where_the_mate_cannot_be_turned_back(
    pair: IntermittentPair, turn: IncompleteGearCycle
) -> None:
    """Contacts by formulas against outlines that know none: turned back by more than the play,
    teeth run into teeth.
    """
    indices = np.arange(5, 720, 25)
    gear, mate = pair.rolling.places(turn.rolled[indices])
    back = mate + np.array([[-3 * PLAY / A], [0.0], [0.0]])
    runs = turn.overlaps(gear, back) > 1e-12
    drives = turn.drives[0][indices]
    assert runs[drives].all()
    assert drives.mean() > 0.8
    predicted = pair.phase.undriven
    assert turn.undriven == pytest.approx(predicted, abs=np.radians(1.5))


def test_teeth_transmit_the_law_unless_moved(
    pair: IntermittentPair, turn: IncompleteGearCycle
) -> None:
    assert np.abs(turn.contacts.errors).max() < 1e-11
    flanks = pair.mate.flanks
    moved = replace(pair.mate, flanks=replace(flanks, phase=flanks.phase + 5e-6))
    mesh = RowMesh.from_pair(replace(pair, mate=moved))
    few = turn.rolled[200:500:50]
    assert np.abs(Contacts(mesh, mesh.facing(few)).errors).min() > 1e-5


def test_contact_ratios_agree_with_counts(
    pair: IntermittentPair, turn: IncompleteGearCycle
) -> None:
    """Of a tooth in the middle, which no arc has cut."""
    fine = np.linspace(0, pair.rolling.length, 8001)
    middle = pair.gear.z // 2
    ratios = turn.mesh.contact_ratios
    assert pair.gear.z < len(ratios) < 2 * pair.gear.z
    for side in SIDES:
        counted = (
            turn.mesh.touching(fine, side)[:, middle].mean() * pair.rolling.length / turn.mesh.pitch
        )
        assert np.abs(ratios - counted).min() < 2e-3
        assert ratios.min() - 2e-3 < counted < ratios.max() + 2e-3


def test_the_arcs_hold_in_the_dwell_and_not_without(
    pair: IntermittentPair, turn: IncompleteGearCycle
) -> None:
    loose = turn.loose
    inside = (loose.part == 3) & (
        np.abs(loose.at - pair.rolling.over[1] - pair.rolling.dwell / 2) < 0.2
    )
    assert max(loose.behind[inside].max(), loose.ahead[inside].max()) < np.radians(2)
    gear, mate = pair.rolling.dwell_positions(np.array([0.5]))
    for sense in (-1, 1):
        assert (
            turn.overlaps(gear, mate + np.array([[sense * np.radians(3)], [0.0], [0.0]]))[0] > 1e-8
        )


def untrimmed(pair: IntermittentPair, k: int) -> IntermittentPair:
    """With the whole teeth of one gear, the first at the dwell, in place of what arcs and topping
    leave.
    """
    gear, key = replace(pair.gears[k], trimmed=()), ("gear", "mate")[k]
    if k == 0:
        phase = gear.flanks.phase - pair.phase.first + gear.rack.pitch / 2
        gear = replace(gear, flanks=replace(gear.flanks, phase=phase))
    return replace(pair, **{key: gear})


def test_tampered_gears_interfere(pair: IntermittentPair, turn: IncompleteGearCycle) -> None:
    few = np.linspace(0, 1, 30)
    dwell = pair.rolling.dwell_positions(few)
    for k in (0, 1):
        assert IncompleteGearCycle(untrimmed(pair, k)).overlaps(*dwell).max() > 1e-7
    gear, mate = pair.rolling.places(few * pair.rolling.length)
    assert turn.overlaps(gear, mate - np.array([[0.0], [2 * PLAY], [0.0]])).max() > 1e-10
    assert turn.overlaps(gear, mate + np.array([[3 * PLAY / A], [0.0], [0.0]])).max() > 1e-10
