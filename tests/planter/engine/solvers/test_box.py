"""The variables that a search sees."""

import numpy as np
import pytest

from planter.engine.solvers.constraints import DesignBox

LOWER, UPPER = np.array([-1.0, 0.3, 2.0]), np.array([2.0, 0.7, 5.0])
SHARES = DesignBox.shares(("a", "b", "c"), LOWER, UPPER, np.array([0.0, 0.9, 2.0]))
PLAIN = DesignBox.plain(("a", "b", "c"), LOWER, UPPER, np.array([0.0, 0.9, 2.0]))


def test_box_coordinates_run_from_0_to_1():
    assert (SHARES.bottom.tolist(), SHARES.top.tolist()) == ([0, 0, 0], [1, 1, 1])
    assert (PLAIN.bottom.tolist(), PLAIN.top.tolist()) == (LOWER.tolist(), UPPER.tolist())
    x = np.array([0.1, 0.5, 3.0])
    assert PLAIN.at(x).tobytes() == x.tobytes()
    assert SHARES.at((x - LOWER) / (UPPER - LOWER)) == pytest.approx(x, rel=1e-15)


@pytest.mark.parametrize("box", [SHARES, PLAIN])
def test_bounds_are_met_to_the_last_bit_and_never_passed(box):
    assert box.at(box.bottom).tobytes() == LOWER.tobytes()
    assert box.at(box.top).tobytes() == UPPER.tobytes()
    outside = box.top + np.array([1e-3, 0.0, -1e-3])
    assert (box.at(outside) <= UPPER).all()
    assert (box.inside(outside) == np.minimum(outside, box.top)).all()


@pytest.mark.parametrize("box", [SHARES, PLAIN])
def test_the_start_is_the_design_taken_into_the_box(box):
    assert box.at(box.start) == pytest.approx([0.0, 0.7, 2.0], abs=1e-15)


@pytest.mark.parametrize("box", [SHARES, PLAIN])
def test_snapping_moves_only_values_near_bounds(box):
    u = np.array([box.bottom[0] + 1e-6, (box.bottom + box.top)[1] / 2, box.top[2] - 1e-6])
    assert (box.snapped(u, 1e-5) == [box.bottom[0], u[1], box.top[2]]).all()
    assert (box.snapped(u, 1e-7) == u).all()
    low, high = box.slack(u)
    assert (low[0], high[2]) == pytest.approx((1e-6, 1e-6), rel=1e-6)
