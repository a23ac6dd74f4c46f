"""Locking arcs of a pick-up: what holds its intermediate gear while the arm dwells, drawn and cut alike."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.errors import GeometryError
from planter.gear_geometry.locking_arcs import ARCS, Rolling, compute_arc_radius, compute_horn_reaches
from planter.kernels import Array
from planter.pickup.model import PickupTrain

_STEP = 1e-6
"""Half the carrier angle over which the direction of a pitch curve is taken [rad]."""


@dataclass(frozen=True)
class Locking:
    """Locking arcs: radius [m], pitch radii of the sun where the dwell begins and where it ends [m], sweep [rad].

    While they act both arcs lie about the sun's centre. The concave one on the intermediate gear reaches `reaches`
    [rad, at the sun's centre] to both sides of the centre line, to that gear's tips: first on the side of the teeth
    that were in mesh before the dwell.
    """

    radius: float
    ends: tuple[float, float]
    sweep: float
    reaches: tuple[float, float]


def compute_locking_arcs(train: PickupTrain) -> Locking | None:
    """The locking arcs of a train that dwells, between the teeth next to the dwell, or None if none would hold.

    Where no teeth lead to the dwell they are as large as the larger of the sun's pitch radii where the teeth end, and
    the intermediate gear's tips beside them are taken for circles.
    """
    dwell = train.law.dwell
    if dwell is None:
        return None
    addendum = float(train.teeth[2] * train.teeth[0])
    if train.toothed == train.driven:
        curves = _Curves(train)
        try:
            radius = compute_arc_radius(curves, addendum)
            after, before = compute_horn_reaches(curves, radius, addendum)
        except GeometryError:
            return None
        return Locking(radius, curves.ends[::-1], dwell.width, (before, after))
    first, last = train.pitch(np.array(train.toothed[::-1]))["R1"].tolist()
    reaches = [_on_circle(train.geometry.a1, max(first, last), end, addendum) for end in (first, last)]
    return Locking(max(first, last), (first, last), dwell.width, (reaches[0], reaches[1]))


def _on_circle(distance: float, radius: float, end: float, addendum: float) -> float:
    return ARCS.at("horn", distance=distance, radius=radius, tips=distance - end + addendum)["reach"]


@dataclass(frozen=True)
class _Curves:
    """Both gears' pitch curves next to the dwell (`arcs.Rolled`), by carrier angles, without arc lengths."""

    train: PickupTrain

    @property
    def distance(self) -> float:
        return self.train.geometry.a1

    @cached_property
    def ends(self) -> tuple[float, float]:
        first, last = self.train.pitch(np.array(self.train.toothed))["R1"].tolist()
        return first, last

    @property
    def length(self) -> float:
        return self.train.arc

    @cached_property
    def driving_axis(self) -> Array:
        x, y = self._at(np.array(self.train.toothed[1:]))[:, 0]
        return np.asarray(self.distance * np.array([x, y]) / np.hypot(x, y))

    def place_near_end(self, end: int, at: float) -> Array:
        """Return the contact where the sun's pitch circle would have rolled over an arc length `at` [m]."""
        first, last = self.train.toothed
        t = (last - at / self.ends[1]) if end else (first + at / self.ends[0])
        before, (x, y), after = self._at(np.clip(t, first + _STEP, last - _STEP) + _STEP * np.array([-1, 0, 1])).T
        tangent = after - before
        tx, ty = np.sign(x * tangent[1] - y * tangent[0]) * tangent / np.hypot(*tangent)
        return np.array([[x], [y], [tx], [ty], [0.0]])

    def _at(self, t: Array) -> Array:
        """Places of the intermediate gear's pitch curve (2, n) [m] at carrier angles."""
        curves = self.train.pitch(t)
        return np.array([curves["x2"], curves["y2"]])


def build_rolling(train: PickupTrain) -> Rolling:
    """The sun's pitch curve and the intermediate gear's where they roll on each other."""

    def radius(t: Array) -> Array:
        return train.pitch(t)["R1"]

    return Rolling.from_radius(radius, train.toothed, train.law.joints(), train.geometry.a1)
