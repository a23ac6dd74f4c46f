"""Names stand beside a drawing without covering each other; marks measure what they stand for."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planter.report.sheet import Angle, Length, arrange_column, find_crossing, place_labels

UNIT = st.floats(0, 1)


@settings(
    max_examples=60, derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
@given(st.lists(st.tuples(UNIT, UNIT), min_size=1, max_size=12, unique=True))
def test_names_keep_apart_and_their_lines_do_not_cross(points: list[tuple[float, float]]) -> None:
    anchors = np.array(points)
    labels = place_labels(anchors, 0.05, 1.0)
    for right in (False, True):
        side_labels = [index for index, place in enumerate(labels) if place.right == right]
        heights = [labels[index].height for index in side_labels]
        assert all(abs(a - b) >= 0.05 - 1e-9 for a, b in combinations(heights, 2))
        assert all(0 <= height <= 1 for height in heights)
        assert find_crossing(anchors[side_labels], heights, 1.0 if right else 0.0) is None


def test_a_crossing_is_noticed_and_taken_away() -> None:
    anchors = np.array([[0.5, 0.2], [0.5, 0.8]])
    assert find_crossing(anchors, [0.8, 0.2], 0.0) == (0, 1)
    assert find_crossing(anchors, arrange_column(anchors, 0.1, 0.0), 0.0) is None


def test_marks_measure_themselves() -> None:
    origin = np.zeros(2)
    assert Length(("a",), origin, np.array([3.0, 4.0])).size == 5
    turned = Angle.between(("b",), origin, np.array([0.0, 2.0]), np.array([-1.0, 0.0]), 1.0)
    assert (turned.start, turned.turn) == pytest.approx((90, 90))
    assert np.hypot(*turned.outline().T) == pytest.approx(1.0)
    assert turned.anchor == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)])
