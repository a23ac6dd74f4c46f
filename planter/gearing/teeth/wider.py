"""Meshes with a larger centre distance than that of cutting: length of contact of each pair, and lost motion.

Involutes of circles stay conjugate at any distance; flanks on other curves do not, so each contact is solved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planter.gearing.teeth.contacts import Contacts, find_smallest_turns
from planter.gearing.teeth.meshing import FacingFlanks, Mesh
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.angles import wrapped
from planter.numerics.arrays import Integers

_DISTANCE_STEP = 0.1
"""Largest step of the centre distance in modules: contacts are followed from one distance to the next."""
_MAX_STEPS = 0.25, 0.05, 0.5
"""Longest steps of a search: along a pitch curve in pitches, of the mate's turn [rad], of the rolling length in
pitches."""
S_GEAR, S_MATE, TURNED, AT = range(4)
"""Rows of a contact: arc lengths of both curves where its flanks are cut, turn of the mate [rad], rolling length."""


@dataclass(frozen=True)
class WiderMesh:
    """Contacts (4, n) at which each pair of a mesh begins and ends, with flanks thinned by the backlash.

    The mesh has the larger centre distance.
    """

    mesh: Mesh
    first: Array
    last: Array

    @property
    def contact_ratios(self) -> Array:
        """Contact ratio (n,) of each pair."""
        return np.asarray((self.last[AT] - self.first[AT]) / self.mesh.pitch)

    @property
    def touches(self) -> bool:
        """Whether every pair touches, and the next one before it ends."""
        start, end = self.first[AT], self.last[AT]
        return bool((end > start).all() and (self.mesh.shared(start, end) >= 0).all())

    @property
    def lost_motion(self) -> Array:
        """Turn (p, 2) of the mate from the central position [rad] until each side stops it, at the mesh's positions."""
        mesh, period = self.mesh, self.mesh.period * self.mesh.pitch
        middle, half = (self.first[AT] + self.last[AT]) / 2, (self.last[AT] - self.first[AT]) / 2
        rolled = wrapped(mesh.positions - middle[:, None], period)
        pair, position = np.nonzero(np.abs(rolled) <= half[:, None])
        offset = rolled[pair, position]
        share = (offset / half[pair] + 1) / 2
        faced = _select_pairs(mesh.pairs, middle[pair] + offset, pair)
        start = ((1 - share) * self.first[:, pair] + share * self.last[:, pair])[:AT]
        contacts = Contacts(mesh, faced)
        return find_smallest_turns(contacts.solve(contacts.thinned, start)[TURNED], position, faced.side)


def move_apart(mesh: Mesh, more: float) -> WiderMesh | None:
    """Return the teeth of a mesh with their axes `more` > 0 [m] farther apart, None if teeth lose contact.

    Teeth that lose contact at a smaller distance count as without contact at all larger ones.
    """
    steps = int(np.ceil(more / (_DISTANCE_STEP * mesh.gear.rack.module)))
    starts = None
    for further in more * np.arange(steps + 1) / steps:
        wider = replace(mesh, pair=replace(mesh.pair, distance=mesh.pair.distance + further))
        try:
            starts = _find_limits(wider, starts)
        except simultaneous.NotFoundError:
            return None
        wider_mesh = _limit_contacts(wider, starts)
        if not wider_mesh.touches:
            return None
    return wider_mesh


def _limit_contacts(mesh: Mesh, limits: tuple[Array, ...]) -> WiderMesh:
    """Return the part of each pair's rolling length on which the flanks of both gears exist."""
    (low, high), (other_low, other_high) = (
        (np.where(first[AT] < second[AT], first, second), np.where(first[AT] < second[AT], second, first))
        for first, second in (limits[:2], limits[2:])
    )
    first = np.where(low[AT] > other_low[AT], low, other_low)
    last = np.where(high[AT] < other_high[AT], high, other_high)
    return WiderMesh(mesh, first, last)


def _find_limits(mesh: Mesh, starts: tuple[Array, ...] | None) -> tuple[Array, ...]:
    """Return the contacts (4, n) of all pairs at the tip and at the end of the gear's flank, then of the mate's."""
    pairs, contacts = mesh.pairs, list[Array]()
    flanks = Contacts(mesh, pairs).thinned
    for k in (0, 1):
        tip, end = (reach[pairs.numbers[k]] for reach in mesh.reaches[k])
        for depth in (-tip, end):
            fixed = flanks[k] + pairs.side * depth
            start = _start_at_pitch_point(mesh, k, fixed) if starts is None else starts[len(contacts)]
            contacts.append(_solve_contacts(mesh, k, fixed, start))
    return tuple(contacts)


def _start_at_pitch_point(mesh: Mesh, k: int, fixed: Array) -> Array:
    """Return contacts (4, n) of all pairs in the pitch point, at arc lengths (n,) of one of the gears."""
    at = mesh.pair.senses[k] * fixed
    gear_arc, mate_arc = mesh.arc_lengths(at)
    return np.array([gear_arc, mate_arc, np.zeros_like(at), at])


def _solve_contacts(mesh: Mesh, k: int, fixed: Array, start: Array) -> Array:
    """Return the contacts (4, n) of all pairs at arc lengths (n,) of gear k.

    Raises NotFoundError for the first pair without one.
    """
    unknown = [1 - k, TURNED, AT]

    def fill_rows(values: Array) -> Array:
        rows = np.empty((4, len(fixed)))
        rows[k], rows[unknown] = fixed, values
        return rows

    def system(values: Array) -> tuple[Array, Array]:
        rows = fill_rows(values)
        contacts = Contacts(mesh, _select_pairs(mesh.pairs, rows[AT], np.arange(len(fixed))))
        gear_cut, mate_cut = contacts.cut_flanks(contacts.thinned, rows[:TURNED], rows[TURNED])
        residuals, slopes = contacts.residuals(gear_cut, mate_cut)
        rates = _rotation_rates(mesh, rows[AT])
        arm = mate_cut.points - np.array([[mesh.pair.distance], [0.0]])
        rolling = np.array([
            -rates[0] * gear_cut.points[1] + rates[1] * arm[1],
            rates[0] * gear_cut.points[0] - rates[1] * arm[0],
            (rates[1] - rates[0]) * (gear_cut.tangents * mate_cut.tangents).sum(axis=0),
        ])  # fmt: skip
        return residuals, np.stack([slopes[:, 1 - k], slopes[:, 2], rolling], axis=1)

    largest = np.array([_MAX_STEPS[0] * mesh.pitch, _MAX_STEPS[1], _MAX_STEPS[2] * mesh.pitch])
    return fill_rows(simultaneous.newton(system, start[unknown], largest))


def _rotation_rates(mesh: Mesh, at: Array) -> Array:
    """Return the rotation of both gears (2, n) per rolling length [rad/m] at rolling lengths (n,)."""
    rates = []
    for curve, s, sense in zip(mesh.pair.curves, mesh.arc_lengths(at), mesh.pair.senses, strict=True):
        x, y, tx, ty = curve.at(s)[:4]
        rates.append(-sense * (x * ty - y * tx) / (x**2 + y**2))
    return np.array(rates)


def _select_pairs(pairs: FacingFlanks, at: Array, index: Integers) -> FacingFlanks:
    """Return some of the pairs, by number, at rolling lengths (n,)."""
    gear_numbers, mate_numbers = pairs.numbers
    return FacingFlanks(
        at, pairs.side[index], (gear_numbers[index], mate_numbers[index]), pairs.xi[:, index], np.full_like(at, np.nan)
    )
