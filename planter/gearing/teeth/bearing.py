"""Tooth pairs that bear a load, their distances from the pitch point, and the load for assumed sharing.

Rigid bodies do not determine how several pairs in contact share a load; each result names the assumed sharing.
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
"""Sides of the gear's teeth: those that turn the mate anticlockwise, and those that turn it clockwise."""


@dataclass(frozen=True)
class SharedLoad:
    """A shared load, (2, n) each by SIDES: its share ahead of the pitch point minus the share behind, and its mean
    distance from the pitch point [m], both along the normals into the gear."""

    lead: Array
    away: Array


@dataclass(frozen=True)
class BearingPairs:
    """Distances (2, k, n) [m] of pairs in contact from the pitch point at n positions, along the normals into the gear.

    They rise for each of SIDES, and are NaN where fewer than k pairs are in contact.
    """

    beyond: Array

    @classmethod
    def from_mesh(cls, mesh: Mesh, at: Array) -> BearingPairs:
        """Return the pairs of a mesh in contact, without backlash, at rolling lengths (n,) [m]."""
        pairs, (before, behind), sense = mesh.pairs, mesh.spans, mesh.pair.sense
        rolled = wrapped(at - pairs.at[:, None], mesh.period * mesh.pitch)
        pair, position = np.nonzero((rolled >= -before[:, None]) & (rolled <= behind[:, None]))
        side, s = pairs.side[pair], sense * rolled[pair, position]
        beyond = RACK("action", s=s, xi=np.zeros_like(s), side=side, alpha=mesh.gear.rack.pressure_angle)["beyond"]
        return cls(_group_values(beyond, np.where(side > 0, len(at), 0) + position, len(at)))

    @property
    def pairs(self) -> int:
        """Largest number of pairs in contact at the same time on one side of the teeth."""
        return self.beyond.shape[1]

    @property
    def equal(self) -> SharedLoad:
        """Load shared equally by all pairs in contact."""
        return SharedLoad(np.nanmean(np.sign(self.beyond), axis=1), np.nanmean(np.abs(self.beyond), axis=1))

    @property
    def nearest(self) -> SharedLoad:
        """Load on the pair nearest to the pitch point only."""
        return self._load_pair(np.nanargmin(np.abs(self.beyond), axis=1))

    @property
    def farthest(self) -> SharedLoad:
        """Load on the pair farthest from the pitch point only."""
        return self._load_pair(np.nanargmax(np.abs(self.beyond), axis=1))

    def alone(self, number: int) -> SharedLoad:
        """Return the load on the pair of a number only, or on the last if there are fewer."""
        last = np.isfinite(self.beyond).sum(axis=1) - 1
        return self._load_pair(np.minimum(number, last))

    def _load_pair(self, index: Integers) -> SharedLoad:
        distance = np.take_along_axis(self.beyond, index[:, None, :], axis=1)[:, 0]
        return SharedLoad(np.sign(distance), np.abs(distance))


def _group_values(values: Array, group: Integers, positions: int) -> Array:
    """Return values in rising order (2, k, n), by their groups: side and position."""
    order = np.lexsort((values, group))
    count = np.bincount(group, minlength=2 * positions)
    rank = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    table = np.full((2 * positions, count.max()), np.nan)
    table[group[order], rank] = values[order]
    return table.reshape(2, positions, -1).swapaxes(1, 2)


def find_changes(mesh: Mesh) -> tuple[Array, Array]:
    """Return rolling lengths (m,) [m] of a period at which tooth pairs begin, pass the pitch point and end, and "
    "sides."""
    pairs, (before, behind) = mesh.pairs, mesh.spans
    return np.concatenate([pairs.at - before, pairs.at, pairs.at + behind]), np.tile(pairs.side, 3)
