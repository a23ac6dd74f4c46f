"""Pick-ups for tests: the built-in one, and tips of laws by complex numbers, apart from the
package's own formulas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.law import CosineLaw, Dwell
from planter.papers.pickup.model import PickupTrain, build_train

L1, L2, FAR = 0.0933377, 0.163, np.radians(40)
P, START, END = 0.3549389251, np.radians(210), np.radians(270)


def built_in(name: str = "yu2023", **changes: float) -> PickupTrain:
    return build_train(load_pickup(name, changes))


def arm(t: NDArray, p: float = P, start: float = START, end: float = END) -> NDArray:
    """phi1 by hand: c (t + p sin t) over the teeth, nothing in the dwell, one turn in a turn."""
    turns, angle = np.divmod(t, 2 * np.pi)
    plain = angle + p * np.sin(angle)
    s, e = start + p * np.sin(start), end + p * np.sin(end)
    gained = np.where(angle < start, plain, np.where(angle <= end, s, plain - e + s))
    return np.pi + 2 * np.pi * gained / (2 * np.pi - e + s) + 2 * np.pi * turns


def tips(t: NDArray, phi1: NDArray, far: float = FAR) -> NDArray:
    """Places (n, 2) of the tip from both angles."""
    place = L1 * np.exp(1j * (far + t)) + L2 * np.exp(1j * (far + t + np.pi - phi1))
    return np.column_stack([place.real, place.imag])


def law(p: float = P, start: float = START, end: float = END) -> CosineLaw:
    return CosineLaw(p, Dwell(start, end))


def steps(count: int, offset: float = 0.0) -> NDArray:
    return (np.arange(count) + offset) * 2 * np.pi / count
