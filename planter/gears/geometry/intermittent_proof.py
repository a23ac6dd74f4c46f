"""Proof of incomplete gears over a turn: rows of teeth in mesh, overlap of outlines, driving range,
loose motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.intermittent_gears import IntermittentPair
from planter.gears.geometry.mesh import (
    SIDES,
    FacingFlanks,
    Mesh,
    compute_pressure_angles,
    limit_arcs,
)
from planter.gears.geometry.polygons import Shapes, intersect_areas, move_shapes
from planter.kernels import Array, Flags, Integers

POSITIONS = 720
"""Positions over the teeth, from the first contact of the pitch curves to the last, and as many
over the dwell.
"""
_WINDOW = 0.45
"""Half the height of the window about the line of centres, as a share of the centre distance."""
_OVERLAP_TOLERANCE = 2.5e-5
"""Overlap of touching outlines from which the arcs count as locked, in modules squared."""
FREE_ANGLE = np.radians(20)
"""Largest trial rotation of the driven gear [rad]."""
_COARSE, _HALVINGS = 9, 10
"""Halvings of that angle for the first trial, and bisections afterwards."""
_LOOSE_SAMPLES = 13
"""Positions on either side of the dwell, and in it, at which the driven gear is rotated."""


@dataclass(frozen=True)
class LooseAngles:
    """Free rotation (n,) [rad] of the driven gear clockwise, behind its law, and anticlockwise,
    ahead of it.

    `at` are angles of the driving gear [rad] from the end of a dwell to the end of the next; `part`
    is 0 after the dwell while teeth do not limit both directions, 1 while they do, 2 before the
    dwell, 3 in it.
    """

    at: Array
    behind: Array
    ahead: Array
    part: Integers


@dataclass(frozen=True)
class IncompleteGearCycle:
    """A turn of incomplete gears."""

    gears: IntermittentPair

    @cached_property
    def rolled(self) -> Array:
        """Rolling lengths of the positions, both ends included [m]."""
        return np.linspace(0, self.gears.rolling.length, POSITIONS)

    @cached_property
    def rolling(self) -> Array:
        """Areas that the outlines share at the positions over the teeth [m2]."""
        return self.overlaps(*self.gears.rolling.places(self.rolled))

    @cached_property
    def dwell_overlaps(self) -> Array:
        """Areas that the outlines share at the positions over the dwell [m2]."""
        return self.overlaps(*self.gears.rolling.dwell_positions(np.linspace(0, 1, POSITIONS)))

    def overlaps(self, gear: Array, mate: Array) -> Array:
        """Return the overlap (n,) [m2] of the outlines with both gears at angles [rad] and axes [m]
        (3, n).
        """
        return intersect_areas(self._clip_gear(0, gear), self._clip_gear(1, mate))

    def _clip_gear(self, k: int, positions: Array) -> Shapes:
        """Return the parts of a gear near the line of centres, at angles [rad] and axes [m] (3,
        n).
        """
        distance = self.gears.rolling.pair.distance
        high = _WINDOW * distance
        outlines = np.repeat(shapely.Polygon(self.gears.gears[k].inside), positions.shape[1])
        return shapely.clip_by_rect(move_shapes(outlines, positions), 0, -high, distance, high)

    @cached_property
    def mesh(self) -> RowMesh:
        """The teeth in mesh."""
        return RowMesh.from_pair(self.gears)

    @cached_property
    def drives(self) -> tuple[Flags, Flags]:
        """Whether teeth drive the mate at each position over the teeth, and whether they brake
        it.
        """
        driven, holds = (self.mesh.touching(self.rolled, side).any(axis=1) for side in (-1, 1))
        return np.asarray(driven), np.asarray(holds)

    @cached_property
    def contacts(self) -> Contacts:
        """Contacts of the flanks that touch at the positions over the teeth."""
        return Contacts(self.mesh, self.mesh.facing(self.rolled))

    @property
    def undriven(self) -> tuple[float, float]:
        """Angles [rad] of the gear after the dwell and before it over which teeth do not drive
        throughout.
        """
        return self._find_lost_angles(self.drives[0])

    @property
    def unheld(self) -> tuple[float, float]:
        """Angles [rad] of the gear after the dwell and before it over which teeth do not brake
        throughout.
        """
        return self._find_lost_angles(self.drives[1])

    def _find_lost_angles(self, present: Flags) -> tuple[float, float]:
        """Return the angles [rad] from the dwell to the longest uninterrupted presence, and from
        its end to the " "dwell.
        """
        # the longest uninterrupted part counts: single gaps within it would be losses of contact
        lost = np.concatenate([[-1], np.flatnonzero(~present), [len(self.rolled)]])
        longest = int(np.argmax(np.diff(lost)))
        first, last = lost[longest] + 1, lost[longest + 1] - 1
        turned = -self.gears.rolling.places(self.rolled)[0][0]
        return float(turned[first] - turned[0]), float(turned[-1] - turned[last])

    @cached_property
    def loose(self) -> LooseAngles:
        """Loose motion of the driven gear over the whole turn."""
        rolling = self.gears.rolling
        after, before = np.maximum(self.undriven, self.unheld)
        first, last = rolling.over
        ends = np.array([first, first + after, last - before, last, last + rolling.dwell])
        turned, part = (
            np.linspace(ends[:-1], ends[1:], _LOOSE_SAMPLES, axis=1).ravel(),
            np.repeat(np.arange(4), _LOOSE_SAMPLES),
        )
        on_teeth = turned[part < 3]
        gear, mate = (
            np.hstack(parts)
            for parts in zip(
                rolling.places(rolling.rolled(on_teeth)),
                rolling.dwell_positions((turned[part == 3] - last) / rolling.dwell),
                strict=True,
            )
        )
        return LooseAngles(
            turned,
            self.measure_loose_angle(gear, mate, -1),
            self.measure_loose_angle(gear, mate, 1),
            part,
        )

    def farther(self, distance: float) -> IncompleteGearCycle:
        """Return the cycle with the axes `distance` [m] farther apart."""
        rolling = self.gears.rolling
        pair = replace(rolling.pair, distance=rolling.pair.distance + distance)
        return IncompleteGearCycle(replace(self.gears, rolling=replace(rolling, pair=pair)))

    def measure_loose_angle(self, gear: Array, mate: Array, sense: int) -> Array:
        """Return the free rotation (n,) [rad] of the driven gear in one direction, both gears at
        angles and axes (3, n).

        A value of `FREE_ANGLE` means that nothing limits it.
        """
        distance, still = self.gears.rolling.pair.distance, np.zeros(gear.shape[1])
        seen = _OVERLAP_TOLERANCE * self.gears.gear.rack.module**2
        gear_shapes = self._clip_gear(0, gear)
        mate_shapes = move_shapes(
            self._clip_gear(1, mate), np.array([still, still - distance, still])
        )

        def blocked(turn: Array) -> Flags:
            return (
                intersect_areas(
                    gear_shapes,
                    move_shapes(mate_shapes, np.array([sense * turn, still + distance, still])),
                )
                > seen
            )

        low, high = still, still + FREE_ANGLE
        # upwards in doublings: beyond the first obstacle the outlines may part again
        for trial in FREE_ANGLE * 2.0 ** -np.arange(_COARSE, -1, -1):
            open_ = trial < high
            stops = blocked(still + trial) & open_
            low, high = np.where(open_ & ~stops, trial, low), np.where(stops, trial, high)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            stops = blocked(middle)
            low, high = np.where(stops, low, middle), np.where(stops, middle, high)
        return high


_END_TOLERANCE = 1e-9
"""Share of a contact's length by which its ends are moved inwards against rounding."""


@dataclass(frozen=True)
class RowMesh(Mesh):
    """The teeth of an intermittent pair in mesh; rolling lengths count from the first contact."""

    gears_pair: IntermittentPair

    @classmethod
    def from_pair(cls, pair: IntermittentPair) -> RowMesh:
        """Return the mesh of the rows of teeth."""
        return cls(pair.rolling.pair, pair.gear, pair.mate, pair)

    def places(self, at: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at rolling lengths (n,) [m]."""
        return self.gears_pair.rolling.places(at)

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Return arc lengths (n,) [m] of the contact on both pitch curves at rolling lengths (n,)
        [m].
        """
        rolling = self.gears_pair.rolling
        return rolling.lead + at, rolling.behind + rolling.length - at

    def touching(self, at: Array, side: float) -> Flags:
        """Return whether teeth of the gear touch with their flanks of a side at rolling lengths,
        (n, z).
        """
        z = self.gears[0].z
        tooth = np.tile(np.arange(z), len(at))
        return self._remain_on_gears(np.repeat(at, z), tooth, np.full(len(tooth), side)).reshape(
            -1, z
        )

    def facing(self, at: Array) -> FacingFlanks:
        """Return the flanks that touch at rolling lengths (n,), on both sides."""
        side_index, position, tooth = np.nonzero(
            np.array([self.touching(at, side) for side in SIDES])
        )
        return self._face(at[position], tooth, np.array(SIDES)[side_index])

    @cached_property
    def contact_ratios(self) -> Array:
        """Contact ratios (n,) of the pairs of flanks that the arcs leave complete, over all teeth
        and both sides.
        """
        z = self.gears[0].z
        tooth, side = np.tile(np.arange(z), 2), np.repeat(SIDES, z)
        faced = self._face(np.zeros(2 * z), tooth, side)
        above, below = limit_arcs(self.gears, faced)
        meets = faced.xi[0] - self.gears_pair.rolling.lead
        inside = (1 - _END_TOLERANCE) * np.array([-above, below])
        # slightly inside its ends, where rounding could take a contact off its flank
        begins, ends = meets + side * inside
        complete = self._remain_on_gears(begins, tooth, side) & self._remain_on_gears(
            ends, tooth, side
        )
        inside_range = np.minimum(begins, ends) >= 0
        inside_range &= np.maximum(begins, ends) <= self.gears_pair.rolling.length
        return ((above + below) / self.pitch)[complete & inside_range]

    def pressure_angles(self, at: Array) -> Array:
        """Return pressure angles (2, n) [rad] of both sides of the teeth in the pitch point at
        rolling lengths (n,).
        """
        gear = self.gears[0]
        arcs = self.arc_lengths(at)[0]
        return compute_pressure_angles(gear.curve, arcs, gear.rack.pressure_angle)

    def _face(self, at: Array, tooth: Integers, side: Array) -> FacingFlanks:
        """Return teeth (n,) of the gear with their flanks of a side, and those of the mate."""
        gear, mate = self.gears
        later = (side > 0).astype(int)
        mate_tooth = mate.z - 1 - tooth - later
        xi = [
            gear.flanks.centre[number] + side * gear.rack.sizes["full"]
            for gear, number in ((gear, tooth), (mate, mate_tooth))
        ]
        numbers = tooth + gear.z * later, mate_tooth + mate.z * later
        return FacingFlanks(
            at, side, numbers, np.array(xi), side * (self.arc_lengths(at)[0] - xi[0])
        )

    def _remain_on_gears(self, at: Array, tooth: Integers, side: Array) -> Flags:
        """Return whether the contact points of flanks (n,) at rolling lengths (n,) remain on both
        gears.
        """
        faced = self._face(at, tooth, side)
        rows = list(zip(self.gears, self.arc_lengths(at), faced.numbers, strict=True))
        point, back = (row.flanks.flank(place, number).points.T for row, place, number in rows)
        present = np.all([_are_cut(row, place, number) for row, place, number in rows], axis=0)
        untopped = np.all(
            [region.beyond(point) >= 0 for region in self.gears_pair.truncations], axis=0
        )
        return present & untopped & (self.gears_pair.cut.beyond(back) >= 0)


def _are_cut(row: Gear, place: Array, number: Integers) -> Flags:
    """Return whether arc lengths (n,) lie between the tips and the ends of flanks (n,)."""
    tips, ends = row.flanks.tips[0][number], np.array([path[0].lower for path in row.paths])[number]
    return (place >= np.minimum(tips, ends)) & (place <= np.maximum(tips, ends))
