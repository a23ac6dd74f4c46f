"""Arcs along exact pieces: never farther than told, seen from either side, on the right side of the chord."""

from dataclasses import replace

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.workshop.arcs import Arcs, ClosedCurve, fit_arcs
from tests.support.outlines import Lobes, between, lobes, sampled

TOLERANCE = 1e-6
EXACT = Lobes(0, 2 * np.pi)
ROUNDING = 1e-15


def strays(arcs: Arcs) -> float:
    """How far arcs and curve are apart at most, as seen from either."""
    places = EXACT.at(np.linspace(0, 1, 2000))
    return max(float(EXACT.off(sampled(arcs)).max()), float(between(places, arcs).max()))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("pieces", [5, 12])
def test_arcs_stay_within_the_tolerance_as_they_say(tolerance: float, pieces: int) -> None:
    found = fit_arcs(lobes(pieces), tolerance)
    assert strays(found.arcs) <= found.deviation * (1 + 1e-3) + ROUNDING
    assert 0.2 * tolerance < found.deviation <= tolerance
    assert found.arcs.area == pytest.approx(EXACT.area, rel=tolerance / 0.02)


def test_arcs_turn_as_the_curve_does() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE).arcs
    middles = sampled(arcs, 3)[1::3]
    share = np.arctan2(middles[:, 1], middles[:, 0]) / (2 * np.pi) % 1
    curvature = EXACT.curvature(share)
    clear = np.abs(curvature) > 3
    assert (curvature[clear] < 0).any()
    np.testing.assert_array_equal(np.sign(arcs.bulges[clear]), np.sign(curvature[clear]))


def test_directions_are_those_of_the_curve_where_pieces_meet() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE).arcs
    heading = np.arctan2(*arcs.chords.T[::-1])
    ending, starting = heading + arcs.half_angles, np.roll(heading - arcs.half_angles, -1)
    np.testing.assert_allclose(np.exp(1j * (starting - ending)), 1, atol=1e-12)


def test_twice_the_arcs_are_eight_times_as_near() -> None:
    counts = [len(fit_arcs(lobes(3), tolerance).arcs.vertices) for tolerance in (1e-5, 1e-5 / 512)]
    assert 6 < counts[1] / counts[0] < 10


def test_circles_and_lines_are_single_arcs() -> None:
    found = fit_arcs([Lobes(0, 1.2, depth=0), Lobes(1.2, 2.4, depth=0)], TOLERANCE, closed=False)
    assert len(found.arcs.vertices) == 3
    assert found.arcs.lengths.sum() == pytest.approx(2.4 * 0.03, rel=1e-14)


def test_curve_of_points_is_followed() -> None:
    found = fit_arcs([ClosedCurve("pitch", EXACT.at)], TOLERANCE)
    assert strays(found.arcs) <= TOLERANCE


def test_wrong_side_and_moved_vertex_are_detected() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE).arcs
    hollow, convex = int(arcs.bulges.argmin()), int(arcs.bulges.argmax())
    for index in (hollow, convex):
        bulges = arcs.bulges.copy()
        bulges[index] *= -1
        assert strays(replace(arcs, bulges=bulges)) > 2 * TOLERANCE
    vertices = arcs.vertices.copy()
    vertices[7] *= 1 + 5e-6 / np.hypot(*vertices[7])
    assert strays(replace(arcs, vertices=vertices)) > 2 * TOLERANCE


def test_a_piece_with_a_corner_is_refused_by_name() -> None:
    class Corner(Lobes):
        def tangent(self, s):  # type: ignore[no-untyped-def]
            return np.where(s[:, None] < 0.4, [[1.0, 0.0]], [[0.0, 1.0]])

    with pytest.raises(ComputationError, match=r"piece 1, root, turns too sharply"):
        fit_arcs([Lobes(0, 1), Corner(1, 2, kind="root")], TOLERANCE)
