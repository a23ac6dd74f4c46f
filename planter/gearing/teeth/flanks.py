"""The flanks of a gear: where each meets its tip, how far it is regular, where it ends in its fillet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.curve import KAPPA, POLAR, PitchCurve
from planter.gearing.teeth.rack import RACK, Cut, Rack
from planter.kernels import Array
from planter.numerics import roots, simultaneous
from planter.numerics.arrays import Integers

_CELLS = 16
"""Cells in which extremes of a flank's rate are looked for, on each of its smooth parts."""
_GRADED = np.append(np.linspace(1, 0.5, 81)[:-1], np.geomspace(0.5, 1e-9, 160))
"""Where a flank and a fillet are tried for where they cross, as shares of their lengths from where they would meet."""
_NO_LENGTH = 1e-12
"""Share of a curve's length below which a part of it is none."""


@dataclass(frozen=True)
class Flanks:
    """Both flanks of z teeth that a rack cuts on a curve, (2 z,) each: all that begin a tooth, then all that end one.

    Tooth 0 is centred at arc length `phase` [m]; `d` is the length of the pitch curve from a flank's place to where a
    point of it is cut, towards its root.
    """

    curve: PitchCurve
    rack: Rack
    z: int
    phase: float

    @cached_property
    def tooth(self) -> Integers:
        return np.tile(np.arange(self.z), 2)

    @cached_property
    def side(self) -> Array:
        return np.repeat([-1.0, 1.0], self.z)

    @cached_property
    def centre(self) -> Array:
        """Arc lengths of the teeth's centres."""
        return np.asarray(self.phase + self.rack.pitch * self.tooth)

    @cached_property
    def xi(self) -> Array:
        """Places on the pitch curve."""
        return self.centre + self.side * self.rack.sizes["half"]

    @cached_property
    def middle(self) -> Array:
        """Centres of the round of the rack beside each flank, along the pitch curve: where its fillet ends."""
        return self.centre + self.side * self.rack.sizes["beside"]

    def line(self, s: Array, xi: Array, side: Array, towards: Array | None = None) -> Cut:
        """What a straight flank of the rack cuts at arc lengths (n,) that crosses its pitch line at places (n,)."""
        place = self.curve.at(s, towards)[:POLAR]
        return Cut.of(RACK("flank", place=place, s=s, xi=xi, side=side, alpha=self.rack.pressure_angle))

    def flank(self, s: Array, which: Integers, towards: Array | None = None) -> Cut:
        """What flanks (n,) by their numbers are at arc lengths (n,)."""
        return self.line(s, self.xi[which], self.side[which], towards)

    def fillet(self, s: Array, which: Integers, towards: Array | None = None) -> Cut:
        """What fillets (n,) are at arc lengths (n,)."""
        place, sizes = self.curve.at(s, towards)[:POLAR], self.rack.sizes
        return Cut.of(
            RACK("fillet", place=place, s=s, middle=self.middle[which], depth=sizes["sunk"], rho=sizes["round_"])
        )

    def equidistant(self, s: Array, height: float, towards: Array | None = None) -> Cut:
        """The line at a height over the pitch curve."""
        return Cut.of(RACK("equidistant", place=self.curve.at(s, towards)[:POLAR], height=height))

    @cached_property
    def tips(self) -> tuple[Array, Array]:
        """Arc lengths where each flank is cut, and where the tip line is, in the point in which they meet."""
        height, every = self.rack.sizes["tip"], np.arange(2 * self.z)
        kappa = np.maximum(self.curve.at(self.xi)[KAPPA], 0.0)
        reach = RACK("reach", kappa=kappa, height=height, alpha=self.rack.pressure_angle)["reach"]

        def gap(at: Array) -> tuple[Array, Array]:
            return apart(self.flank(at[0], every), self.equidistant(at[1], height))

        start = np.array([self.xi - self.side * reach, self.xi])
        flank, tip = simultaneous.newton(gap, start, np.full(2, self.rack.module))
        return flank, tip

    @cached_property
    def straight_ends(self) -> Array:
        """Arc lengths where the rack's straight flank ends."""
        return self.xi + self.side * self.rack.run(self.rack.sizes["straight"])

    @cached_property
    def margins(self) -> Array:
        """Least rate of each flank from its place down to the rack's addendum, 1 on a rack; below 0 it is undercut."""
        ends = self.xi + self.side * self.rack.run(self.rack.sizes["form"])
        return self._least(self.xi, ends).value

    @cached_property
    def upper_margins(self) -> Array:
        """The same from the place of each flank up to its tip, which hollow curves make less."""
        return self._least(self.tips[0], self.xi).value

    @cached_property
    def whole(self) -> Extremes:
        """Where the rate of each flank is least, down to the end of the rack's straight flank."""
        return self._least(self.xi, self.straight_ends)

    @cached_property
    def undercut(self) -> Integers:
        """Flanks that turn back before the rack's straight flank ends, and so end where their fillet crosses them."""
        return np.flatnonzero(self.whole.value < 0)

    @cached_property
    def ends(self) -> tuple[Array, Array]:
        """Arc lengths where each flank is cut, and where its fillet is, in the point in which they meet."""
        flank, fillet = self.straight_ends.copy(), self.straight_ends.copy()
        which = self.undercut
        if len(which):

            def gap(at: Array) -> tuple[Array, Array]:
                return apart(self.flank(at[0], which), self.fillet(at[1], which))

            start = np.array([self._crossing(int(one)) for one in which]).T
            flank[which], fillet[which] = simultaneous.newton(gap, start, np.full(2, self.rack.module / 20))
        return flank, fillet

    def _crossing(self, one: int) -> tuple[float, float]:
        """About where the flank, on its way down from the tip, first meets the fillet.

        Places are told by their distance from where the flank turns back and where its fillet begins: the less is cut
        away, the nearer to both they meet.
        """
        turn, start = self._turn_back(one), float(self.straight_ends[one])
        lines = [turn + (self.tips[0][one] - turn) * _GRADED, start + (self.middle[one] - start) * _GRADED]
        which = np.full(len(_GRADED), one)
        found = crossing(self.flank(lines[0], which).points, self.fillet(lines[1], which).points)
        if found is None:
            raise GeometryError(
                f"the flanks of tooth {self.tooth[one]} are cut away: the rack's round leaves nothing of them"
            )
        flank, fillet = (float(line[k : k + 2].mean()) for line, k in zip(lines, found, strict=True))
        return flank, fillet

    def _turn_back(self, one: int) -> float:
        """The first arc length, from the flank's place down, where its rate is no more positive."""
        down = np.linspace(self.xi[one], self.whole.place[one], 8 * _CELLS + 1)
        which = np.full(len(down), one)
        rate = self._regular(down, which)[0]
        k = int(np.argmax(rate < 0))
        low, high = sorted(((down[k - 1], rate[k - 1]), (down[k], rate[k])))
        ends = np.array([low[1]]), np.array([high[1]])

        def rates(s: Array) -> tuple[Array, Array]:
            return self._regular(s, which[:1])[:2]

        return float(roots.newton(rates, np.array([low[0]]), np.array([high[0]]), ends)[0])

    def _least(self, start: Array, end: Array) -> Extremes:
        """Least rate of each flank, in parts of that of a rack, between two arc lengths, and where it is."""
        which, low, high = smooth_parts(self.curve, np.minimum(start, end), np.maximum(start, end))
        grid = low[:, None] + np.outer(high - low, np.linspace(0, 1, _CELLS + 1))
        middle = np.broadcast_to((low + high)[:, None] / 2, grid.shape).ravel()
        owner, places = np.repeat(which, _CELLS + 1), grid.ravel()
        slopes = self._regular(places, owner, middle)[1].reshape(grid.shape)
        part, cell = np.nonzero((slopes[:, :-1] < 0) & (slopes[:, 1:] > 0))
        if len(part):
            ends = slopes[part, cell], slopes[part, cell + 1]
            inside = roots.newton(
                lambda s: self._regular(s, which[part])[1:], grid[part, cell], grid[part, cell + 1], ends
            )
            owner, places = np.append(owner, which[part]), np.append(places, inside)
            middle = np.append(middle, inside)
        rates = self._regular(places, owner, middle)[0]
        order = np.lexsort((rates, owner))
        first = order[np.searchsorted(owner[order], np.arange(2 * self.z))]
        return Extremes(places[first], rates[first])

    def _regular(self, s: Array, which: Integers, towards: Array | None = None) -> tuple[Array, Array, Array]:
        """Rate of flanks in parts of that of a rack, and its first two derivatives along the pitch curve."""
        bends, alpha = self.curve.bends(s, towards), self.rack.pressure_angle
        found = RACK("regularity", bends=bends, s=s, xi=self.xi[which], side=self.side[which], alpha=alpha)
        value, first, second = found.values()
        return value, first, second


@dataclass(frozen=True)
class Extremes:
    """Places (n,) and values (n,)."""

    place: Array
    value: Array


def apart(one: Cut, other: Cut) -> tuple[Array, Array]:
    """From the second to the first (2, n), and how that changes with the arc lengths of both (2, 2, n)."""
    return one.points - other.points, np.stack([one.rate * one.tangents, -other.rate * other.tangents], axis=1)


def smooth_parts(curve: PitchCurve, low: Array, high: Array) -> tuple[Integers, Array, Array]:
    """Intervals (n,) of arc length cut at the joints of a curve: number of the interval, start and end of each part."""
    which, cuts = np.arange(len(low)), [(np.arange(len(low)), low)]
    for joint in curve.joints:
        ahead = np.mod(joint - low, curve.length)
        inside = np.flatnonzero((ahead > _NO_LENGTH * curve.length) & (ahead < high - low - _NO_LENGTH * curve.length))
        cuts.append((inside, low[inside] + ahead[inside]))
    which, starts = (np.concatenate(parts) for parts in zip(*cuts, strict=True))
    order = np.lexsort((starts, which))
    which, starts = which[order], starts[order]
    last = np.append(which[1:] != which[:-1], True)
    ends = np.where(last, high[which], np.append(starts[1:], 0.0))
    return which, starts, ends


def crossing(one: Array, other: Array) -> tuple[int, int] | None:
    """Numbers of the first chord of a line (2, n) that crosses another line, and of the first there that it crosses."""
    a, b = one[:, :-1, None], one[:, 1:, None]
    c, d = other[:, None, :-1], other[:, None, 1:]
    apart_ = (_turn(a, b, c) * _turn(a, b, d) < 0) & (_turn(c, d, a) * _turn(c, d, b) < 0)
    if not apart_.any():
        return None
    first = int(np.argmax(apart_.any(axis=1)))
    return first, int(np.argmax(apart_[first]))


def _turn(a: Array, b: Array, c: Array) -> Array:
    """Twice the area of the triangle from a over b to c."""
    found: Array = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return found
