"""Which pairs of teeth bear a load, how far from the pitch point, and what that comes to where they share it.

Several pairs in contact share a load in a way that rigid bodies leave open: what is told is told of a sharing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.meshing import Mesh
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import wrapped
from planter.numerics.arrays import Integers

SIDES = (-1.0, 1.0)
"""Sides of the gear's teeth: of those that turn the mate anticlockwise, and of those that turn it clockwise."""


@dataclass(frozen=True)
class Load:
    """A load shared out, (2, n) each by SIDES: its share ahead of the pitch point less that behind, and its mean
    distance from there [m], both along the normals into the gear."""

    lead: Array
    away: Array


@dataclass(frozen=True)
class Bearing:
    """Distances (2, k, n) [m] of pairs in contact from the pitch point at n positions, along the normals into the gear.

    They rise for each of SIDES, and are NaN where fewer than k pairs are in contact.
    """

    beyond: Array

    @classmethod
    def of(cls, mesh: Mesh, at: Array) -> Bearing:
        """Of the pairs of a mesh, without play, at rolling lengths (n,)."""
        pairs, (before, behind), sense = mesh.pairs, mesh.spans, mesh.pair.sense
        rolled = wrapped(at - pairs.at[:, None], mesh.period * mesh.pitch)
        pair, position = np.nonzero((rolled >= -before[:, None]) & (rolled <= behind[:, None]))
        side, s = pairs.side[pair], sense * rolled[pair, position]
        beyond = RACK("action", s=s, xi=np.zeros_like(s), side=side, alpha=mesh.gear.rack.pressure_angle)["beyond"]
        return cls(_grouped(beyond, np.where(side > 0, len(at), 0) + position, len(at)))

    @property
    def pairs(self) -> int:
        """The most pairs that are in contact at once on one side of the teeth."""
        return self.beyond.shape[1]

    @property
    def equal(self) -> Load:
        """Every pair in contact bears the same."""
        return Load(np.nanmean(np.sign(self.beyond), axis=1), np.nanmean(np.abs(self.beyond), axis=1))

    @property
    def nearest(self) -> Load:
        """The pair nearest to the pitch point bears all."""
        return self._alone(np.nanargmin(np.abs(self.beyond), axis=1))

    @property
    def farthest(self) -> Load:
        """The pair farthest from the pitch point bears all."""
        return self._alone(np.nanargmax(np.abs(self.beyond), axis=1))

    def alone(self, which: int) -> Load:
        """One pair bears all: that of a number, the last where there are fewer."""
        last = np.isfinite(self.beyond).sum(axis=1) - 1
        return self._alone(np.minimum(which, last))

    def _alone(self, which: Integers) -> Load:
        own = np.take_along_axis(self.beyond, which[:, None, :], axis=1)[:, 0]
        return Load(np.sign(own), np.abs(own))


def _grouped(values: Array, group: Integers, positions: int) -> Array:
    """Values by their group, both sides of so many positions, in rising order (2, k, n)."""
    order = np.lexsort((values, group))
    count = np.bincount(group, minlength=2 * positions)
    rank = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    found = np.full((2 * positions, count.max()), np.nan)
    found[group[order], rank] = values[order]
    return found.reshape(2, positions, -1).swapaxes(1, 2)


def changes(mesh: Mesh) -> tuple[Array, Array]:
    """Rolling lengths (m,) over a period at which pairs of teeth begin to touch, pass the pitch point and end, and the
    side of each."""
    pairs, (before, behind) = mesh.pairs, mesh.spans
    return np.concatenate([pairs.at - before, pairs.at, pairs.at + behind]), np.tile(pairs.side, 3)
