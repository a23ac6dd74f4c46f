"""Rows of teeth in mesh: which flanks touch where, with what arcs and topping leave of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth.curve import POLAR
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.incomplete.gear import Row
from planter.gearing.teeth.incomplete.locking import Intermittent
from planter.gearing.teeth.meshing import Facing
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

SIDES = (-1.0, 1.0)
"""Sides of the driving gear's flanks: those that drive, those that hold back."""
_INSIDE = 1e-9
"""Share of a contact's length that rounding may take from its ends."""


@dataclass(frozen=True)
class RowMesh:
    """The teeth of a pair that dwells (`contacts.Meshing`); rolling lengths count from the first contact on."""

    own: Intermittent

    @property
    def pair(self) -> Pair:
        return self.own.rolling.pair

    @property
    def gears(self) -> tuple[Gear, Gear]:
        return self.own.gear.row, self.own.mate.row

    @property
    def pitch(self) -> float:
        return self.own.gear.rack.pitch

    def places(self, at: Array) -> tuple[Array, Array]:
        """Angle and axis (3, n) of both gears at rolling lengths (n,)."""
        return self.own.rolling.places(at)

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Arc lengths (n,) of both pitch curves where they touch at rolling lengths (n,)."""
        rolling = self.own.rolling
        return rolling.lead + at, rolling.behind + rolling.length - at

    def touching(self, at: Array, side: float) -> Flags:
        """Whether teeth of the gear touch with their flanks of a side at rolling lengths, (n, z)."""
        z = self.gears[0].z
        tooth = np.tile(np.arange(z), len(at))
        found: Flags = self._left(np.repeat(at, z), tooth, np.full(len(tooth), side)).reshape(-1, z)
        return found

    def facing(self, at: Array) -> Facing:
        """The flanks that touch at rolling lengths (n,), both sides."""
        which, where, tooth = np.nonzero(np.array([self.touching(at, side) for side in SIDES]))
        return self._facing(at[where], tooth, np.array(SIDES)[which])

    @cached_property
    def contact_ratios(self) -> Array:
        """Contact ratios (n,) of the pairs of flanks that the arcs leave whole, over all teeth and both sides."""
        z = self.gears[0].z
        tooth, side = np.tile(np.arange(z), 2), np.repeat(SIDES, z)
        faced = self._facing(np.zeros(2 * z), tooth, side)
        (tip, end), (mate_tip, mate_end) = (
            (np.abs(gear.flanks.tips[0] - gear.flanks.xi)[number],
             np.abs([path[0].lower for path in gear.paths] - gear.flanks.xi)[number])
            for gear, number in zip(self.gears, faced.numbers, strict=True)
        )  # fmt: skip
        above, below = np.minimum(tip, mate_end), np.minimum(mate_tip, end)
        meets = faced.xi[0] - self.own.rolling.lead
        inside = (1 - _INSIDE) * np.array([-above, below])
        begins, ends = meets + side * inside
        whole = self._left(begins, tooth, side) & self._left(ends, tooth, side)
        within = np.minimum(begins, ends) >= 0
        within &= np.maximum(begins, ends) <= self.own.rolling.length
        return np.asarray(((above + below) / self.pitch)[whole & within])

    def pressure_angles(self, at: Array) -> Array:
        """Of both sides of the teeth in the pitch point at rolling lengths, (2, n) [rad]."""
        gear = self.gears[0]
        place = gear.curve.at(self.arc_lengths(at)[0])[:POLAR]
        alpha = gear.rack.pressure_angle
        return np.array([RACK("pressure", place=place, side=np.full(len(at), side), alpha=alpha)["pressure"]
                         for side in SIDES])  # fmt: skip

    def _facing(self, at: Array, tooth: Integers, side: Array) -> Facing:
        """Teeth (n,) of the gear with their flanks of a side, and those of the mate."""
        one, two = self.gears
        later = (side > 0).astype(int)
        other = two.z - 1 - tooth - later
        xi = [gear.flanks.centre[number] + side * gear.rack.sizes["full"]
              for gear, number in ((one, tooth), (two, other))]  # fmt: skip
        numbers = tooth + one.z * later, other + two.z * later
        return Facing(at, side, numbers, np.array(xi), side * (self.arc_lengths(at)[0] - xi[0]))

    def _left(self, at: Array, tooth: Integers, side: Array) -> Flags:
        """Whether the points in which flanks of teeth (n,) would touch at rolling lengths (n,) are left on both."""
        faced = self._facing(at, tooth, side)
        rows = list(zip((self.own.gear.row, self.own.mate.row), self.arc_lengths(at), faced.numbers, strict=True))
        point, back = (row.flanks.flank(place, number).points.T for row, place, number in rows)
        there = np.all([_within(row, place, number) for row, place, number in rows], axis=0)
        untopped = np.all([region.beyond(point) >= 0 for region in self.own.topped], axis=0)
        found: Flags = there & untopped & (self.own.cut.beyond(back) >= 0)
        return found


def _within(row: Row, place: Array, number: Integers) -> Flags:
    """Whether flanks (n,) are cut at arc lengths (n,): between their tips and where they end."""
    tips, ends = row.flanks.tips[0][number], np.array([path[0].lower for path in row.paths])[number]
    return np.asarray((place >= np.minimum(tips, ends)) & (place <= np.maximum(tips, ends)))
