"""Angles of a cycle."""

import numpy as np
import pytest

from planter.numerics.arrays import TURN, to_degrees, wrap_angle


def test_wrap_angle_returns_angle_near_zero() -> None:
    angles = np.linspace(-20, 20, 401)
    wrapped = wrap_angle(angles)
    assert ((wrapped >= -np.pi) & (wrapped < np.pi)).all()
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angles), abs=1e-14)
    assert wrap_angle(np.array([np.pi, -np.pi, 3.0])).tolist() == [-np.pi, -np.pi, 3.0]


def test_wrap_angle_with_other_period() -> None:
    assert wrap_angle(np.array([0.9, 0.4, -0.6]), 1.0) == pytest.approx([-0.1, 0.4, 0.4], abs=1e-15)


@pytest.mark.parametrize(
    ("angle", "degrees"), [(TURN, 0.0), (-TURN, 0.0), (-np.pi / 2, 270.0), (TURN + 1, 180 / np.pi)]
)
def test_to_degrees_stays_within_a_revolution(angle: float, degrees: float) -> None:
    assert to_degrees(angle) == pytest.approx(degrees, abs=1e-12)


def test_to_degrees_of_rounding_below_zero_is_zero() -> None:
    assert to_degrees(-1e-17) == 0.0
    assert (np.degrees(-1e-17) % 360) == 360.0
