"""Meshes of two gears: positions, facing flanks, length of contact of each pair, and the pairs that
bear a load.

At rolling length S both gears are turned so that their pitch curves touch on the line of centres,
which is x from the gear's axis to its mate's: the central position. Places `d` on a flank are
lengths of the pitch curve towards its root. Rigid bodies do not determine how several pairs in
contact share a load; each result names the assumed sharing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.gears.geometry.gear import Gear
from planter.gears.geometry.pitch_curves import POLAR, RACK, CurvePair, PitchCurve, place_gears
from planter.kernels import Array, Flags, Integers
from planter.numerics.arrays import wrap_angle

POSITIONS = 720
"""Positions of a period at which a mesh is checked."""
_NEIGHBOURS = 4
"""Teeth on either side of the pitch point that may touch."""


@dataclass(frozen=True)
class FacingFlanks:
    """Flanks of both gears (n,) that face each other at rolling lengths `at` (n,): their side and
    their numbers.

    `xi` (2, n) are their crossings of both pitch curves without backlash, in arc lengths [m] over
    any number of turns; `d` is the position of the central position down the gear's flank [m].
    """

    at: Array
    side: Array
    numbers: tuple[Integers, Integers]
    xi: Array
    d: Array

    def select(self, index: Integers | Flags) -> FacingFlanks:
        """Return the flanks of an index or a mask."""
        first, second = self.numbers
        numbers = first[index], second[index]
        return FacingFlanks(
            self.at[index], self.side[index], numbers, self.xi[:, index], self.d[index]
        )


@dataclass(frozen=True)
class Mesh:
    """A gear and its mate, cut by the same rack, on a pair of pitch curves."""

    pair: CurvePair
    gear: Gear
    mate: Gear

    @property
    def gears(self) -> tuple[Gear, Gear]:
        return self.gear, self.mate

    @cached_property
    def pitch(self) -> float:
        return self.gear.rack.pitch

    @cached_property
    def period(self) -> int:
        """Pitches after which the same teeth meet again."""
        return int(np.lcm(self.gear.z, self.mate.z))

    @cached_property
    def positions(self) -> Array:
        """Rolling lengths over a period [m]."""
        return np.arange(POSITIONS) * self.period * self.pitch / POSITIONS

    def rolled(self, polar: Array) -> Array:
        """Return rolling lengths (n,) [m] at which the gear touches at polar angles (n,) [rad], in
        the pair's sense.
        """
        sense = self.pair.sense
        return sense * self.gear.curve.arc(sense * polar)

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Return arc lengths (n,) [m] of the contact on both pitch curves at rolling lengths (n,)
        [m].
        """
        sense, mate_sense = self.pair.senses
        return sense * at, mate_sense * at

    def places(self, at: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at rolling lengths (n,) [m]."""
        turned = [
            c.at(s)[POLAR] for c, s in zip(self.pair.curves, self.arc_lengths(at), strict=True)
        ]
        return place_gears(turned[0], turned[1], self.pair.distance)

    @cached_property
    def pairs(self) -> FacingFlanks:
        """Every pair of flanks over a period, each where it meets in the pitch point."""
        tooth = np.repeat(np.arange(self.period), 2)
        return self._facing(None, tooth.astype(float), np.tile([-1.0, 1.0], self.period))

    def _facing(self, at: Array | None, tooth: Array, side: Array) -> FacingFlanks:
        """Return the gear's flanks (n,), by tooth over any number of turns and side, with those of
        the mate.
        """
        flanks, p = [g.flanks for g in self.gears], self.pitch
        full = [f.rack.sizes["full"] for f in flanks]
        arc = flanks[0].phase + p * tooth + side * full[0]
        mate_tooth = np.rint((-arc - flanks[1].phase - side * full[1]) / p)
        numbers = [
            np.mod(count, f.z).astype(int) + f.z * (side > 0)
            for count, f in zip((tooth, mate_tooth), flanks, strict=True)
        ]
        meets = self.pair.sense * arc if at is None else at
        mate = flanks[1].phase + p * mate_tooth + side * full[1]
        d = side * (self.pair.sense * meets - arc)
        return FacingFlanks(meets, side, (numbers[0], numbers[1]), np.array([arc, mate]), d)

    def facing(self, at: Array) -> FacingFlanks:
        """Return the facing flanks at rolling lengths (n,) [m], on both sides of all teeth in
        reach.
        """
        base: Array = np.rint((self.pair.sense * at - self.gear.flanks.phase) / self.pitch)
        grid = np.array(
            [(k, side) for k in range(-_NEIGHBOURS, _NEIGHBOURS + 1) for side in (-1.0, 1.0)]
        )
        tooth: Array = (base[:, None] + grid[:, 0]).ravel()
        flanks = self._facing(np.repeat(at, len(grid)), tooth, np.tile(grid[:, 1], len(at)))
        (tip, end), (mate_tip, mate_end) = list_reaches(self.gears, flanks)
        # half of the backlash for each gear, half of that for each of its flanks
        thinned = self.gear.rack.play / 4
        low, high = (
            np.maximum(-tip - thinned, thinned - mate_end),
            np.minimum(mate_tip + thinned, end - thinned),
        )
        return flanks.select((flanks.d >= low) & (flanks.d <= high))

    @cached_property
    def arcs(self) -> tuple[Array, Array]:
        """Rolling lengths in contact of each of `pairs` on the gear's addendum and on its mate's
        [m].

        Each tip is counted from its own flank, and a flank that ends before the other's tip ends
        them.
        """
        return limit_arcs(self.gears, self.pairs)

    @property
    def spans(self) -> tuple[Array, Array]:
        """Rolling lengths in contact of each of `pairs` before the pitch point and behind it
        [m].
        """
        above, below = self.arcs
        forward = self.pair.sense * self.pairs.side > 0
        return np.where(forward, above, below), np.where(forward, below, above)

    @property
    def contact_ratios(self) -> Array:
        """Contact ratio of each of `pairs`."""
        return (self.arcs[0] + self.arcs[1]) / self.pitch

    @property
    def laps(self) -> Array:
        """Rolling length (n,) for which each of `pairs` is in contact together with the next of its
        side [m].

        Below 0 no teeth touch for so long between the two.
        """
        pairs, (before, behind) = self.pairs, self.spans
        return self.shared(pairs.at - before, pairs.at + behind)

    def shared(self, start: Array, end: Array) -> Array:
        """Return the rolling length (n,) [m] for which each of `pairs` touches together with the
        next of its side.

        They touch from rolling lengths `start` (n,) to `end` (n,) [m].
        """
        pairs, lengths = self.pairs, np.empty_like(start)
        for side in (-1.0, 1.0):
            index = np.flatnonzero(pairs.side == side)
            # the last pair of a period is followed by the first of the next
            index = index[np.argsort(pairs.at[index])]
            following = np.append(start[index][1:], start[index][0] + self.period * self.pitch)
            lengths[index] = end[index] - following
        return lengths

    @property
    def ends(self) -> FacingFlanks:
        """Every pair of flanks where it begins to touch and where it ends, without play."""
        pairs, (above, below) = self.pairs, self.arcs
        sense = self.pair.sense * pairs.side
        at = np.concatenate([pairs.at - sense * above, pairs.at + sense * below])
        twice = pairs.select(np.tile(np.arange(len(pairs.at)), 2))
        return replace(twice, at=at, d=np.concatenate([-above, below]))


def compute_pressure_angles(curve: PitchCurve, s: Array, alpha: float) -> Array:
    """Return the angles (2, n) [rad] of the normals of both SIDES to the perpendicular of the line
    of centres, in the pitch point at arc lengths (n,) [m] of the gear.
    """
    place = curve.at(s)[:POLAR]
    columns = [RACK("pressure", place=place, side=side, alpha=alpha) for side in SIDES]
    return np.array([column["pressure"] for column in columns])


def list_reaches(gears: Sequence[Gear], faced: FacingFlanks) -> list[tuple[Array, Array]]:
    """Return `Gear.reaches` (n,) [m] of the flanks of both gears that face each other."""
    pairs = zip(gears, faced.numbers, strict=True)
    return [(gear.reaches[0][number], gear.reaches[1][number]) for gear, number in pairs]


def limit_arcs(gears: Sequence[Gear], faced: FacingFlanks) -> tuple[Array, Array]:
    """Return the rolling lengths (n,) [m] in contact on the addendum of the gear, and of its mate.

    A flank that ends before the other's tip ends the contact.
    """
    (tip, end), (mate_tip, mate_end) = list_reaches(gears, faced)
    return np.minimum(tip, mate_end), np.minimum(mate_tip, end)


SIDES = (-1.0, 1.0)
"""Sides of the gear's teeth: those that turn the mate anticlockwise, and those that turn it
clockwise.
"""


@dataclass(frozen=True)
class SharedLoad:
    """A shared load, (2, n) each by SIDES: its share ahead of the pitch point minus the share
    behind, and its mean distance from the pitch point [m], both along the normals into the gear.
    """

    lead: Array
    away: Array


@dataclass(frozen=True)
class BearingPairs:
    """Distances (2, k, n) [m] of pairs in contact from the pitch point at n positions, along the
    normals into the gear.

    They rise for each of SIDES, and are NaN where fewer than k pairs are in contact.
    """

    beyond: Array

    @classmethod
    def from_mesh(cls, mesh: Mesh, at: Array) -> BearingPairs:
        """Return the pairs of a mesh in contact, without backlash, at rolling lengths (n,) [m]."""
        pairs, (before, behind), sense = mesh.pairs, mesh.spans, mesh.pair.sense
        rolled = wrap_angle(at - pairs.at[:, None], mesh.period * mesh.pitch)
        pair, position = np.nonzero((rolled >= -before[:, None]) & (rolled <= behind[:, None]))
        side, s = pairs.side[pair], sense * rolled[pair, position]
        beyond = RACK(
            "action", s=s, xi=np.zeros_like(s), side=side, alpha=mesh.gear.rack.pressure_angle
        )["beyond"]
        return cls(_group_values(beyond, np.where(side > 0, len(at), 0) + position, len(at)))

    @property
    def pairs(self) -> int:
        """Largest number of pairs in contact at the same time on one side of the teeth."""
        return self.beyond.shape[1]

    @property
    def equal(self) -> SharedLoad:
        """Load shared equally by all pairs in contact."""
        return SharedLoad(
            np.nanmean(np.sign(self.beyond), axis=1), np.nanmean(np.abs(self.beyond), axis=1)
        )

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
    """Return rolling lengths (m,) [m] of a period at which tooth pairs begin, pass the pitch point
    and end, and " "sides.
    """
    pairs, (before, behind) = mesh.pairs, mesh.spans
    return np.concatenate([pairs.at - before, pairs.at, pairs.at + behind]), np.tile(pairs.side, 3)
