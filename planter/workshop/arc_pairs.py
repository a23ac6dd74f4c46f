"""Biarcs: two arcs with a common tangent where they meet, from place and tangent to place and tangent.

There is one for each ratio of the two outer tangents, as far as they meet the tangent at the joint (Bolton, Biarc
curves, Computer-Aided Design 7, 1975). Here the ratio is the one that keeps the area beside the curve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array

STEEP = 0.5
"""Least cosine between a curve and its arcs: from there on, what is measured across holds as seen from either."""
WIDEST = np.pi / 4
"""Most that half an arc turns by [rad]."""
_ASIDE = 1.1
"""A second ratio, from which and the first, 1, secants lead to that of no area."""
_SECANTS = 2
_MOST = 3.0
"""Largest ratio that is tried, and the inverse of the least."""


@dataclass(frozen=True)
class Pairs:
    """m biarcs: starts, joints and ends (m, 2) [m], half the angles that their arcs turn by (m, 2) [rad].

    `deviation` (m,) is how far the curves are off at most [m], infinite where a biarc does not follow its curve;
    `area` (m,) lies between the two, positive where the curve is to the left [m2].
    """

    start: Array
    joint: Array
    end: Array
    half: Array
    deviation: Array
    area: Array

    def of(self, which: NDArray[np.bool_]) -> Pairs:
        """Some of them."""
        return Pairs(*(rows[which] for rows in vars(self).values()))

    @property
    def apart(self) -> Array:
        """How far the two arcs are from being one (m,) [m]: their curvatures apart, over the first and the second."""
        squares = np.column_stack([dot(arc, arc) for arc in (self.joint - self.start, self.end - self.joint)])
        curvature = 2 * np.sin(self.half) / np.sqrt(squares)
        return np.abs(curvature[:, 1] - curvature[:, 0]) * squares.max(axis=1) / 8


@np.errstate(divide="ignore", invalid="ignore")
def along(places: Array, tangents: Array) -> Pairs:
    """Biarcs from end to end of m spans of curves, by places and unit tangents (m, k, 2) along each."""
    last, ratio = np.ones(len(places)), np.full(len(places), _ASIDE)
    even = before = _pairs(places, tangents, last)
    found = _pairs(places, tangents, ratio)
    for _ in range(_SECANTS):
        aim = ratio - found.area * (ratio - last) / (found.area - before.area)
        last, before = ratio, found
        ratio = np.clip(np.where(np.isfinite(aim), aim, 1.0), 1 / _MOST, _MOST)
        found = _pairs(places, tangents, ratio)
    better = found.deviation <= even.deviation
    return Pairs(*(np.where(better.reshape(-1, *[1] * (old.ndim - 1)), new, old)
                   for old, new in zip(vars(even).values(), vars(found).values(), strict=True)))  # fmt: skip


def _pairs(places: Array, tangents: Array, ratio: Array) -> Pairs:
    """Biarcs whose second outer tangent is `ratio` (m,) times as long as the first."""
    start, end, first, last = places[:, 0], places[:, -1], tangents[:, 0], tangents[:, -1]
    chord = end - start
    square, forward = dot(chord, chord), dot(chord, first + ratio[:, None] * last)
    reach = square / (forward + np.sqrt(forward**2 + 2 * ratio * (1 - dot(first, last)) * square))
    near, far = start + reach[:, None] * first, end - (ratio * reach)[:, None] * last
    joint = (ratio[:, None] * near + far) / (1 + ratio)[:, None]
    half = np.column_stack([_angle(first, joint - start), _angle(end - joint, last)])
    across = (joint - near) / np.sqrt(dot(joint - near, joint - near))[:, None]
    arcs = ((start, first, half[:, 0], joint - start), (joint, across, half[:, 1], end - joint))
    (one, one_along), (two, two_along) = (_offsets(places, tangents, *arc) for arc in arcs)
    beyond = dot(places - joint[:, None], across[:, None]) > 0
    off, cosine = np.where(beyond, two, one), np.where(beyond, two_along, one_along)
    sound = (forward > 0) & (cosine.min(axis=1) > STEEP) & (np.abs(half).max(axis=1) < WIDEST)
    steps = np.sqrt(dot(np.diff(places, axis=1), np.diff(places, axis=1)))
    area = ((off[:, 1:] + off[:, :-1]) / 2 * steps).sum(axis=1)
    return Pairs(start, joint, end, half, np.where(sound, np.abs(off).max(axis=1), np.inf), area)


def _offsets(
    places: Array, tangents: Array, start: Array, tangent: Array, half: Array, chord: Array
) -> tuple[Array, Array]:
    """Distance of places (m, k, 2) from the circles of m arcs, positive to the left; cosines of their directions."""
    curvature = (2 * np.sin(half) / np.sqrt(dot(chord, chord)))[:, None]
    normal, from_start = np.column_stack([-tangent[:, 1], tangent[:, 0]])[:, None], places - start[:, None]
    left, square = dot(from_start, normal), dot(from_start, from_start)
    root = np.sqrt(np.maximum(1 - 2 * curvature * left + curvature**2 * square, 0.0))
    inward = normal - curvature[..., None] * from_start
    onwards = np.stack([inward[..., 1], -inward[..., 0]], axis=-1)
    return (2 * left - curvature * square) / (1 + root), dot(onwards, tangents) / root


def dot(a: Array, b: Array) -> Array:
    """Products (...) of vectors (..., 2)."""
    return np.einsum("...i,...i", a, b)


def _angle(a: Array, b: Array) -> Array:
    """Angles (m,) from vectors to others, in (-pi, pi]."""
    return np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dot(a, b))
