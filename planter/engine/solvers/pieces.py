"""Gauss-Legendre nodes of panels in pieces, graded where a panel begins and ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from planter.kernels import Array, Flags, Integers
from planter.numerics import piecewise

NODES = 16
MAX_PIECE = np.pi / 8
"""Nodes in a piece, and the greatest length of a piece [rad]."""


@dataclass(frozen=True)
class Pieces:
    """Parts (k,) of panels, from `low` to `high` of the argument 0 <= u <= 1 of one of the `count`
    pieces of a panel.

    The first and the last piece are graded by the square of their argument, after which roots of
    the distance from an end of the panel, and their derivatives, are polynomials in u: Gauss's rule
    is exact for these, too.

    >>> places, weights = Pieces.divide(np.array([2])).place()
    >>> round(float((weights * places**0.5).sum()), 14), round(float((weights * places**-0.5).sum()), 13)
    (0.66666666666667, 2.0)
    """

    panel: Integers
    number: Integers
    count: Integers
    low: Array
    high: Array

    @classmethod
    def divide(cls, counts: Integers) -> Pieces:
        """Return all pieces of panels that have so many each, (panels,)."""
        panel = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(panel)) - np.repeat(np.cumsum(counts) - counts, counts)
        return cls(panel, number, counts[panel], np.zeros(len(panel)), np.ones(len(panel)))

    def place(self) -> tuple[Array, Array]:
        """Return places in their panels, from 0 to 1, and weights, whose sum over a panel is 1, (k,
        NODES) each.
        """
        points, shares = piecewise.gauss_panels(np.array([0.0, 1.0]), NODES)
        width = (self.high - self.low)[:, None]
        u, number, count = (
            self.low[:, None] + width * points,
            self.number[:, None],
            self.count[:, None],
        )
        is_first, is_last = number == 0, number == count - 1
        place, rise = (number + u) / count, np.ones_like(u) / count
        place, rise = (
            np.where(is_first, u**2 / count, place),
            np.where(is_first, 2 * u / count, rise),
        )
        place = np.where(is_last, 1 - (1 - u) ** 2 / count, place)
        rise = np.where(is_last, 2 * (1 - u) / count, rise)
        is_only = is_first & is_last
        place = np.where(is_only, np.sin(np.pi * u / 2) ** 2, place)
        rise = np.where(is_only, np.pi / 2 * np.sin(np.pi * u), rise)
        return place, rise * shares * width

    def select(self, chosen: Flags | Integers) -> Pieces:
        """Return the pieces that flags (k,) mark, or those at indices."""
        return Pieces(
            self.panel[chosen],
            self.number[chosen],
            self.count[chosen],
            self.low[chosen],
            self.high[chosen],
        )

    def halve(self) -> Pieces:
        """Return both halves of all pieces."""
        middle = (self.low + self.high) / 2
        panel, number, count = (np.tile(part, 2) for part in (self.panel, self.number, self.count))
        return Pieces(
            panel, number, count, np.append(self.low, middle), np.append(middle, self.high)
        )


@cache
def build_tail(count: int) -> Array:
    """Return what gives the last two coefficients of a Legendre series from values at Gauss's
    nodes, (count, 2).
    """
    points, weights = np.polynomial.legendre.leggauss(count)
    orders = np.arange(count - 2, count)
    tail: Array = (
        np.polynomial.legendre.legvander(points, count - 1)[:, orders]
        * weights[:, None]
        * (orders + 0.5)
    )
    return tail
