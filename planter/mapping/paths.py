"""The angle curve of the patent: points of both closed paths and free points between (sun2019, step 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mapping.curve import AngleCurve, closed_turn, unwrap_rotations
from planter.mapping.linkage import FourBar
from planter.numerics.arrays import TURN


@dataclass(frozen=True)
class Choice:
    """Carrier angles [rad] of the points: on the path of either assembly, and free ones in between.

    The ordinates of the second path are shifted by `second_shift`. Free ordinates that are not given lie on the
    periodic monotone cubic (Fritsch and Carlson) through the points of the paths.
    """

    first_assembly: int
    first: Array
    second_assembly: int
    second: Array
    second_shift: float
    free: Array
    free_relative: Array | None = None


def build_path_curve(linkage: FourBar, choice: Choice) -> AngleCurve:
    """The curve through the chosen points. Raises ComputationError where a path has no such point."""
    parts = [(choice.first, choice.first_assembly, 0.0), (choice.second, choice.second_assembly, choice.second_shift)]
    theta = np.concatenate([angles for angles, _, _ in parts])
    relative = np.concatenate([_on_path(linkage, a, assembly) + shift for a, assembly, shift in parts])
    order = np.argsort(theta)
    theta, relative = theta[order], unwrap_rotations(relative[order])
    if relative[-1] <= relative[0] - TURN:
        raise ComputationError(
            "the points of the two paths do not lie on one closed turn of the carrier: the arm would have to turn "
            f"against the carrier by {np.degrees(relative[0] - relative[-1]):.6g} deg, which must be less than 360"
        )
    free = choice.free_relative if choice.free_relative is not None else _between(theta, relative, choice.free)
    return closed_turn(np.concatenate([theta, choice.free]), np.concatenate([relative, free]))


def _on_path(linkage: FourBar, theta: Array, assembly: int) -> Array:
    """Relative rotation [rad], up to whole turns, of the points of a path at carrier angles (n,)."""
    for angle in theta:
        if not _within_reach(linkage, float(angle)):
            raise ComputationError(f"the path of assembly {assembly:+d} has no point at {np.degrees(angle):.6g} deg")
    phi = linkage.arm_angle(theta, np.full(len(theta), assembly))
    relative: Array = phi - theta
    return _unwrap_near(relative, 0.0)


def _unwrap_near(relative: Array, start: float) -> Array:
    """The rotations with whole turns added so that the first lies within half a turn of `start`."""
    return relative - TURN * np.round((relative[0] - start) / TURN) if len(relative) else relative


def _within_reach(linkage: FourBar, theta: float) -> bool:
    return any(reach.is_full_turn or np.mod(theta - reach.start, TURN) <= reach.span for reach in linkage.reaches)


def _between(theta: Array, relative: Array, free: Array) -> Array:
    from scipy.interpolate import PchipInterpolator

    turns = np.array([-1, 0, 1])[:, None] * TURN
    return PchipInterpolator((theta + turns).ravel(), (relative - turns).ravel())(free)


def duplicates(angles: Sequence[float]) -> list[float]:
    """Carrier angles [rad] that are given more than once, up to whole turns."""
    ordered = np.sort(np.mod(angles, TURN))
    return [float(a) for a, b in zip(ordered, np.roll(ordered, -1), strict=True) if abs(a - b) < 1e-9]
