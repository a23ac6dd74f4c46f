"""Exact pieces as arcs within a tolerance: biarcs, halved until none strays (Bolton, Computer-Aided Design 7, 1975).

A biarc is two arcs with a common tangent where they meet, from place and tangent to place and tangent. Of the many
there are, this is the one whose two outer tangents are of one length, each as far as it meets the tangent at the joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.errors import ComputationError
from planter.kernels import Array
from planter.workshop.arcs import Arcs
from planter.workshop.outline import Piece

Whole = NDArray[np.intp]
Mask = NDArray[np.bool_]

SAMPLES = 16
"""Steps along a biarc, at whose ends the deviation is measured."""
SEEN = 0.95
"""Share of the greatest deviation that is seen there at least, where the curvature changes evenly."""
_GRID = 4 * SAMPLES
"""Steps along a piece when it is called: it can be halved twice before it is called again."""
_MOST_CALLS = 4
_STEEP = 0.5
"""Least cosine between a piece and its arcs: from there on, what is measured across holds as seen from either."""
_WIDEST = np.pi / 4
"""Most that half an arc turns by [rad]."""
_ALIKE = 1e-3
"""Two arcs that are nearer than this share of the tolerance to being one are one."""


@dataclass(frozen=True)
class Fit:
    """Arcs along pieces, and how far the two are apart at most [m]."""

    arcs: Arcs
    deviation: float


@dataclass(frozen=True)
class _Biarcs:
    """m biarcs: starts and joints (m, 2) [m], half the angles that their arcs turn by (m, 2) [rad], deviations (m,)."""

    start: Array
    joint: Array
    half: Array
    deviation: Array


def fit(pieces: Sequence[Piece], tolerance: float, closed: bool = True) -> Fit:
    """Arcs within `tolerance` [m] of pieces that follow each other, on either side and as seen from either.

    Raises ComputationError, naming the piece, for one that no arcs follow.
    """
    keys, parts = [], []
    for key, part in _spans(pieces, SEEN * tolerance):
        keys.append(key)
        parts.append(part)
    order = np.lexsort(np.hstack(keys)[::-1])
    start, joint, half, deviation = (
        np.concatenate([getattr(part, name) for part in parts])[order]
        for name in ("start", "joint", "half", "deviation")
    )
    vertices = np.stack([start, joint], axis=1).reshape(-1, 2)
    kept = np.ones(len(vertices), dtype=bool)
    one = _sagitta_apart(start, joint, half) < _ALIKE * tolerance
    kept[1::2] = ~one
    halves = np.where(one[:, None], half.sum(axis=1, keepdims=True), half).ravel()
    vertices, bulges = vertices[kept], np.tan(halves[kept] / 2)
    if not closed:
        vertices, bulges = np.vstack([vertices, pieces[-1].at(np.ones(1))]), np.append(bulges, 0.0)
    return Fit(Arcs(vertices, bulges, closed), float(deviation.max()) / SEEN)


def _spans(pieces: Sequence[Piece], limit: float) -> Iterator[tuple[Array, _Biarcs]]:
    """Biarcs that stray by at most `limit` where it is measured, and their keys (2, m): piece, and parameter there."""
    number, low, width = np.arange(len(pieces)), np.zeros(len(pieces)), 1.0
    for _ in range(_MOST_CALLS):
        places, tangents = _called(pieces, number, low, width)
        row, first = np.arange(len(number)), np.zeros(len(number), dtype=int)
        for steps in (4, 2, 1):
            index = row[:, None], first[:, None] + steps * np.arange(SAMPLES + 1)
            found = _biarcs(places[index], tangents[index])
            good = found.deviation <= limit
            yield np.array([number[row], low[row] + width * first / _GRID])[:, good], _chosen(found, good)
            row, first = np.repeat(row[~good], 2), np.repeat(first[~good], 2)
            first[1::2] += steps * SAMPLES // 2
        if not len(row):
            return
        number, low, width = number[row], low[row] + width * first / _GRID, width / (2 * _GRID // SAMPLES)
    lost = pieces[int(number[0])]
    raise ComputationError(f"piece {number[0]}, {lost.kind}, turns too sharply for arcs within {limit * 1e6:g} um")


def _called(pieces: Sequence[Piece], number: Whole, low: Array, width: float) -> tuple[Array, Array]:
    """Places and unit tangents (m, _GRID + 1, 2) along m spans of pieces."""
    share = np.linspace(0.0, 1.0, _GRID + 1)
    spans = [(pieces[i], start + width * share) for i, start in zip(number.tolist(), low.tolist(), strict=True)]
    return np.array([piece.at(s) for piece, s in spans]), np.array([piece.tangent(s) for piece, s in spans])


def _chosen(found: _Biarcs, which: Mask) -> _Biarcs:
    return _Biarcs(found.start[which], found.joint[which], found.half[which], found.deviation[which])


@np.errstate(divide="ignore", invalid="ignore")
def _biarcs(places: Array, tangents: Array) -> _Biarcs:
    """Biarcs of m spans (m, k, 2) from their ends, and how far the places between are off; infinite for no biarc."""
    start, end, first, last = places[:, 0], places[:, -1], tangents[:, 0], tangents[:, -1]
    chord, both = end - start, first + last
    square, forward = _dot(chord, chord), _dot(chord, both)
    reach = square / (forward + np.sqrt(forward**2 + 2 * (1 - _dot(first, last)) * square))
    joint = (start + end + reach[:, None] * (first - last)) / 2
    half = np.column_stack([_angle(first, joint - start), _angle(end - joint, last)])
    across = joint - start - reach[:, None] * first
    across /= np.sqrt(_dot(across, across))[:, None]
    arcs = [(start, first, half[:, 0], joint - start), (joint, across, half[:, 1], end - joint)]
    beyond = _dot(places - joint[:, None], across[:, None]) > 0
    (one, one_along), (two, two_along) = (_offsets(places, tangents, *arc) for arc in arcs)
    off, cosine = np.where(beyond, two, one), np.where(beyond, two_along, one_along)
    sound = (forward > 0) & (cosine.min(axis=1) > _STEEP) & (np.abs(half).max(axis=1) < _WIDEST)
    return _Biarcs(start, joint, half, np.where(sound, np.abs(off).max(axis=1), np.inf))


def _offsets(
    places: Array, tangents: Array, start: Array, tangent: Array, half: Array, chord: Array
) -> tuple[Array, Array]:
    """Distance of places (m, k, 2) from the circles of m arcs, positive to the left; cosines of their directions."""
    curvature = (2 * np.sin(half) / np.sqrt(_dot(chord, chord)))[:, None]
    normal, from_start = np.column_stack([-tangent[:, 1], tangent[:, 0]])[:, None], places - start[:, None]
    left, square = _dot(from_start, normal), _dot(from_start, from_start)
    root = np.sqrt(np.maximum(1 - 2 * curvature * left + curvature**2 * square, 0.0))
    inward = normal - curvature[..., None] * from_start
    along = np.stack([inward[..., 1], -inward[..., 0]], axis=-1)
    return (2 * left - curvature * square) / (1 + root), _dot(along, tangents) / root


def _sagitta_apart(start: Array, joint: Array, half: Array) -> Array:
    """How far two arcs of a biarc would be from one: their curvatures apart, over the first's length."""
    length = np.sqrt(_dot(joint - start, joint - start))
    return np.abs(half[:, 1] - half[:, 0]) * length / 4


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i", a, b)


def _angle(a: Array, b: Array) -> Array:
    """Angles (m,) from vectors to others, in (-pi, pi]."""
    return np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], _dot(a, b))
