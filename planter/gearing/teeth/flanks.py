"""The flanks of a gear: where each meets its tip, and how far it is regular."""

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

    @cached_property
    def spaces(self) -> Array:
        """Middles of the tooth space beside each flank, along the pitch curve."""
        return self.centre + self.side * self.rack.pitch / 2

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

    def root(self, s: Array, which: Integers, towards: Array | None = None) -> Cut:
        """The line of the roots, which is the same for all flanks."""
        return self.equidistant(s, -self.rack.sizes["root"], towards)

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
            cut, line = self.flank(at[0], every), self.equidistant(at[1], height)
            slopes = np.stack([cut.rate * cut.tangents, -line.rate * line.tangents], axis=1)
            return cut.points - line.points, slopes

        start = np.array([self.xi - self.side * reach, self.xi])
        try:
            flank, tip = simultaneous.newton(gap, start, np.full(2, self.rack.module))
        except simultaneous.NotFoundError as error:
            raise GeometryError(
                f"a flank of tooth {self.tooth[error.index]} does not reach its tip, where the pitch curve is hollow: "
                f"the addendum must be less"
            ) from error
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

    def _least(self, start: Array, end: Array) -> Extremes:
        """Least rate of each flank, in parts of that of a rack, between two arc lengths, and where it is."""
        which, low, high = smooth_parts(self.curve, np.minimum(start, end), np.maximum(start, end))
        grid = low[:, None] + np.outer(high - low, np.linspace(0, 1, _CELLS + 1))
        middle = np.broadcast_to((low + high)[:, None] / 2, grid.shape).ravel()
        owner, places = np.repeat(which, _CELLS + 1), grid.ravel()
        slopes = self.regular(places, owner, middle)[1].reshape(grid.shape)
        part, cell = np.nonzero((slopes[:, :-1] < 0) & (slopes[:, 1:] > 0))
        if len(part):
            ends = slopes[part, cell], slopes[part, cell + 1]
            inside = roots.newton(
                lambda s: self.regular(s, which[part])[1:], grid[part, cell], grid[part, cell + 1], ends
            )
            owner, places = np.append(owner, which[part]), np.append(places, inside)
            middle = np.append(middle, inside)
        rates = self.regular(places, owner, middle)[0]
        order = np.lexsort((rates, owner))
        first = order[np.searchsorted(owner[order], np.arange(2 * self.z))]
        return Extremes(places[first], rates[first])

    def regular(self, s: Array, which: Integers, towards: Array | None = None) -> tuple[Array, Array, Array]:
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
