"""Exact pieces as cubic splines through their places; those of a plane keep their tangents at both ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from planter.errors import ComputationError
from planter.kernels import Array
from planter.workshop.outline import Piece

DEGREE = 3
FEWEST, MOST = 8, 2048
"""Spans of a spline."""


@dataclass(frozen=True)
class Spline:
    """A B-spline by the length along it [m]: poles (k, d) [m], distinct knots (m,) [m] with their multiplicities."""

    poles: Array
    knots: Array
    multiplicities: tuple[int, ...]
    degree: int = DEGREE


def through(piece: Piece, tolerance: float) -> Spline:
    """A spline within `tolerance` [m] of a piece, measured across it halfway between the places that it goes through.

    Raises ComputationError, naming the piece, for one that no spline follows.
    """
    for s in _steps():
        places, tangents = piece.at(s), piece.tangent(s)
        found, middles = _interpolated(places, ([(1, tangents[0])], [(1, tangents[-1])]))
        x, y = (middles - places[1::2]).T
        if np.abs(x * tangents[1::2, 1] - y * tangents[1::2, 0]).max() <= tolerance:
            return found
    raise ComputationError(f"a piece, {piece.kind}, turns too sharply for a spline within {tolerance * 1e6:g} um")


def in_space(places: Callable[[Array], Array], tolerance: float) -> Spline:
    """A spline through places (n, 3) [m] along s from 0 to 1, as near to those halfway between as `tolerance` [m].

    Raises ComputationError for a course that no spline follows.
    """
    for s in _steps():
        given = places(s)
        found, middles = _interpolated(given, "not-a-knot")
        if np.sqrt(((middles - given[1::2]) ** 2).sum(axis=1)).max() <= tolerance:
            return found
    raise ComputationError(f"a course in space turns too sharply for a spline within {tolerance * 1e6:g} um")


def _steps() -> Iterator[Array]:
    spans = FEWEST
    while spans <= MOST:
        yield np.linspace(0.0, 1.0, 2 * spans + 1)
        spans *= 2


def _interpolated(places: Array, ends: Any) -> tuple[Spline, Array]:
    """A spline through every other place (2 n + 1, d) by the length of chords, and where it is at those between."""
    length = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(places, axis=0) ** 2).sum(axis=1)))])
    found = make_interp_spline(length[::2], places[::2], k=DEGREE, bc_type=ends)
    knots, multiplicities = np.unique(found.t, return_counts=True)
    return Spline(found.c, knots, tuple(multiplicities.tolist())), found(length[1::2])
