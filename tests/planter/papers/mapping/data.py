"""Poses, dyads and linkages of the tests."""

import numpy as np

from planter.papers.mapping.dyads import Dyad
from planter.papers.mapping.linkage import FourBar

CORRECTED = [(235, 120, -10), (252, 112, 0), (237, 121, 12), (80, -270, -85), (58, -258, -75)]
"""Poses [mm, deg] of CN107654585B, the first angle as its mapping parameters have it: the print
omits the sign.
"""


def si(rows: list[tuple[float, float, float]]) -> np.ndarray:
    poses = np.array(rows, dtype=float)
    poses[:, :2] /= 1000
    poses[:, 2] = np.radians(poses[:, 2])
    return poses


def random_poses(seed: int, count: int = 5) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-0.3, 0.3, (count, 2)), rng.uniform(-2, 2, count)])


def inverse(poses: np.ndarray) -> np.ndarray:
    """The poses of the fixed frame as the body sees them, by complex numbers."""
    place, turn = poses[:, 0] + 1j * poses[:, 1], np.exp(1j * poses[:, 2])
    seen = -place / turn
    return np.column_stack([seen.real, seen.imag, -poses[:, 2]])


def bar(frame: float, crank: float, coupler: float, follower: float) -> FourBar:
    """A linkage of given lengths [m], its tip off the coupler."""
    first = np.array([-0.1, 0.05])
    second = first + coupler * np.array([np.cos(0.4), np.sin(0.4)])
    centre = np.array([0.02, -0.03])
    other = centre + frame * np.array([np.cos(-0.7), np.sin(-0.7)])
    return FourBar(Dyad(first, centre, crank), Dyad(second, other, follower))
