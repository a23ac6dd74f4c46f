"""Curves of arcs: circles and segments by closed forms, fitted arcs, and points along an
outline.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.gears.geometry.pieces import Piece
from planter.gears.workshop.arcs import Arcs, build_circle, fit_arcs, tabulate_outline
from planter.kernels import Array
from tests.support.outlines import Lobes, between, lobes, sampled

TOLERANCE = 1e-6
EXACT = Lobes(0, 2 * np.pi)
ROUNDING = 1e-15


def strays(arcs: Arcs) -> float:
    """Return the largest distance of arcs and curve, from either."""
    places = EXACT.piece.at(np.linspace(0, 1, 2000))
    return max(float(EXACT.off(sampled(arcs)).max()), float(between(places, arcs).max()))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
@pytest.mark.parametrize("pieces", [5, 12])
def test_arcs_stay_within_the_stated_deviation(tolerance: float, pieces: int) -> None:
    arcs = fit_arcs(lobes(pieces), tolerance)
    assert strays(arcs) <= arcs.deviation * (1 + 1e-3) + ROUNDING
    assert 0.2 * tolerance < arcs.deviation <= tolerance
    assert arcs.area == pytest.approx(EXACT.area, rel=tolerance / 0.02)


def test_arcs_have_the_signs_of_curvature() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE)
    middles = sampled(arcs, 3)[1::3]
    share = np.arctan2(middles[:, 1], middles[:, 0]) / (2 * np.pi) % 1
    curvature = EXACT.piece.curvature(share)
    clear = np.abs(curvature) > 3
    assert (curvature[clear] < 0).any()
    np.testing.assert_array_equal(np.sign(arcs.bulges[clear]), np.sign(curvature[clear]))


def test_arcs_are_tangent_at_vertices() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE)
    heading = np.arctan2(*arcs.chords.T[::-1])
    ending, starting = heading + arcs.half_angles, np.roll(heading - arcs.half_angles, -1)
    np.testing.assert_allclose(np.exp(1j * (starting - ending)), 1, atol=1e-12)


def test_circles_and_lines_are_single_arcs() -> None:
    pieces = [Lobes(start, start + 1.2, depth=0).piece for start in (0, 1.2)]
    arcs = fit_arcs(pieces, TOLERANCE, closed=False)
    assert len(arcs.vertices) == 3
    assert arcs.lengths.sum() == pytest.approx(2.4 * 0.03, rel=1e-14)


def test_wrong_side_and_moved_vertex_are_detected() -> None:
    arcs = fit_arcs(lobes(), TOLERANCE)
    hollow, convex = int(arcs.bulges.argmin()), int(arcs.bulges.argmax())
    for index in (hollow, convex):
        bulges = arcs.bulges.copy()
        bulges[index] *= -1
        assert strays(replace(arcs, bulges=bulges)) > 2 * TOLERANCE
    vertices = arcs.vertices.copy()
    vertices[7] *= 1 + 5e-6 / np.hypot(*vertices[7])
    assert strays(replace(arcs, vertices=vertices)) > 2 * TOLERANCE


def test_piece_with_corner_is_refused_by_name() -> None:
    def evaluate(s: Array) -> Array:
        rows = Lobes(1, 2).rows(s)
        rows[2:4] = np.where(s < 0.4, [[1.0], [0.0]], [[0.0], [1.0]])
        return rows

    with pytest.raises(ComputationError, match=r"piece 1, root, turns too sharply"):
        fit_arcs([Lobes(0, 1).piece, Piece("root", evaluate)], TOLERANCE)


SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_circle_has_exact_area_length_and_points() -> None:
    arcs = build_circle(0.7, (0.2, -0.3)).moved(1.1)
    assert arcs.area == pytest.approx(np.pi * 0.7**2, rel=1e-14)
    assert arcs.lengths.sum() == pytest.approx(2 * np.pi * 0.7, rel=1e-14)
    centre = np.array([[0.2, -0.3]]) @ [[np.cos(1.1), np.sin(1.1)], [-np.sin(1.1), np.cos(1.1)]]
    places = arcs.points(1e-5)
    np.testing.assert_allclose(np.hypot(*(places - centre).T), 0.7, rtol=1e-14)
    chords = np.hypot(*(np.roll(places, -1, axis=0) - places).T)
    assert (0.7 - np.sqrt(0.7**2 - (chords / 2) ** 2)).max() <= 1e-5


@pytest.mark.parametrize("turn", [1e-7, 1e-4, 3e-3, 0.5, 3.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_side_bulges_outwards_right_and_inwards_left(turn: float, sign: int) -> None:
    bulges = np.array([sign * np.tan(turn / 4), 0, 0, 0])
    radius = 1 / (2 * np.sin(turn / 2))
    segment = (
        radius**2 * (turn - np.sin(turn)) / 2 if turn > 1e-3 else turn / 12 * (1 + turn**2 / 30)
    )
    assert Arcs(SQUARE, bulges).area == pytest.approx(1 + sign * segment, rel=1e-14)
    assert np.sign(Arcs(SQUARE, bulges).points(1e-3 * turn)[1, 1]) == -sign


def test_open_curve_ends_at_the_last_vertex() -> None:
    arcs = Arcs(SQUARE, np.array([1.0, 0, 0, 0]), closed=False)
    assert arcs.lengths == pytest.approx([np.pi / 2, 1, 1])
    np.testing.assert_array_equal(arcs.points(1e-3)[[0, -1]], SQUARE[[0, -1]])


def test_table_of_an_outline_agrees_with_its_pieces() -> None:
    columns = tabulate_outline(lobes(5), 64)
    ends = np.cumsum([Lobes(*angles).length for angles in pairwise(np.linspace(0, 2 * np.pi, 6))])
    np.testing.assert_allclose(columns["arc_length_mm"][64::65], 1e3 * ends, rtol=1e-8)
    places = np.column_stack([columns["x_mm"], columns["y_mm"]]) / 1e3
    normals = np.column_stack([columns["normal_x"], columns["normal_y"]])
    tangents, across = np.diff(places[130:195], axis=0), normals[130:194] + normals[131:195]
    assert np.abs((tangents * across).sum(axis=1)).max() < 1e-3 * np.hypot(*tangents.T).max()
    outwards = places + 1e-6 * normals
    assert (EXACT.off(outwards) > 5e-7).all()
    radius = np.hypot(*outwards.T)
    assert (radius > EXACT.polar(np.arctan2(outwards[:, 1], outwards[:, 0]))[0]).all()
