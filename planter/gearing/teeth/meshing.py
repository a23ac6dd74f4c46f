"""Two gears in mesh, without any use of how their flanks were made: contacts are solved, gaps and lost motion measured.

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
from planter.gearing.teeth.rack import RACK, Cut
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.arrays import Flags, Integers

POSITIONS = 720
"""Positions over a period that a mesh is examined at."""
_ASTRAY = 0.02
"""How far from the pitch point, in pitches, the search for a contact starts, so that it has to find it."""
_AROUND = 4
"""Teeth on either side of the pitch point that are asked whether they touch."""
_TURNED = 1e-4
"""And how far the mate is turned from where it belongs [rad]."""


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

    def places(self, at: Array) -> tuple[Array, Array]:
        """Angle and axis (3, n) of both gears at rolling lengths (n,)."""
        turned = [c.at(sense * at)[POLAR] for c, sense in zip(self.pair.curves, self.pair.senses, strict=True)]
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
    def contact_ratios(self) -> Array:
        """Contact ratio of each of `pairs`."""
        return np.asarray(sum(self.arcs) / self.pitch)

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

    def transmission_errors(self, faced: Facing) -> Array:
        """How far the mate (n,) turns from where it belongs [rad] until flanks without play touch."""
        return self._turned(faced, faced.xi, astray=True)[2]

    def lost_motion(self, faced: Facing) -> Array:
        """How far the mate turns from the central position [rad] until it is stopped, for each position and side."""
        turns = np.abs(self._turned(faced, self._thinned(faced), astray=False)[2])
        order = np.lexsort((faced.side, faced.at))
        at, side = faced.at[order], faced.side[order]
        first = np.flatnonzero(np.append(True, (np.diff(at) != 0) | (np.diff(side) != 0)))
        return np.asarray(np.minimum.reduceat(turns[order], first))

    def contacts(self, faced: Facing) -> Array:
        """Where flanks without play touch (2, n) [m], from the gear's axis, the line of centres along x."""
        at = self._turned(faced, faced.xi, astray=True)
        return self._both(faced, faced.xi, at[:2], at[2])[0].points

    def sliding(self, faced: Facing) -> Array:
        """Speed (n,) with which flanks slide in their contacts per rotation rate of the gear [m].

        Seen from the gear its mate turns about the pitch point, with the rates of both together.
        """
        curve, sense = self.pair.gear, self.pair.sense
        radius = np.hypot(*curve.at(sense * faced.at)[:2])
        arm = self.contacts(faced) - np.array([radius, np.zeros_like(radius)])
        return np.asarray(np.hypot(*arm) * (1 + radius / (self.pair.distance - radius)))

    def gaps(self, faced: Facing) -> Array:
        """Distance (n,) of flanks that face each other along their common normal, in the central position [m]."""
        xi, largest = self._thinned(faced), np.full(2, self.pitch / 4)

        def system(at: Array) -> tuple[Array, Array]:
            one, two = self._both(faced, xi, at, np.zeros_like(faced.at))
            apart = two.points - one.points
            along, turned = _dot(one.tangents, two.tangents), _cross(one.tangents, two.tangents)
            slopes = np.array([
                [one.turning * _cross(one.tangents, apart) - one.rate, two.rate * along],
                [-one.turning * along, two.turning * along],
            ])  # fmt: skip
            return np.array([_dot(apart, one.tangents), turned]), slopes

        start = np.array([self.pair.sense * faced.at, -self.pair.sense * faced.at])
        at = simultaneous.newton(system, start + _ASTRAY * self.pitch, largest)
        one, two = self._both(faced, xi, at, np.zeros_like(faced.at))
        return -_cross(one.tangents, two.points - one.points)

    def _thinned(self, faced: Facing) -> Array:
        """Places of flanks (2, n) with the play that each gear has its share of."""
        return np.asarray(faced.xi - faced.side * self.gear.rack.play / 4)

    def _turned(self, faced: Facing, xi: Array, astray: bool) -> Array:
        """Arc lengths at both contacts and the turn of the mate (3, n) with which flanks touch."""
        start = np.array([self.pair.sense * faced.at, -self.pair.sense * faced.at, np.zeros_like(faced.at)])
        if astray:
            start += np.array([[_ASTRAY * self.pitch], [-2 * _ASTRAY * self.pitch], [_TURNED]])

        def system(at: Array) -> tuple[Array, Array]:
            one, two = self._both(faced, xi, at[:2], at[2])
            apart = one.points - two.points
            along = _dot(one.tangents, two.tangents)
            arm = two.points - np.array([[self.pair.distance], [0.0]])
            moved = np.array([one.rate * one.tangents, -two.rate * two.tangents, [arm[1], -arm[0]]])
            bent = np.array([-one.turning * along, two.turning * along, along])
            slopes = np.concatenate([moved.swapaxes(0, 1), bent[None]])
            return np.vstack([apart, _cross(one.tangents, two.tangents)]), slopes

        return simultaneous.newton(system, start, np.array([self.pitch / 4, self.pitch / 4, 0.05]))

    def _both(self, faced: Facing, xi: Array, at: Array, turned: Array) -> tuple[Cut, Cut]:
        """Points of flanks at arc lengths (2, n) of both curves, in the frame of the axes, the mate turned further."""
        where = self.places(faced.at)
        where[1][0] += turned
        one, two = (_placed(g.flanks.line(at[k], xi[k], faced.side), where[k]) for k, g in enumerate(self.gears))
        return one, two


def _placed(cut: Cut, where: Array) -> Cut:
    px, py, ex, ey = RACK("placed", own=np.vstack([cut.points, cut.tangents]), where=where).values()
    return Cut(np.array([px, py]), np.array([ex, ey]), cut.rate, cut.turning)


def _some(faced: Facing, which: Flags) -> Facing:
    one, two = faced.numbers
    return Facing(faced.at[which], faced.side[which], (one[which], two[which]), faced.xi[:, which], faced.d[which])


def _dot(one: Array, other: Array) -> Array:
    return np.asarray((one * other).sum(axis=0))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[0] * other[1] - one[1] * other[0])
