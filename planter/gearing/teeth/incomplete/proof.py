"""What incomplete gears do over a turn: outlines laid over each other, where teeth drive, what the arcs let turn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from planter.gearing.teeth.contacts import Contacts
from planter.gearing.teeth.incomplete.locking import Intermittent
from planter.gearing.teeth.incomplete.rows import RowMesh
from planter.gearing.teeth.polygons import Shapes, moved
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

POSITIONS = 720
"""Positions over the teeth, from the first contact of the pitch curves to the last, and as many over the dwell."""
_WINDOW = 0.45
"""Half the height of what is looked at about the line of centres, in parts of the centre distance."""
_SEEN = 2.5e-5
"""Area that outlines which touch may share before the arcs are said to hold, in modules squared."""
FREE = np.radians(20)
"""How far the driven gear is turned at most, to see whether the arcs hold it."""
_COARSE, _HALVINGS = 9, 10
"""How often that angle is halved before it is tried, and how often what is left between then."""
_LOOSE = 13
"""Positions beside the dwell on either side, and in it, at which the driven gear is turned."""


@dataclass(frozen=True)
class Loose:
    """How far the driven gear can turn [rad] clockwise, behind its law, and anticlockwise, ahead of it (n,).

    `at` are angles of the driving gear, from where the dwell ends to where the next one does; `part` is 0 after the
    dwell, where teeth do not hold it both ways yet, 1 where they do, 2 before the dwell, 3 in it.
    """

    at: Array
    behind: Array
    ahead: Array
    part: Integers


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
        return _shared(self._seen(0, gear), self._seen(1, mate))

    def _seen(self, k: int, where: Array) -> Shapes:
        """What of a gear is near the line of centres, in its places."""
        distance = self.gears.rolling.pair.distance
        high = _WINDOW * distance
        every = np.repeat(shapely.Polygon(self.gears.gears[k].inside), where.shape[1])
        found: Shapes = shapely.clip_by_rect(moved(every, where), 0, -high, distance, high)
        return found

    @cached_property
    def mesh(self) -> RowMesh:
        """The teeth in mesh."""
        return RowMesh(self.gears)

    @cached_property
    def drives(self) -> tuple[Flags, Flags]:
        """Whether teeth drive the mate at each position over the teeth, and whether they hold it back."""
        driven, held = (self.mesh.touching(self.rolled, side).any(axis=1) for side in (-1, 1))
        return np.asarray(driven), np.asarray(held)

    @cached_property
    def contacts(self) -> Contacts:
        """Of the flanks that touch at the positions over the teeth."""
        return Contacts(self.mesh, self.mesh.facing(self.rolled))

    @property
    def undriven(self) -> tuple[float, float]:
        """Angles [rad] of the gear after the dwell and before it over which teeth do not drive all the time."""
        return self._lost(self.drives[0])

    @property
    def unheld(self) -> tuple[float, float]:
        """Angles [rad] of the gear after the dwell and before it over which teeth do not hold back all the time."""
        return self._lost(self.drives[1])

    def _lost(self, there: Flags) -> tuple[float, float]:
        """Angles from the dwell to where something is there at all positions, and from there to the dwell."""
        lost = np.concatenate([[-1], np.flatnonzero(~there), [len(self.rolled)]])
        longest = int(np.argmax(np.diff(lost)))
        first, last = lost[longest] + 1, lost[longest + 1] - 1
        turned = -self.gears.rolling.places(self.rolled)[0][0]
        return float(turned[first] - turned[0]), float(turned[-1] - turned[last])

    @cached_property
    def loose(self) -> Loose:
        """What the driven gear can turn by all round the turn: where teeth hold it both ways and where not."""
        rolling = self.gears.rolling
        after, before = np.maximum(self.undriven, self.unheld)
        first, last = rolling.over
        ends = np.array([first, first + after, last - before, last, last + rolling.dwell])
        turned, part = np.linspace(ends[:-1], ends[1:], _LOOSE, axis=1).ravel(), np.repeat(np.arange(4), _LOOSE)
        on_teeth = turned[part < 3]
        own, mate = (
            np.hstack(where)
            for where in zip(
                rolling.places(rolling.rolled(on_teeth)),
                rolling.held((turned[part == 3] - last) / rolling.dwell), strict=True,
            )
        )  # fmt: skip
        return Loose(turned, self.free(own, mate, -1), self.free(own, mate, 1), part)

    def farther(self, more: float) -> Turn:
        """The same gears with their axes that much [m] farther apart."""
        rolling = self.gears.rolling
        pair = replace(rolling.pair, distance=rolling.pair.distance + more)
        return Turn(replace(self.gears, rolling=replace(rolling, pair=pair)))

    def free(self, gear: Array, mate: Array, sense: int) -> Array:
        """How far the driven gear can turn one way (n,) where both gears are at angles and axes (3, n) [rad].

        At most 20 deg: then nothing holds it.
        """
        distance, still = self.gears.rolling.pair.distance, np.zeros(gear.shape[1])
        seen = _SEEN * self.gears.gear.rack.module**2
        one = self._seen(0, gear)
        two = moved(self._seen(1, mate), np.array([still, still - distance, still]))

        def blocked(turn: Array) -> Flags:
            found: Flags = _shared(one, moved(two, np.array([sense * turn, still + distance, still]))) > seen
            return found

        low, high = still, still + FREE
        for tried in FREE * 2.0 ** -np.arange(_COARSE, -1, -1):
            open_ = tried < high
            stops = blocked(still + tried) & open_
            low, high = np.where(open_ & ~stops, tried, low), np.where(stops, tried, high)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            stops = blocked(middle)
            low, high = np.where(stops, low, middle), np.where(stops, middle, high)
        return high


def _shared(one: Shapes, two: Shapes) -> Array:
    """Areas (n,) that shapes share [m2]."""
    found, touch = np.zeros(len(one)), np.flatnonzero(shapely.intersects(one, two))
    found[touch] = shapely.area(shapely.intersection(one[touch], two[touch]))
    return found
