"""Angles that come round again."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from planter.kernels import Array

TURN = 2 * np.pi
Angle = TypeVar("Angle", float, Array)


def wrapped(angle: Angle, period: float = TURN) -> Angle:
    """The same angle, or difference of angles, in [-period/2, period/2) [rad]."""
    near: Angle = np.mod(angle + period / 2, period) - period / 2
    return near


def turn_deg(angle: float) -> float:
    """An angle [rad] as it is shown, in [0, 360)."""
    found = float(np.degrees(angle % TURN))
    return found if found < 360 else 0.0
