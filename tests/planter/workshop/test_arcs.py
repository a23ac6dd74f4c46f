"""Curves of arcs: circles, and bodies between a chord and an arc, by closed forms."""

import numpy as np
import pytest

from planter.workshop.arcs import Arcs, build_circle

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_circle_has_exact_area_length_and_points() -> None:
    found = build_circle(0.7, (0.2, -0.3)).moved(1.1)
    assert found.area == pytest.approx(np.pi * 0.7**2, rel=1e-14)
    assert found.lengths.sum() == pytest.approx(2 * np.pi * 0.7, rel=1e-14)
    centre = np.array([[0.2, -0.3]]) @ [[np.cos(1.1), np.sin(1.1)], [-np.sin(1.1), np.cos(1.1)]]
    places = found.points(1e-5)
    np.testing.assert_allclose(np.hypot(*(places - centre).T), 0.7, rtol=1e-14)
    chords = np.hypot(*(np.roll(places, -1, axis=0) - places).T)
    assert (0.7 - np.sqrt(0.7**2 - (chords / 2) ** 2)).max() <= 1e-5


@pytest.mark.parametrize("turn", [1e-7, 1e-4, 3e-3, 0.5, 3.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_side_bulges_outwards_right_and_inwards_left(turn: float, sign: int) -> None:
    bulges = np.array([sign * np.tan(turn / 4), 0, 0, 0])
    radius = 1 / (2 * np.sin(turn / 2))
    segment = radius**2 * (turn - np.sin(turn)) / 2 if turn > 1e-3 else turn / 12 * (1 + turn**2 / 30)
    assert Arcs(SQUARE, bulges).area == pytest.approx(1 + sign * segment, rel=1e-14)
    assert np.sign(Arcs(SQUARE, bulges).points(1e-3 * turn)[1, 1]) == -sign


def test_the_other_way_round_has_the_opposite_area() -> None:
    assert Arcs(SQUARE[::-1], np.zeros(4)).area == -1


def test_open_curve_ends_at_the_last_vertex() -> None:
    found = Arcs(SQUARE, np.array([1.0, 0, 0, 0]), closed=False)
    assert found.lengths == pytest.approx([np.pi / 2, 1, 1])
    np.testing.assert_array_equal(found.points(1e-3)[[0, -1]], SQUARE[[0, -1]])
