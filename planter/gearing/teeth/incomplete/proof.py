"""What incomplete gears do over a turn: outlines laid over each other, where teeth drive, what the arcs let turn."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from planter.gearing.teeth.incomplete.gear import Row
from planter.gearing.teeth.incomplete.locking import Intermittent
from planter.gearing.teeth.polygons import Shapes, moved
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

POSITIONS = 720
"""Positions over the teeth, from the first contact of the pitch curves to the last, and as many over the dwell."""
_WINDOW = 0.45
"""Half the height of what is looked at about the line of centres, in parts of the centre distance."""
_SEEN = 1e-10
"""Area that outlines which touch may share before the arcs are said to hold [m2]."""
_FREE = np.radians(20)
"""How far the driven gear is turned at most, to see whether the arcs hold it."""
_HALVINGS = 24


@dataclass(frozen=True)
class Turn:
    """A turn of incomplete gears."""

    gears: Intermittent

    @cached_property
    def rolled(self) -> Array:
        """Rolling lengths of the positions, both ends included [m]."""
        return np.linspace(0, self.gears.rolling.length, POSITIONS)

    @cached_property
    def rolling(self) -> Array:
        """Areas that the outlines share at the positions over the teeth [m2]."""
        return self.overlaps(*self.gears.rolling.places(self.rolled))

    @cached_property
    def held(self) -> Array:
        """The same over the dwell."""
        return self.overlaps(*self.gears.rolling.held(np.linspace(0, 1, POSITIONS)))

    def overlaps(self, gear: Array, mate: Array) -> Array:
        """Areas (n,) that the outlines share where both gears are at angles and axes (3, n) [m2]."""
        one, two = (self._seen(k, where) for k, where in enumerate((gear, mate)))
        found, touch = np.zeros(len(one)), np.flatnonzero(shapely.intersects(one, two))
        found[touch] = shapely.area(shapely.intersection(one[touch], two[touch]))
        return found

    def _seen(self, k: int, where: Array) -> Shapes:
        """What of a gear is near the line of centres, in its places."""
        distance = self.gears.rolling.pair.distance
        high = _WINDOW * distance
        every = np.repeat(shapely.Polygon(self.gears.gears[k].points), where.shape[1])
        found: Shapes = shapely.clip_by_rect(moved(every, where), 0, -high, distance, high)
        return found

    @cached_property
    def drives(self) -> tuple[Flags, Flags]:
        """Whether teeth drive the mate at each position over the teeth, and whether they hold it back."""
        return self._touching(-1), self._touching(1)

    @cached_property
    def undriven(self) -> tuple[float, float]:
        """Angles [rad] of the gear from the dwell to where teeth drive at all positions, and from there to the dwell.

        Both are to be told: there neither teeth nor arcs hold the mate to its law.
        """
        lost = np.concatenate([[-1], np.flatnonzero(~self.drives[0]), [len(self.rolled)]])
        longest = int(np.argmax(np.diff(lost)))
        first, last = lost[longest] + 1, lost[longest + 1] - 1
        turned = -self.gears.rolling.places(self.rolled)[0][0]
        return float(turned[first] - turned[0]), float(turned[-1] - turned[last])

    def _touching(self, side: int) -> Flags:
        """Whether any tooth of the gear touches with its flank of a side at the positions (n,)."""
        own, z = self.gears, self.gears.gear.z
        row, other, rolling = own.gear.row, own.mate.row, own.rolling
        at, tooth = np.repeat(self.rolled, z), np.tile(np.arange(z), len(self.rolled))
        number = tooth + z * (side > 0)
        mate_tooth = z - tooth - (side > 0)
        mate = mate_tooth + other.z * (side > 0)
        place, seen = rolling.lead + at, rolling.behind + rolling.length - at
        point, back = row.flanks.flank(place, number).points.T, other.flanks.flank(seen, mate).points.T
        there = _within(row, place, number) & _within(other, seen, mate)
        left = np.all([region.beyond(point) >= 0 for region in own.topped], axis=0) & (own.cut.beyond(back) >= 0)
        found: Flags = (there & left).reshape(-1, z).any(axis=1)
        return found

    def slack(self, share: float) -> tuple[float, float]:
        """How far the driven gear can turn clockwise and anticlockwise at a share of the dwell [rad].

        At most 20 deg: then nothing holds it.
        """
        gear, mate = self.gears.rolling.held(np.array([share]))
        low, high = (self._until(gear, mate, sense) for sense in (-1, 1))
        return low, high

    def _until(self, gear: Array, mate: Array, sense: int) -> float:
        free, stopped = 0.0, _FREE
        for _ in range(_HALVINGS):
            tried = (free + stopped) / 2
            turned = mate + np.array([[sense * tried], [0.0], [0.0]])
            free, stopped = (free, tried) if self.overlaps(gear, turned)[0] > _SEEN else (tried, stopped)
        return stopped


def _within(row: Row, place: Array, number: Integers) -> Flags:
    """Whether flanks (n,) are cut at arc lengths (n,): between their tips and where they end."""
    tips, ends = row.flanks.tips[0][number], np.array([path[0].lower for path in row.paths])[number]
    return np.asarray((place >= np.minimum(tips, ends)) & (place <= np.maximum(tips, ends)))
