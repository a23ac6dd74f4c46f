"""The speed at which a cam's roller lifts off: where the force that its spring leaves first vanishes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from planter.kernels import Array
from planter.numerics import extremes

SLOWEST = 1e-3
"""Share of a machine's own speed at which it is as good as at rest, while directions of sliding are still told."""
FASTEST = 64
"""Multiple of a machine's own speed up to which a lift-off is looked for."""
_ANGLES = 2 * np.pi * np.arange(720) / 720
Push = Callable[[Array, float], Array]
"""Contact force (n,) [N], positive where the cam pushes, at angles (n,) [rad] and a speed [rad/s]."""


@dataclass(frozen=True)
class LiftOff:
    """A speed [rad/s], and the angle [rad] at which the roller lifts off first."""

    speed: float
    angle: float


def lift_off(push: Push, speed: float) -> LiftOff | None:
    """The least speed at which the contact force vanishes somewhere in a turn; None up to many times the own speed.

    The speed is zero where nothing presses the roller on even at rest.
    """
    low, high = SLOWEST * speed, speed
    rest = _least(push, low)
    if rest.value <= 0:
        return LiftOff(0.0, rest.place % (2 * np.pi))
    while _least(push, high).value > 0:
        low, high = high, 2 * high
        if abs(high) > FASTEST * abs(speed):
            return None
    found = float(brentq(lambda at: _least(push, at).value, low, high, rtol=1e-12))
    return LiftOff(found, _least(push, found).place % (2 * np.pi))


def _least(push: Push, speed: float) -> extremes.Extreme:
    return extremes.least(lambda angles: push(angles, speed), _ANGLES, closed=True)
