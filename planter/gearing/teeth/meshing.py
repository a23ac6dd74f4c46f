"""Two gears in mesh: where they are, which flanks face each other, and for how long each pair is in contact.

At rolling length S both gears are turned so that their pitch curves touch on the line of centres, which is x from the
gear's axis to its mate's: the central position. Places `d` on a flank are lengths of the pitch curve towards its root.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth.curve import POLAR
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.pair import Pair
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

POSITIONS = 720
"""Positions over a period that a mesh is examined at."""
_AROUND = 4
"""Teeth on either side of the pitch point that are asked whether they touch."""


@dataclass(frozen=True)
class Facing:
    """Flanks of both gears (n,) that face each other at rolling lengths `at` (n,): their side and their numbers.

    `xi` (2, n) are their places on both pitch curves without play, in arc lengths over any number of turns; `d` is how
    far down the gear's flank the central position is.
    """

    at: Array
    side: Array
    numbers: tuple[Integers, Integers]
    xi: Array
    d: Array


@dataclass(frozen=True)
class Mesh:
    """A gear and its mate, cut by the same rack, on a pair of pitch curves."""

    pair: Pair
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
        """Rolling lengths (n,) at which the gear touches at polar angles (n,) [rad], counted in the pair's sense."""
        sense = self.pair.sense
        return np.asarray(sense * self.gear.curve.arc(sense * polar))

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Arc lengths (n,) of both pitch curves where they touch at rolling lengths (n,)."""
        one, two = self.pair.senses
        return one * at, two * at

    def places(self, at: Array) -> tuple[Array, Array]:
        """Angle and axis (3, n) of both gears at rolling lengths (n,)."""
        turned = [c.at(s)[POLAR] for c, s in zip(self.pair.curves, self.arc_lengths(at), strict=True)]
        zero = np.zeros_like(at)
        return (
            np.array([-turned[0], zero, zero]),
            np.array([np.pi - turned[1], np.full_like(at, self.pair.distance), zero]),
        )

    @cached_property
    def reaches(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Of each gear: lengths (2 z,) from its flanks' places to where they are cut at the tip, and where they end."""
        one, two = (
            (np.abs(g.flanks.tips[0] - g.flanks.xi), np.abs([path[0].lower for path in g.paths] - g.flanks.xi))
            for g in self.gears
        )
        return one, two

    @cached_property
    def pairs(self) -> Facing:
        """Every pair of flanks over a period, each where it meets in the pitch point."""
        tooth = np.repeat(np.arange(self.period), 2)
        return self._facing(None, tooth.astype(float), np.tile([-1.0, 1.0], self.period))

    def _facing(self, at: Array | None, tooth: Array, side: Array) -> Facing:
        """The gear's flanks (n,), by their tooth over any number of turns and their side, with those of the mate."""
        flanks, p = [g.flanks for g in self.gears], self.pitch
        full = [f.rack.sizes["full"] for f in flanks]
        own = flanks[0].phase + p * tooth + side * full[0]
        other = np.rint((-own - flanks[1].phase - side * full[1]) / p)
        numbers = [
            np.mod(count, f.z).astype(int) + f.z * (side > 0) for count, f in zip((tooth, other), flanks, strict=True)
        ]
        meets = self.pair.sense * own if at is None else at
        mate = flanks[1].phase + p * other + side * full[1]
        d = side * (self.pair.sense * meets - own)
        return Facing(meets, side, (numbers[0], numbers[1]), np.array([own, mate]), d)

    def facing(self, at: Array) -> Facing:
        """Flanks that face each other at rolling lengths (n,), both sides of all teeth that reach there."""
        base: Array = np.rint((self.pair.sense * at - self.gear.flanks.phase) / self.pitch)
        grid = np.array([(k, side) for k in range(-_AROUND, _AROUND + 1) for side in (-1.0, 1.0)])
        tooth: Array = (base[:, None] + grid[:, 0]).ravel()
        found = self._facing(np.repeat(at, len(grid)), tooth, np.tile(grid[:, 1], len(at)))
        (tip, end), (mate_tip, mate_end) = (
            (r[0][n], r[1][n]) for r, n in zip(self.reaches, found.numbers, strict=True)
        )
        thinned = self.gear.rack.play / 4
        low, high = np.maximum(-tip - thinned, thinned - mate_end), np.minimum(mate_tip + thinned, end - thinned)
        return _some(found, (found.d >= low) & (found.d <= high))

    @cached_property
    def arcs(self) -> tuple[Array, Array]:
        """Of each of `pairs`: lengths of rolling in contact on the gear's addendum and on its mate's.

        Each tip is counted from its own flank, and a flank that ends before the other's tip ends them.
        """
        (tip, end), (mate_tip, mate_end) = (
            (r[0][n], r[1][n]) for r, n in zip(self.reaches, self.pairs.numbers, strict=True)
        )
        return np.minimum(tip, mate_end), np.minimum(mate_tip, end)

    @property
    def spans(self) -> tuple[Array, Array]:
        """Of each of `pairs`: lengths of rolling in contact before the pitch point and behind it."""
        above, below = self.arcs
        along = self.pair.sense * self.pairs.side > 0
        return np.where(along, above, below), np.where(along, below, above)

    @property
    def contact_ratios(self) -> Array:
        """Contact ratio of each of `pairs`."""
        return np.asarray(sum(self.arcs) / self.pitch)

    @property
    def laps(self) -> Array:
        """Rolling length (n,) for which each of `pairs` is in contact together with the next of its side [m].

        Below 0 no teeth touch for so long between the two.
        """
        pairs, (before, behind) = self.pairs, self.spans
        return self.shared(pairs.at - before, pairs.at + behind)

    def shared(self, start: Array, end: Array) -> Array:
        """Return the rolling length (n,) [m] for which each of `pairs` touches together with the next of its side.

        They touch from rolling lengths `start` (n,) to `end` (n,) [m].
        """
        pairs, found = self.pairs, np.empty_like(start)
        for side in (-1.0, 1.0):
            which = np.flatnonzero(pairs.side == side)
            which = which[np.argsort(pairs.at[which])]
            following = np.append(start[which][1:], start[which][0] + self.period * self.pitch)
            found[which] = end[which] - following
        return found

    @property
    def ends(self) -> Facing:
        """Every pair of flanks where it begins to touch and where it ends, without play."""
        pairs, (above, below) = self.pairs, self.arcs
        one, two = pairs.numbers
        along = self.pair.sense * pairs.side
        return Facing(
            np.concatenate([pairs.at - along * above, pairs.at + along * below]), np.tile(pairs.side, 2),
            (np.tile(one, 2), np.tile(two, 2)), np.tile(pairs.xi, 2), np.concatenate([-above, below]),
        )  # fmt: skip


def _some(faced: Facing, which: Flags) -> Facing:
    one, two = faced.numbers
    return Facing(faced.at[which], faced.side[which], (one[which], two[which]), faced.xi[:, which], faced.d[which])
