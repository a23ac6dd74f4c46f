"""Piecewise polynomials as graphs: the piece is chosen without a branch, its coefficients may be numbers or graphs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array


def compose_pieces(place: ca.SX, knots: Array, coefficients: Sequence[Any], orders: int) -> list[ca.SX]:
    """Return the graphs of a piecewise polynomial at a place, and of its derivatives up to below `orders`.

    `knots` (n,) are the beginnings of the pieces; the first and the last piece go on beyond the ends. Coefficients are
    (n,) for each power of the distance from a piece's knot, the highest power first.
    """
    begun = [ca.SX(1), *(place >= float(knot) for knot in knots[1:]), ca.SX(0)]
    chosen = ca.vertcat(*(ca.SX(one - other) for one, other in itertools.pairwise(begun)))
    powers = [_select(chosen, row) for row in coefficients]
    distance = place - _select(chosen, knots)
    derivatives = []
    for _ in range(orders):
        value = ca.SX(0)
        for power in powers:
            value = value * distance + power
        derivatives.append(value)
        degree = len(powers) - 1
        powers = [power * (degree - k) for k, power in enumerate(powers[:-1])]
    return derivatives


def _select(chosen: ca.SX, row: Any) -> ca.SX:
    """Return the entry of a row (n,) that is chosen; CasADi reads an array's memory whatever its strides are."""
    return ca.dot(chosen, ca.DM(row.tolist()) if isinstance(row, np.ndarray) else row)
