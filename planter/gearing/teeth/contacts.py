"""Contacts of the flanks of two gears: common point and normal, solved from a displaced start.

The solution uses only the points of the flanks, so that it verifies that they are conjugate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import FacingFlanks
from planter.gearing.teeth.pair import CurvePair
from planter.gearing.teeth.rack import RACK, Cut
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.arrays import Integers

_START_OFFSET = 0.02
"""Displacement of the start of the search from the pitch point, in pitches."""
_START_TURN = 1e-4
"""Rotation of the mate from its position at the start of the search [rad]."""
_MAX_STEPS = 0.25, 0.05
"""Longest steps of a search: along the pitch curves in pitches, and of the mate's turn [rad]."""


class FlankMeshing(Protocol):
    """Protocol of two gears in mesh (`Mesh`, `RowMesh`)."""

    @property
    def pair(self) -> CurvePair: ...

    @property
    def gears(self) -> tuple[Gear, Gear]: ...

    @property
    def pitch(self) -> float: ...

    def places(self, at: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at rolling lengths (n,) [m]."""

    def arc_lengths(self, at: Array) -> tuple[Array, Array]:
        """Return arc lengths (n,) [m] of the contact on both pitch curves at rolling lengths (n,) [m]."""


@dataclass(frozen=True)
class Contacts:
    """The contacts of flanks of a mesh that face each other (n,)."""

    mesh: FlankMeshing
    faced: FacingFlanks

    @property
    def errors(self) -> Array:
        """Rotation (n,) [rad] of the mate from its position until flanks without backlash touch."""
        return self._touching[2]

    @property
    def points(self) -> Array:
        """Contact points (2, n) [m] of flanks without backlash, from the gear's axis, the line of centres along x."""
        return self.cut_flanks(self.faced.xi, self._touching[:2], self._touching[2])[0].points

    @property
    def sliding(self) -> Array:
        """Sliding speed (n,) of the flanks in their contacts per rotation rate of the gear [m].

        Seen from the gear its mate turns about the pitch point, with the rates of both together.
        """
        pair = self.mesh.pair
        radius = np.hypot(*pair.gear.at(self.mesh.arc_lengths(self.faced.at)[0])[:2])
        arm = self.points - np.array([radius, np.zeros_like(radius)])
        return np.asarray(np.hypot(*arm) * (1 + radius / (pair.distance - radius)))

    @property
    def lost_motion(self) -> Array:
        """Rotation (p, 2) of the mate from the central position [rad] until a side of the teeth stops it, by SIDES.

        The p positions are the distinct `faced.at` in rising order; NaN where no flank of a side is in contact.
        """
        turns = self.solve(self.thinned, self._start)[2]
        position = np.unique(self.faced.at, return_inverse=True)[1]
        return find_smallest_turns(turns, position, self.faced.side)

    @property
    def gaps(self) -> Array:
        """Distance (n,) of flanks along their common normal, in the central position [m]; below 0 they overlap."""
        still = np.zeros_like(self.faced.at)

        def system(at: Array) -> tuple[Array, Array]:
            gear_cut, mate_cut = self.cut_flanks(self.thinned, at, still)
            gap = mate_cut.points - gear_cut.points
            cosine, sine = _dot(gear_cut.tangents, mate_cut.tangents), _cross(gear_cut.tangents, mate_cut.tangents)
            slopes = np.array([
                [gear_cut.turning * _cross(gear_cut.tangents, gap) - gear_cut.rate, mate_cut.rate * cosine],
                [-gear_cut.turning * cosine, mate_cut.turning * cosine],
            ])  # fmt: skip
            return np.array([_dot(gap, gear_cut.tangents), sine]), slopes

        start = self._start[:2] + _START_OFFSET * self.mesh.pitch
        at = simultaneous.newton(system, start, np.full(2, _MAX_STEPS[0] * self.mesh.pitch))
        gear_cut, mate_cut = self.cut_flanks(self.thinned, at, still)
        return -_cross(gear_cut.tangents, mate_cut.points - gear_cut.points)

    @property
    def _start(self) -> Array:
        """Arc lengths of both curves in the pitch point [m], and zero rotation (3, n)."""
        return np.array([*self.mesh.arc_lengths(self.faced.at), np.zeros_like(self.faced.at)])

    @property
    def thinned(self) -> Array:
        """Flanks (2, n) by their arc lengths [m], thinned by each gear's share of the backlash."""
        return np.asarray(self.faced.xi - self.faced.side * self.mesh.gears[0].rack.play / 4)

    @cached_property
    def _touching(self) -> Array:
        """Arc lengths at both contacts and rotation of the mate (3, n) for flanks without backlash."""
        offset = _START_OFFSET * self.mesh.pitch
        return self.solve(self.faced.xi, self._start + np.array([[offset], [-2 * offset], [_START_TURN]]))

    def solve(self, xi: Array, start: Array) -> Array:
        """Return arc lengths at both contacts and rotation of the mate (3, n) for flanks at arc lengths (2, n) [m]."""

        def system(at: Array) -> tuple[Array, Array]:
            return self.residuals(*self.cut_flanks(xi, at[:2], at[2]))

        step, turn = _MAX_STEPS[0] * self.mesh.pitch, _MAX_STEPS[1]
        return simultaneous.newton(system, start, np.array([step, step, turn]))

    def residuals(self, gear_cut: Cut, mate_cut: Cut) -> tuple[Array, Array]:
        """Return the residuals (3, n) of a contact, distance in x and y [m] and sine between the tangents, and the
        Jacobian.

        The Jacobian (3, 3, n) is by the arc lengths of both contacts and the rotation of the mate.
        """
        cosine = _dot(gear_cut.tangents, mate_cut.tangents)
        arm = mate_cut.points - np.array([[self.mesh.pair.distance], [0.0]])
        moved = np.array([gear_cut.rate * gear_cut.tangents, -mate_cut.rate * mate_cut.tangents, [arm[1], -arm[0]]])
        bent = np.array([-gear_cut.turning * cosine, mate_cut.turning * cosine, cosine])
        slopes = np.concatenate([moved.swapaxes(0, 1), bent[None]])
        return np.vstack([gear_cut.points - mate_cut.points, _cross(gear_cut.tangents, mate_cut.tangents)]), slopes

    def cut_flanks(self, xi: Array, at: Array, turned: Array) -> tuple[Cut, Cut]:
        """Return both flanks at arc lengths (2, n) [m] in the frame of the axes, the mate rotated by `turned` [rad]."""
        positions = self.mesh.places(self.faced.at)
        positions[1][0] += turned
        gear_cut, mate_cut = (
            _move_cut(gear.flanks.line(at[k], xi[k], self.faced.side), positions[k])
            for k, gear in enumerate(self.mesh.gears)
        )
        return gear_cut, mate_cut


def find_smallest_turns(turns: Array, position: Integers, side: Array) -> Array:
    """Return the least size (p, 2) of turns (n,) by their position (n,) and by SIDES, NaN without a contact."""
    smallest = np.full((int(position.max()) + 1, 2), np.inf)
    np.minimum.at(smallest, (position, (side > 0).astype(int)), np.abs(turns))
    return np.where(np.isfinite(smallest), smallest, np.nan)


def _move_cut(cut: Cut, position: Array) -> Cut:
    px, py, ex, ey = RACK("placed", own=np.vstack([cut.points, cut.tangents]), where=position).values()
    return Cut(np.array([px, py]), np.array([ex, ey]), cut.rate, cut.turning)


def _dot(first: Array, second: Array) -> Array:
    return np.asarray((first * second).sum(axis=0))


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[0] * second[1] - first[1] * second[0])
