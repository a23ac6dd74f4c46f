"""Angles that come round again."""

import numpy as np
import pytest

from planter.numerics.angles import TURN, turn_deg, wrapped


def test_wrapped_is_the_same_angle_near_zero() -> None:
    angles = np.linspace(-20, 20, 401)
    near = wrapped(angles)
    assert ((near >= -np.pi) & (near < np.pi)).all()
    assert np.exp(1j * near) == pytest.approx(np.exp(1j * angles), abs=1e-14)
    assert wrapped(np.array([np.pi, -np.pi, 3.0])).tolist() == [-np.pi, -np.pi, 3.0]


def test_wrapped_in_another_period() -> None:
    assert wrapped(np.array([0.9, 0.4, -0.6]), 1.0) == pytest.approx([-0.1, 0.4, 0.4], abs=1e-15)


@pytest.mark.parametrize(("angle", "shown"), [(TURN, 0.0), (-TURN, 0.0), (-np.pi / 2, 270.0), (TURN + 1, 180 / np.pi)])
def test_shown_within_one_turn(angle: float, shown: float) -> None:
    assert turn_deg(angle) == pytest.approx(shown, abs=1e-12)


def test_a_rounding_below_zero_is_zero_and_not_360() -> None:
    assert turn_deg(-1e-17) == 0.0
    assert (np.degrees(-1e-17) % 360) == 360.0
