"""Where flanks of two gears touch: same point, same normal, solved from a start that is astray.

The contact of two flanks takes nothing from how they were made but their points: that they are conjugate shows in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import Facing
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.rack import RACK, Cut
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.arrays import Integers

_ASTRAY = 0.02
"""How far from the pitch point, in pitches, the search for a contact starts, so that it has to find it."""
_TURNED = 1e-4
"""And how far the mate is turned from where it belongs [rad]."""
_STEPS = 0.25, 0.05
"""Longest steps of a search: along the pitch curves in pitches, and of the mate's turn [rad]."""


class Meshing(Protocol):
    """Two gears in mesh, as `Mesh`."""

    @property
    def pair(self) -> Pair: ...

    @property
    def gears(self) -> tuple[Gear, Gear]: ...

    @property
    def pitch(self) -> float: ...

    def places(self, at: Array) -> tuple[Array, Array]:
        """Angle and axis (3, n) of both gears at rolling lengths (n,)."""

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Arc lengths (n,) of both pitch curves where they touch at rolling lengths (n,)."""


@dataclass(frozen=True)
class Contacts:
    """The contacts of flanks of a mesh that face each other (n,)."""

    mesh: Meshing
    faced: Facing

    @property
    def errors(self) -> Array:
        """How far the mate (n,) turns from where it belongs [rad] until flanks without play touch."""
        return self._touching[2]

    @property
    def points(self) -> Array:
        """Where flanks without play touch (2, n) [m], from the gear's axis, the line of centres along x."""
        return self.both(self.faced.xi, self._touching[:2], self._touching[2])[0].points

    @property
    def sliding(self) -> Array:
        """Speed (n,) with which flanks slide in their contacts per rotation rate of the gear [m].

        Seen from the gear its mate turns about the pitch point, with the rates of both together.
        """
        pair = self.mesh.pair
        radius = np.hypot(*pair.gear.at(self.mesh.arc_lengths(self.faced.at)[0])[:2])
        arm = self.points - np.array([radius, np.zeros_like(radius)])
        return np.asarray(np.hypot(*arm) * (1 + radius / (pair.distance - radius)))

    @property
    def lost_motion(self) -> Array:
        """Turn (p, 2) of the mate from the central position [rad] until a side of the teeth stops it, by SIDES.

        The p positions are the distinct `faced.at` in rising order; NaN where no flank of a side is in contact.
        """
        turns = self.turned(self.thinned, self._start)[2]
        position = np.unique(self.faced.at, return_inverse=True)[1]
        return least_turns(turns, position, self.faced.side)

    @property
    def gaps(self) -> Array:
        """Distance (n,) of flanks along their common normal, in the central position [m]; below 0 they overlap."""
        still = np.zeros_like(self.faced.at)

        def system(at: Array) -> tuple[Array, Array]:
            one, two = self.both(self.thinned, at, still)
            apart = two.points - one.points
            along, turned = _dot(one.tangents, two.tangents), _cross(one.tangents, two.tangents)
            slopes = np.array([
                [one.turning * _cross(one.tangents, apart) - one.rate, two.rate * along],
                [-one.turning * along, two.turning * along],
            ])  # fmt: skip
            return np.array([_dot(apart, one.tangents), turned]), slopes

        start = self._start[:2] + _ASTRAY * self.mesh.pitch
        at = simultaneous.newton(system, start, np.full(2, _STEPS[0] * self.mesh.pitch))
        one, two = self.both(self.thinned, at, still)
        return -_cross(one.tangents, two.points - one.points)

    @property
    def _start(self) -> Array:
        """Arc lengths of both curves in the pitch point, and no turn (3, n)."""
        return np.array([*self.mesh.arc_lengths(self.faced.at), np.zeros_like(self.faced.at)])

    @property
    def thinned(self) -> Array:
        """Places of flanks (2, n) with the play that each gear has its share of."""
        return np.asarray(self.faced.xi - self.faced.side * self.mesh.gears[0].rack.play / 4)

    @cached_property
    def _touching(self) -> Array:
        """Arc lengths at both contacts and the turn of the mate (3, n) with which flanks without play touch."""
        aside = _ASTRAY * self.mesh.pitch
        return self.turned(self.faced.xi, self._start + np.array([[aside], [-2 * aside], [_TURNED]]))

    def turned(self, xi: Array, start: Array) -> Array:
        """Arc lengths at both contacts and the turn of the mate (3, n) with which flanks at places (2, n) touch."""

        def system(at: Array) -> tuple[Array, Array]:
            return self.residuals(*self.both(xi, at[:2], at[2]))

        along, turn = _STEPS[0] * self.mesh.pitch, _STEPS[1]
        return simultaneous.newton(system, start, np.array([along, along, turn]))

    def residuals(self, one: Cut, two: Cut) -> tuple[Array, Array]:
        """Return what vanishes where flanks touch (3, n): distance in x and y [m], sine of the angle of the tangents.

        And its slopes (3, 3, n) by the arc lengths of both contacts and the turn of the mate.
        """
        along = _dot(one.tangents, two.tangents)
        arm = two.points - np.array([[self.mesh.pair.distance], [0.0]])
        moved = np.array([one.rate * one.tangents, -two.rate * two.tangents, [arm[1], -arm[0]]])
        bent = np.array([-one.turning * along, two.turning * along, along])
        slopes = np.concatenate([moved.swapaxes(0, 1), bent[None]])
        return np.vstack([one.points - two.points, _cross(one.tangents, two.tangents)]), slopes

    def both(self, xi: Array, at: Array, turned: Array) -> tuple[Cut, Cut]:
        """Points of flanks at arc lengths (2, n) of both curves, in the frame of the axes, the mate turned further."""
        where = self.mesh.places(self.faced.at)
        where[1][0] += turned
        one, two = (
            _placed(gear.flanks.line(at[k], xi[k], self.faced.side), where[k]) for k, gear in enumerate(self.mesh.gears)
        )
        return one, two


def least_turns(turns: Array, position: Integers, side: Array) -> Array:
    """Return the least size (p, 2) of turns (n,) by their position (n,) and by SIDES, NaN where there is none."""
    found = np.full((int(position.max()) + 1, 2), np.inf)
    np.minimum.at(found, (position, (side > 0).astype(int)), np.abs(turns))
    return np.where(np.isfinite(found), found, np.nan)


def _placed(cut: Cut, where: Array) -> Cut:
    px, py, ex, ey = RACK("placed", own=np.vstack([cut.points, cut.tangents]), where=where).values()
    return Cut(np.array([px, py]), np.array([ex, ey]), cut.rate, cut.turning)


def _dot(one: Array, other: Array) -> Array:
    return np.asarray((one * other).sum(axis=0))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[0] * other[1] - one[1] * other[0])
