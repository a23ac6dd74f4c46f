"""Contacts of the flanks of two gears, solved from a displaced start, also at a larger centre
distance.

The solution uses only the points of the flanks, so that it verifies that they are conjugate.
Involutes of circles stay conjugate at any distance; flanks on other curves do not, so each contact
is solved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.gears.geometry.flanks import Cut
from planter.gears.geometry.mesh import FacingFlanks, Mesh
from planter.gears.geometry.pitch_curves import RACK
from planter.kernels import Array, Integers
from planter.numerics import roots
from planter.numerics.arrays import wrap_angle

_START_OFFSET = 0.02
"""Displacement of the start of the search from the pitch point, in pitches."""
_START_TURN = 1e-4
"""Rotation of the mate from its position at the start of the search [rad]."""
_MAX_STEPS = 0.25, 0.05
"""Longest steps of a search: along the pitch curves in pitches, and of the mate's turn [rad]."""


@dataclass(frozen=True)
class Contacts:
    """The contacts of flanks of a mesh that face each other (n,)."""

    mesh: Mesh
    faced: FacingFlanks

    @property
    def errors(self) -> Array:
        """Rotation (n,) [rad] of the mate from its position until flanks without backlash touch."""
        return self._touching[2]

    @property
    def points(self) -> Array:
        """Contact points (2, n) [m] of flanks without backlash, from the gear's axis, the line of
        centres along x.
        """
        return self.cut_flanks(self.faced.xi, self._touching[:2], self._touching[2])[0].points

    @property
    def sliding(self) -> Array:
        """Sliding speed (n,) of the flanks in their contacts per rotation rate of the gear [m].

        Seen from the gear its mate turns about the pitch point, with the rates of both together.
        """
        pair = self.mesh.pair
        radius = np.hypot(*pair.gear.at(self.mesh.arc_lengths(self.faced.at)[0])[:2])
        arm = self.points - np.array([radius, np.zeros_like(radius)])
        return np.hypot(*arm) * (1 + radius / (pair.distance - radius))

    @property
    def lost_motion(self) -> Array:
        """Rotation (p, 2) of the mate from the central position [rad] until a side of the teeth
        stops it, by SIDES.

        The p positions are the distinct `faced.at` in rising order; NaN where no flank of a side is
        in contact.
        """
        turns = self.solve(self.thinned, self._start)[2]
        # several flanks face each other at one position; the nearest of a side stops the mate
        position = np.unique(self.faced.at, return_inverse=True)[1]
        return find_smallest_turns(turns, position, self.faced.side)

    @property
    def gaps(self) -> Array:
        """Distance (n,) of flanks along their common normal, in the central position [m]; below 0
        they overlap.
        """
        still = np.zeros_like(self.faced.at)

        def system(at: Array) -> tuple[Array, Array]:
            gear_cut, mate_cut = self.cut_flanks(self.thinned, at, still)
            gap = mate_cut.points - gear_cut.points
            cosine, sine = (
                _dot(gear_cut.tangents, mate_cut.tangents),
                cross_product(gear_cut.tangents, mate_cut.tangents),
            )
            slopes = np.array(
                [
                    [
                        gear_cut.turning * cross_product(gear_cut.tangents, gap) - gear_cut.rate,
                        mate_cut.rate * cosine,
                    ],
                    [-gear_cut.turning * cosine, mate_cut.turning * cosine],
                ]
            )
            return np.array([_dot(gap, gear_cut.tangents), sine]), slopes

        # displaced, so that a solution at the pitch point is found and not assumed
        start = self._start[:2] + _START_OFFSET * self.mesh.pitch
        at = roots.solve_systems(system, start, np.full(2, _MAX_STEPS[0] * self.mesh.pitch))
        gear_cut, mate_cut = self.cut_flanks(self.thinned, at, still)
        return -cross_product(gear_cut.tangents, mate_cut.points - gear_cut.points)

    @property
    def _start(self) -> Array:
        """Arc lengths of both curves in the pitch point [m], and zero rotation (3, n)."""
        return np.array([*self.mesh.arc_lengths(self.faced.at), np.zeros_like(self.faced.at)])

    @property
    def thinned(self) -> Array:
        """Flanks (2, n) by their arc lengths [m], thinned by each gear's share of the backlash."""
        return self.faced.xi - self.faced.side * self.mesh.gears[0].rack.play / 4

    @cached_property
    def _touching(self) -> Array:
        """Arc lengths at both contacts and rotation of the mate (3, n) for flanks without
        backlash.
        """
        offset = _START_OFFSET * self.mesh.pitch
        return self.solve(
            self.faced.xi, self._start + np.array([[offset], [-2 * offset], [_START_TURN]])
        )

    def solve(self, xi: Array, start: Array) -> Array:
        """Return arc lengths at both contacts and rotation of the mate (3, n) for flanks at arc
        lengths (2, n) [m].
        """

        def system(at: Array) -> tuple[Array, Array]:
            return self.residuals(*self.cut_flanks(xi, at[:2], at[2]))

        step, turn = _MAX_STEPS[0] * self.mesh.pitch, _MAX_STEPS[1]
        return roots.solve_systems(system, start, np.array([step, step, turn]))

    def residuals(self, gear_cut: Cut, mate_cut: Cut) -> tuple[Array, Array]:
        """Return the residuals (3, n) of a contact, distance in x and y [m] and sine between the
        tangents, and the Jacobian.

        The Jacobian (3, 3, n) is by the arc lengths of both contacts and the rotation of the mate.
        """
        cosine = _dot(gear_cut.tangents, mate_cut.tangents)
        arm = mate_cut.points - np.array([[self.mesh.pair.distance], [0.0]])
        moved = np.array(
            [
                gear_cut.rate * gear_cut.tangents,
                -mate_cut.rate * mate_cut.tangents,
                [arm[1], -arm[0]],
            ]
        )
        bent = np.array([-gear_cut.turning * cosine, mate_cut.turning * cosine, cosine])
        slopes = np.concatenate([moved.swapaxes(0, 1), bent[None]])
        return np.vstack(
            [gear_cut.points - mate_cut.points, cross_product(gear_cut.tangents, mate_cut.tangents)]
        ), slopes

    def cut_flanks(self, xi: Array, at: Array, turned: Array) -> tuple[Cut, Cut]:
        """Return both flanks at arc lengths (2, n) [m] in the frame of the axes, the mate rotated
        by `turned` [rad].
        """
        positions = self.mesh.places(self.faced.at)
        positions[1][0] += turned
        gear_cut, mate_cut = (
            _move_cut(gear.flanks.line(at[k], xi[k], self.faced.side), positions[k])
            for k, gear in enumerate(self.mesh.gears)
        )
        return gear_cut, mate_cut


def find_smallest_turns(turns: Array, position: Integers, side: Array) -> Array:
    """Return the least size (p, 2) of turns (n,) by their position (n,) and by SIDES, NaN without a
    contact.
    """
    smallest = np.full((int(position.max()) + 1, 2), np.inf)
    np.minimum.at(smallest, (position, (side > 0).astype(int)), np.abs(turns))
    return np.where(np.isfinite(smallest), smallest, np.nan)


def _move_cut(cut: Cut, position: Array) -> Cut:
    px, py, ex, ey = RACK(
        "placed", own=np.vstack([cut.points, cut.tangents]), where=position
    ).values()
    return Cut(np.array([px, py]), np.array([ex, ey]), cut.rate, cut.turning)


def _dot(first: Array, second: Array) -> Array:
    return (first * second).sum(axis=0)


def cross_product(first: Array, second: Array) -> Array:
    """Return the cross product (...) of plane vectors (2, ...)."""
    return first[0] * second[1] - first[1] * second[0]


_DISTANCE_STEP = 0.1
"""Largest step of the centre distance in modules: contacts are followed from one distance to the
next.
"""
_MAX_CONTACT_STEPS = 0.25, 0.05, 0.5
"""Longest steps of a search: along a pitch curve in pitches, of the mate's turn [rad], of the
rolling length in pitches.
"""
S_GEAR, S_MATE, TURNED, AT = range(4)
"""Rows of a contact: arc lengths of both curves where its flanks are cut, turn of the mate [rad],
rolling length.
"""


@dataclass(frozen=True)
class WiderMesh:
    """Contacts (4, n) at which each pair of a mesh begins and ends, with flanks thinned by the
    backlash.

    The mesh has the larger centre distance.
    """

    mesh: Mesh
    first: Array
    last: Array

    @property
    def contact_ratios(self) -> Array:
        """Contact ratio (n,) of each pair."""
        return (self.last[AT] - self.first[AT]) / self.mesh.pitch

    @property
    def touches(self) -> bool:
        """Whether every pair touches, and the next one before it ends."""
        start, end = self.first[AT], self.last[AT]
        return bool((end > start).all() and (self.mesh.shared(start, end) >= 0).all())

    @property
    def lost_motion(self) -> Array:
        """Turn (p, 2) of the mate from the central position [rad] until each side stops it, at the
        mesh's positions.
        """
        mesh, period = self.mesh, self.mesh.period * self.mesh.pitch
        middle, half = (self.first[AT] + self.last[AT]) / 2, (self.last[AT] - self.first[AT]) / 2
        rolled = wrap_angle(mesh.positions - middle[:, None], period)
        pair, position = np.nonzero(np.abs(rolled) <= half[:, None])
        offset = rolled[pair, position]
        # between its two ends a contact moves almost evenly, which is near enough for a start
        share = (offset / half[pair] + 1) / 2
        faced = replace(mesh.pairs.select(pair), at=middle[pair] + offset)
        start = ((1 - share) * self.first[:, pair] + share * self.last[:, pair])[:AT]
        contacts = Contacts(mesh, faced)
        return find_smallest_turns(
            contacts.solve(contacts.thinned, start)[TURNED], position, faced.side
        )


def move_apart(mesh: Mesh, more: float) -> WiderMesh | None:
    """Return the teeth of a mesh with their axes `more` > 0 [m] farther apart, None if teeth lose
    contact.

    Teeth that lose contact at a smaller distance count as without contact at all larger ones.
    """
    steps = int(np.ceil(more / (_DISTANCE_STEP * mesh.gear.rack.module)))
    starts = None
    # step by step: the solution at one distance is the start at the next
    for further in more * np.arange(steps + 1) / steps:
        wider = replace(mesh, pair=replace(mesh.pair, distance=mesh.pair.distance + further))
        try:
            starts = _find_limits(wider, starts)
        except roots.UnsolvedSystemError:
            return None
        wider_mesh = _limit_contacts(wider, starts)
        if not wider_mesh.touches:
            return None
    return wider_mesh


def _limit_contacts(mesh: Mesh, limits: tuple[Array, ...]) -> WiderMesh:
    """Return the part of each pair's rolling length on which the flanks of both gears exist."""
    ends = np.reshape(limits, (2, 2, 4, -1))
    order = np.argsort(ends[:, :, AT], axis=1)[:, :, None]
    first, last = np.take_along_axis(ends, order, axis=1).swapaxes(0, 1)
    # both flanks must exist: the later beginning, and the earlier end
    begins, stops = np.argmax(first[:, AT], axis=0), np.argmin(last[:, AT], axis=0)
    pair = np.arange(ends.shape[-1])
    return WiderMesh(mesh, first[begins, :, pair].T, last[stops, :, pair].T)


def _find_limits(mesh: Mesh, starts: tuple[Array, ...] | None) -> tuple[Array, ...]:
    """Return the contacts (4, n) of all pairs at the tip and at the end of the gear's flank, then
    of the mate's.
    """
    pairs, contacts = mesh.pairs, list[Array]()
    flanks = Contacts(mesh, pairs).thinned
    for k in (0, 1):
        tip, end = (reach[pairs.numbers[k]] for reach in mesh.gears[k].reaches)
        for depth in (-tip, end):
            fixed = flanks[k] + pairs.side * depth
            at = mesh.pair.senses[k] * fixed
            # the first time from the pitch point
            rest = np.array([*mesh.arc_lengths(at), np.zeros_like(at), at])
            start = rest if starts is None else starts[len(contacts)]
            contacts.append(_solve_contacts(mesh, k, fixed, start))
    return tuple(contacts)


def _solve_contacts(mesh: Mesh, k: int, fixed: Array, start: Array) -> Array:
    """Return the contacts (4, n) of all pairs at arc lengths (n,) of gear k.

    Raises UnsolvedSystemError for the first pair without one.
    """
    unknown = [1 - k, TURNED, AT]

    def fill_rows(values: Array) -> Array:
        rows = np.empty((4, len(fixed)))
        rows[k], rows[unknown] = fixed, values
        return rows

    def system(values: Array) -> tuple[Array, Array]:
        rows = fill_rows(values)
        contacts = Contacts(mesh, replace(mesh.pairs, at=rows[AT]))
        gear_cut, mate_cut = contacts.cut_flanks(contacts.thinned, rows[:TURNED], rows[TURNED])
        residuals, slopes = contacts.residuals(gear_cut, mate_cut)
        rates = _rotation_rates(mesh, rows[AT])
        arm = mate_cut.points - np.array([[mesh.pair.distance], [0.0]])
        rolling = np.array(
            [
                -rates[0] * gear_cut.points[1] + rates[1] * arm[1],
                rates[0] * gear_cut.points[0] - rates[1] * arm[0],
                (rates[1] - rates[0]) * (gear_cut.tangents * mate_cut.tangents).sum(axis=0),
            ]
        )
        return residuals, np.stack([slopes[:, 1 - k], slopes[:, 2], rolling], axis=1)

    largest = np.array(
        [
            _MAX_CONTACT_STEPS[0] * mesh.pitch,
            _MAX_CONTACT_STEPS[1],
            _MAX_CONTACT_STEPS[2] * mesh.pitch,
        ]
    )
    return fill_rows(roots.solve_systems(system, start[unknown], largest))


def _rotation_rates(mesh: Mesh, at: Array) -> Array:
    """Return the rotation of both gears (2, n) per rolling length [rad/m] at rolling lengths
    (n,).
    """
    rates = []
    for curve, s, sense in zip(
        mesh.pair.curves, mesh.arc_lengths(at), mesh.pair.senses, strict=True
    ):
        x, y, tx, ty = curve.at(s)[:4]
        rates.append(-sense * (x * ty - y * tx) / (x**2 + y**2))
    return np.array(rates)
