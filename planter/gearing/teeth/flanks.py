"""Flanks of a gear: their intersections with the tips, and their margins against undercut."""

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
"""Cells of each smooth part in the search for extremes of a flank's rate."""
_NO_LENGTH = 1e-12
"""Share of a curve's length below which a part is empty."""


@dataclass(frozen=True)
class Flanks:
    """Both flanks of z teeth that a rack cuts on a curve, (2 z,) each: all that begin a tooth, then all that end one.

    Tooth 0 is centred at arc length `phase` [m]; `d` is the length of the pitch curve from a flank's crossing to
    where a point of it is cut, towards its root.
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
        """Arc lengths at which the flanks cross the pitch curve."""
        return self.centre + self.side * self.rack.sizes["half"]

    @cached_property
    def middle(self) -> Array:
        """Arc lengths of the centres of the rack's tip radius next to each flank, at which its fillet ends."""
        return self.centre + self.side * self.rack.sizes["beside"]

    @cached_property
    def spaces(self) -> Array:
        """Arc lengths of the middle of the tooth space next to each flank."""
        return self.centre + self.side * self.rack.pitch / 2

    def line(self, s: Array, xi: Array, side: Array, towards: Array | None = None) -> Cut:
        """Return the cuts at arc lengths s (n,) of straight rack flanks that cross the pitch line at xi (n,) [m]."""
        place = self.curve.at(s, towards)[:POLAR]
        return Cut.from_columns(RACK("flank", place=place, s=s, xi=xi, side=side, alpha=self.rack.pressure_angle))

    def flank(self, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return flanks (n,) by their numbers at arc lengths (n,) [m]."""
        return self.line(s, self.xi[index], self.side[index], towards)

    def fillet(self, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return fillets (n,) by their numbers at arc lengths (n,) [m]."""
        place, sizes = self.curve.at(s, towards)[:POLAR], self.rack.sizes
        return Cut.from_columns(
            RACK("fillet", place=place, s=s, middle=self.middle[index], depth=sizes["sunk"], rho=sizes["round_"])
        )

    def root(self, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return the root line at arc lengths (n,) [m], which is the same for all flanks."""
        return self.equidistant(s, -self.rack.sizes["root"], towards)

    def equidistant(self, s: Array, height: float, towards: Array | None = None) -> Cut:
        """Return the line at a height [m] over the pitch curve."""
        return Cut.from_columns(RACK("equidistant", place=self.curve.at(s, towards)[:POLAR], height=height))

    @cached_property
    def tips(self) -> tuple[Array, Array]:
        """Arc lengths (2 z,) of flank and tip line in their intersection."""
        height, index = self.rack.sizes["tip"], np.arange(2 * self.z)
        kappa = np.maximum(self.curve.at(self.xi)[KAPPA], 0.0)
        reach = RACK("reach", kappa=kappa, height=height, alpha=self.rack.pressure_angle)["reach"]

        def gap(at: Array) -> tuple[Array, Array]:
            cut, line = self.flank(at[0], index), self.equidistant(at[1], height)
            slopes = np.stack([cut.rate * cut.tangents, -line.rate * line.tangents], axis=1)
            return cut.points - line.points, slopes

        start = np.array([self.xi - self.side * reach, self.xi])
        try:
            flank, tip = simultaneous.newton(gap, start, np.full(2, self.rack.module))
        except simultaneous.NotFoundError as error:
            raise GeometryError(
                f"a flank of tooth {self.tooth[error.index]} does not reach its tip on a concave pitch curve: "
                f"reduce the addendum"
            ) from error
        return flank, tip

    @cached_property
    def straight_ends(self) -> Array:
        """Arc lengths where the rack's straight flank ends."""
        return self.xi + self.side * self.rack.run(self.rack.sizes["straight"])

    @cached_property
    def margins(self) -> Array:
        """Smallest rate of each flank from its crossing down to the rack's addendum, 1 on a rack; undercut below 0."""
        ends = self.xi + self.side * self.rack.run(self.rack.sizes["form"])
        return self._find_minima(self.xi, ends).value

    @cached_property
    def upper_margins(self) -> Array:
        """Smallest rate of each flank from its crossing up to its tip, which concave curves reduce."""
        return self._find_minima(self.tips[0], self.xi).value

    @cached_property
    def rate_minima(self) -> Extremes:
        """Minima of the rate of each flank down to the end of the rack's straight flank."""
        return self._find_minima(self.xi, self.straight_ends)

    def _find_minima(self, start: Array, end: Array) -> Extremes:
        """Return the minima of each flank's rate, relative to a rack, between two arc lengths (2 z,) [m]."""
        index, low, high = split_at_breakpoints(self.curve, np.minimum(start, end), np.maximum(start, end))
        grid = low[:, None] + np.outer(high - low, np.linspace(0, 1, _CELLS + 1))
        middle = np.broadcast_to((low + high)[:, None] / 2, grid.shape).ravel()
        owner, places = np.repeat(index, _CELLS + 1), grid.ravel()
        slopes = self.compute_rates(places, owner, middle)[1].reshape(grid.shape)
        part, cell = np.nonzero((slopes[:, :-1] < 0) & (slopes[:, 1:] > 0))
        if len(part):
            ends = slopes[part, cell], slopes[part, cell + 1]
            inside = roots.newton(
                lambda s: self.compute_rates(s, index[part])[1:], grid[part, cell], grid[part, cell + 1], ends
            )
            owner, places = np.append(owner, index[part]), np.append(places, inside)
            middle = np.append(middle, inside)
        rates = self.compute_rates(places, owner, middle)[0]
        order = np.lexsort((rates, owner))
        first = order[np.searchsorted(owner[order], np.arange(2 * self.z))]
        return Extremes(places[first], rates[first])

    def compute_rates(self, s: Array, index: Integers, towards: Array | None = None) -> tuple[Array, Array, Array]:
        """Return the rate of flanks relative to a rack, and its first two derivatives by arc length."""
        bends, alpha = self.curve.bends(s, towards), self.rack.pressure_angle
        columns = RACK("regularity", bends=bends, s=s, xi=self.xi[index], side=self.side[index], alpha=alpha)
        value, first, second = columns.values()
        return value, first, second


@dataclass(frozen=True)
class Extremes:
    """Arc lengths (n,) [m] and values (n,) of extremes."""

    place: Array
    value: Array


def split_at_breakpoints(curve: PitchCurve, low: Array, high: Array) -> tuple[Integers, Array, Array]:
    """Return intervals (n,) of arc length split at the breakpoints of a curve: interval number, start and end [m]."""
    index, cuts = np.arange(len(low)), [(np.arange(len(low)), low)]
    for joint in curve.joints:
        ahead = np.mod(joint - low, curve.length)
        inside = np.flatnonzero((ahead > _NO_LENGTH * curve.length) & (ahead < high - low - _NO_LENGTH * curve.length))
        cuts.append((inside, low[inside] + ahead[inside]))
    index, starts = (np.concatenate(parts) for parts in zip(*cuts, strict=True))
    order = np.lexsort((starts, index))
    index, starts = index[order], starts[order]
    last = np.append(index[1:] != index[:-1], True)
    ends = np.where(last, high[index], np.append(starts[1:], 0.0))
    return index, starts, ends
