"""Which pairs of teeth bear, where, and how they share a load: beside solved contacts, and
textbooks' round gears.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothedPair, ToothOrder
from planter.gears.geometry.mesh import SIDES, BearingPairs, find_changes
from planter.gears.geometry.pitch_curves import POLAR
from planter.kernels import Array
from planter.numerics import piecewise
from tests.support.toothed import FREE, circles, stage

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
