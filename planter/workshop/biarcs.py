"""Exact pieces as arcs within a tolerance: biarcs, halved until none strays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.errors import ComputationError
from planter.kernels import Array
from planter.workshop.arc_pairs import Pairs, along
from planter.workshop.arcs import Arcs
from planter.workshop.outline import Piece

Whole = NDArray[np.intp]

SAMPLES = 16
"""Steps along a biarc, at whose ends the deviation is measured."""
SEEN = 0.95
"""Share of the greatest deviation that is seen there at least, where the curvature changes evenly."""
_GRID = 4 * SAMPLES
"""Steps along a piece when it is called: it can be halved twice before it is called again."""
_MOST_CALLS = 4
_ALIKE = 1e-3
"""Two arcs that are nearer than this share of the tolerance to being one are one."""


@dataclass(frozen=True)
class Fit:
    """Arcs along pieces, and how far the two are apart at most [m]."""

    arcs: Arcs
    deviation: float


def fit(pieces: Sequence[Piece], tolerance: float, closed: bool = True) -> Fit:
    """Arcs within `tolerance` [m] of pieces that follow each other, on either side and as seen from either.

    Raises ComputationError, naming the piece, for one that no arcs follow.
    """
    keys, parts = zip(*_spans(pieces, SEEN * tolerance), strict=True)
    order = np.lexsort(np.hstack(keys)[::-1])
    found = Pairs(*(np.concatenate(rows)[order] for rows in zip(*(vars(part).values() for part in parts), strict=True)))
    one = found.apart < _ALIKE * tolerance
    kept = np.ravel(np.column_stack([np.ones_like(one), ~one]))
    vertices = np.stack([found.start, found.joint], axis=1).reshape(-1, 2)
    halves = np.where(one[:, None], found.half.sum(axis=1, keepdims=True), found.half).ravel()
    vertices, bulges = vertices[kept], np.tan(halves[kept] / 2)
    if not closed:
        vertices, bulges = np.vstack([vertices, pieces[-1].at(np.ones(1))]), np.append(bulges, 0.0)
    return Fit(Arcs(vertices, bulges, closed), float(found.deviation.max()) / SEEN)


def _spans(pieces: Sequence[Piece], limit: float) -> Iterator[tuple[Array, Pairs]]:
    """Biarcs that stray by at most `limit` where it is measured, and their keys (2, m): piece, and parameter there."""
    number, low, width = np.arange(len(pieces)), np.zeros(len(pieces)), 1.0
    for _ in range(_MOST_CALLS):
        places, tangents = _called(pieces, number, low, width)
        row, first = np.arange(len(number)), np.zeros(len(number), dtype=int)
        for steps in (4, 2, 1):
            index = row[:, None], first[:, None] + steps * np.arange(SAMPLES + 1)
            found = along(places[index], tangents[index])
            good = found.deviation <= limit
            yield np.array([number[row], low[row] + width * first / _GRID])[:, good], found.of(good)
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
