"""Exact pieces as cubic splines through their places, along their tangents at both ends."""

from __future__ import annotations

from dataclasses import dataclass

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
    """A B-spline by the length along it [m]: poles (k, 2) [m], distinct knots (m,) [m] with their multiplicities."""

    poles: Array
    knots: Array
    multiplicities: tuple[int, ...]
    degree: int = DEGREE


def through(piece: Piece, tolerance: float) -> Spline:
    """A spline within `tolerance` [m] of a piece, measured across it halfway between the places that it goes through.

    Raises ComputationError, naming the piece, for one that no spline follows.
    """
    spans = FEWEST
    while spans <= MOST:
        s = np.linspace(0.0, 1.0, 2 * spans + 1)
        places, tangents = piece.at(s), piece.tangent(s)
        length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
        ends = ([(1, tangents[0])], [(1, tangents[-1])])
        found = make_interp_spline(length[::2], places[::2], k=DEGREE, bc_type=ends)
        x, y = (found(length[1::2]) - places[1::2]).T
        if np.abs(x * tangents[1::2, 1] - y * tangents[1::2, 0]).max() <= tolerance:
            knots, multiplicities = np.unique(found.t, return_counts=True)
            return Spline(found.c, knots, tuple(multiplicities.tolist()))
        spans *= 2
    raise ComputationError(f"the {piece.kind} turns too sharply for a spline within {tolerance * 1e6:g} um")
