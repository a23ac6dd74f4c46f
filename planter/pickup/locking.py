"""Locking arcs of a pick-up: what holds its intermediate gear while the arm dwells, drawn and cut alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.incomplete.arcs import ARCS, radius_of, reaches_of
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.kernels import Array
from planter.pickup.model import Train


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


def locking(train: Train) -> Locking | None:
    """The locking arcs of a train that dwells, between the teeth on both sides of the dwell.

    Where no teeth lead to the dwell they are as large as the larger of the sun's pitch radii where the teeth end, and
    the intermediate gear's tips beside them are taken for circles. Raises GeometryError where no arcs would hold.
    """
    dwell = train.law.dwell
    if dwell is None:
        return None
    addendum = float(train.teeth[2] * train.teeth[0])
    if train.toothed == train.driven:
        curves = rolling(train)
        radius = radius_of(curves, addendum)
        after, before = reaches_of(curves, radius, addendum)
        return Locking(radius, curves.ends[::-1], dwell.width, (before, after))
    first, last = train.pitch(np.array(train.toothed[::-1]))["R1"].tolist()
    reaches = [_on_circle(train.geometry.a1, max(first, last), end, addendum) for end in (first, last)]
    return Locking(max(first, last), (first, last), dwell.width, (reaches[0], reaches[1]))


def _on_circle(distance: float, radius: float, end: float, addendum: float) -> float:
    return ARCS.at("horn", distance=distance, radius=radius, tips=distance - end + addendum)["reach"]


def rolling(train: Train) -> Rolling:
    """The sun's pitch curve and the intermediate gear's where they roll on each other."""

    def radius(t: Array) -> Array:
        return train.pitch(t)["R1"]

    return Rolling.of(radius, train.toothed, train.law.joints(), train.geometry.a1)
