"""Incomplete gears with locking arcs for the dwell: phase of the teeth, arcs, and end teeth
truncated for the entry.

During the dwell a convex arc on the driving gear runs in a concave one on the driven gear, both
about the driving gear's axis. The concave arc is cut into the driven gear's teeth. The driving
gear's end teeth are truncated to the convex arc, and to the circle of the tips of the horns, with
which they would collide.

The phase is that with the smallest angle over which no tooth drives. The arcs remove driving flanks
next to the dwell. A flank that crosses the pitch curve at x from the dwell can drive while the
pitch point is sigma from it if the point of contact remains on both gears: below both tips; on the
driving gear inside the convex arc's circle, or after the horns have passed; on the driven gear, in
its position in the dwell, outside of the concave arc's. Flanks are a pitch apart; the part of sigma
that none covers is undriven.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.errors import GeometryError, InputError
from planter.gears.geometry.contacts import cross_product
from planter.gears.geometry.cutting import (
    MAX_TEETH,
    MIN_TEETH,
    ToothOrder,
    check_curve,
    check_gear,
    check_rack,
)
from planter.gears.geometry.flanks import Flanks, Rack
from planter.gears.geometry.gear import ROOT, TIP, Gear
from planter.gears.geometry.locking_arcs import Horn, Rolling, compute_arc_radius, compute_horn
from planter.gears.geometry.pieces import (
    Piece,
    Region,
    TrimmingCircle,
    build_arc,
    build_wall,
    start_outside,
    trim_line,
)
from planter.gears.geometry.pitch_curves import KAPPA, RACK, PitchCurve
from planter.kernels import Array, Flags
from planter.numerics.arrays import TURN

_PHASES = 96
"""Number of trial phases over a pitch."""
_PITCH_POINTS = 160
"""Positions of the pitch point that are tried at each end of the dwell."""
_FAR = 3
"""Range of these positions from the dwell, in pitches."""
_DRIVES = -1.0
"""Side of the driving gear's flanks that drive."""
AXIS = np.zeros(2)
_COUNT_ROUNDING = 1e-9
"""Share of a pitch by which rounding may change a tooth count."""


@dataclass(frozen=True)
class ToothPhase:
    """Teeth of the driving gear, and the distance of the first tooth's centre from the start of the
    rolling [m].

    `undriven` are the angles of the driving gear [rad] after the dwell and before it over which no
    tooth drives; `best_undriven` are those of the best phase of either end only. `horns` are those
    of both ends.
    """

    teeth: int
    first: float
    undriven: tuple[float, float]
    best_undriven: tuple[float, float]
    horns: tuple[Horn, Horn]


def find_best_phase(rolling: Rolling, rack: Rack, radius: float, clearance: float) -> ToothPhase:
    """Return the phase with the smallest undriven angle in total, for arcs of a radius and a
    clearance [m].

    Driven gears have their first and last space next to their horns. Raises GeometryError if no
    tooth fits.
    """
    ends = [_DwellEnd(rolling, rack, radius, clearance, end) for end in (0, 1)]
    after, before = (end.undriven for end in ends)
    number = np.arange(_PHASES)
    # flanks are a pitch apart, so that the phase at one end gives that at the other
    opposite = (round(rolling.length / rack.pitch * _PHASES) - number) % _PHASES
    # the sum: a phase that is best at one end can be worst at the other
    chosen = int(np.argmin(after + before[opposite]))
    centre = chosen / _PHASES * rack.pitch - _DRIVES * rack.sizes["full"]
    first = ends[0].margin + (centre - ends[0].margin) % rack.pitch
    teeth = int(
        np.floor((rolling.length - ends[1].margin - first) / rack.pitch + 1 + _COUNT_ROUNDING)
    )
    if teeth < 1:
        raise GeometryError(
            "no tooth fits between the locking arcs: reduce the dwell or the module"
        )
    return ToothPhase(
        teeth,
        float(first),
        (float(after[chosen]), float(before[opposite[chosen]])),
        (float(after.min()), float(before.min())),
        (ends[0].horn, ends[1].horn),
    )


class _DwellEnd:
    """An end of the rolling, 0 at its start, with its horn, and the circles of the arcs and of the
    horn's tips.
    """

    def __init__(
        self, rolling: Rolling, rack: Rack, radius: float, clearance: float, end: int
    ) -> None:
        self.rolling, self.rack, self.end, sizes = rolling, rack, end, rack.mate().sizes
        outer = radius + clearance
        self.horn = compute_horn(rolling, end, outer, sizes["tip"], sizes["root"])
        self._inside = TrimmingCircle(AXIS, radius, "topping", inside=False)
        reach = self.horn.tips + clearance
        self._gone_by = TrimmingCircle(rolling.driven_axis(end), reach, "topping")
        self._cut = TrimmingCircle(rolling.driving_axis, outer, "concave arc")

    @property
    def margin(self) -> float:
        """Smallest distance of the driving gear's first tooth centre from the end [m] for a solid
        horn.
        """
        return self.horn.solid + self.rack.pitch / 2

    @property
    def undriven(self) -> Array:
        """Angles (_PHASES,) [rad] over which no flank drives, by the places of flanks in parts of a
        pitch.

        Raises GeometryError if the horn leaves no such flanks.
        """
        pitch, run = (
            self.rack.pitch,
            self.rack.run(max(rack.sizes["tip"] for rack in (self.rack, self.rack.mate()))),
        )
        sigma, ahead = np.linspace(0, _FAR * pitch, _PITCH_POINTS), int(np.ceil(run / pitch))
        x = pitch * (np.arange(_PHASES * (2 * ahead + _FAR + 1)) / _PHASES - ahead)
        first = self.margin + self.rack.sizes["full"] * (_DRIVES if self.end == 0 else -_DRIVES)
        in_reach: Flags = np.logical_and(np.abs(x - sigma[:, None]) <= run, x >= first)
        if not in_reach.any():
            spare = (_FAR * pitch + run - first + self.horn.solid) / self.rack.module
            raise GeometryError(
                f"a horn of the locking arcs takes {self.horn.solid * 1e3:.4g} mm next to the "
                f"dwell, where a module of "
                f"{self.rack.module * 1e3:g} mm has no teeth that drive: it must be about "
                f"{self.horn.solid / spare * 1e3:.2g} mm or more"
            )
        row, column = np.nonzero(in_reach)
        drives = np.zeros_like(in_reach)
        drives[row, column] = self._remain_on_gears(sigma[row], x[column])
        undriven: Flags = np.logical_not(drives.reshape(len(sigma), -1, _PHASES).any(axis=1))
        last = len(sigma) - 1 - np.argmax(undriven[::-1], axis=0)
        turned = self.rolling.places(self._measure_from_end(sigma))[0][0]
        return np.where(undriven.any(axis=0), np.abs(turned - turned[0])[last], 0.0)

    def _remain_on_gears(self, sigma: Array, x: Array) -> Flags:
        """Return whether points of contact (n,) remain on both gears."""
        rolling, side = self.rolling, np.full(len(x), _DRIVES)
        gear, mate = (Flanks(curve, self.rack, 1, 0.0) for curve in rolling.pair.curves)
        at, place = self._measure_from_end(sigma), self._measure_from_end(x)
        seen = rolling.behind + rolling.length - at
        gear_points = gear.line(rolling.lead + at, rolling.lead + place, side).points.T
        mate_points = mate.line(seen, rolling.behind + rolling.length - place, side).points.T
        below_tips = (at - place <= _compute_reach(gear.curve, rolling.lead + at, self.rack)) & (
            place - at <= _compute_reach(mate.curve, seen, self.rack.mate())
        )
        untopped = (
            np.maximum(self._inside.beyond(gear_points), self._gone_by.beyond(gear_points)) >= 0
        )
        return below_tips & untopped & (self._cut.beyond(mate_points) >= 0)

    def _measure_from_end(self, distance: Array) -> Array:
        """Return rolling lengths (n,) [m] at distances (n,) [m] from the end."""
        return distance if self.end == 0 else self.rolling.length - distance


def _compute_reach(curve: PitchCurve, s: Array, rack: Rack) -> Array:
    """Return lengths (n,) [m] of a pitch curve on which teeth that touch at arc lengths (n,) are
    cut up to their " "tips.
    """
    kappa = np.maximum(curve.at(s)[KAPPA], 0.0)
    return RACK("reach", kappa=kappa, height=rack.sizes["tip"], alpha=rack.pressure_angle)["reach"]


_CLOSURE_TOLERANCE = 1e-9
"""Largest deviation of the driven gear from its initial position after a turn [rad]."""


@dataclass(frozen=True)
class IntermittentPair:
    """The driving and the driven gear, with the radius of the convex arc [m] and the clearance of
    the arcs [m].

    `cut` removes the concave arc from the driven gear's teeth; `truncations` removes from the
    driving gear's first and last teeth the parts that would meet the horns.
    """

    rolling: Rolling
    phase: ToothPhase
    gear: IncompleteGear
    mate: IncompleteGear
    radius: float
    arc_clearance: float
    cut: Region
    truncations: tuple[Region, Region]

    @property
    def gears(self) -> tuple[IncompleteGear, IncompleteGear]:
        return self.gear, self.mate


def build_intermittent_pair(
    rolling: Rolling, module: float, order: ToothOrder, name: str, gears: tuple[str, str]
) -> IntermittentPair:
    """Build gears with teeth of a module [m] on the toothed arc, which need not be an integer
    number of pitches long.

    The arcs have the radius of `compute_arc_radius` and a clearance of half the backlash; the phase
    of the teeth is that of `find_best_phase`. Raises InputError for too few teeth, GeometryError
    for a driven gear that does not turn once, for arcs that do not lock, and, with its position,
    for the first limit that the teeth violate.
    """
    if abs(rolling.turned - TURN) > _CLOSURE_TOLERANCE:
        raise GeometryError(
            f"{name}: {gears[1]} turns by {np.degrees(rolling.turned):.6g} deg over the teeth; it "
            f"must turn by "
            f"360 deg because it rests over the remaining turn"
        )
    pitches = rolling.length / (np.pi * module)
    if not MIN_TEETH <= pitches <= MAX_TEETH:
        raise InputError(
            f"{name}: {pitches:.4g} teeth: there must be {MIN_TEETH} to {MAX_TEETH} on a gear"
        )
    check_rack(order, module, name)
    rack = order.rack(module)
    radius, clearance = compute_arc_radius(rolling, rack.mate().sizes["tip"]), order.play / 2
    phase = find_best_phase(rolling, rack, radius, clearance)
    rows = _build_rows(rolling, rack, phase, gears)
    for row in rows:
        sizes = row.rack.sizes
        check_curve(row.curve, order, sizes["tip"], sizes["root"], row.name)
        check_gear(row, order)
    cut = Region((TrimmingCircle(rolling.driving_axis, radius + clearance, "concave arc"),))
    mate = _trim_driven_gear(rows[1], cut)
    first, last = (
        _find_truncation(rolling, mate, end, radius, rack.sizes["tip"], clearance) for end in (0, 1)
    )
    return IntermittentPair(
        rolling,
        phase,
        _trim_driving_gear(rows[0], rolling, radius, (first, last)),
        mate,
        radius,
        clearance,
        cut,
        (first, last),
    )


def _build_rows(
    rolling: Rolling, rack: Rack, phase: ToothPhase, names: tuple[str, str]
) -> tuple[IncompleteGear, IncompleteGear]:
    """Build the teeth of both gears; those of the driven gear lie in the spaces of the driving gear
    and at its ends.
    """
    last = rolling.length - phase.first - (phase.teeth - 0.5) * rack.pitch
    curves, lead, behind = rolling.pair.curves, rolling.lead, rolling.behind
    gear = Flanks(curves[0], rack, phase.teeth, lead + phase.first)
    mate = Flanks(curves[1], rack.mate(), phase.teeth + 1, behind + last)
    return (
        IncompleteGear(names[0], gear, lead, lead + rolling.length),
        IncompleteGear(names[1], mate, behind, behind + rolling.length, tipped=True),
    )


def _trim_driven_gear(row: IncompleteGear, cut: Region) -> IncompleteGear:
    line = row.outline()
    closing = build_wall(row.z - 1, line[-1].end, line[0].start)
    return replace(row, trimmed=tuple(trim_line(start_outside([*line, closing], cut), cut)))


def _trim_driving_gear(
    row: IncompleteGear, rolling: Rolling, radius: float, truncated: tuple[Region, Region]
) -> IncompleteGear:
    line = row.outline()
    for region in truncated:
        line = trim_line(line, region)
    arc = build_arc("convex arc", row.z - 1, AXIS, radius, rolling.over[1], rolling.dwell)
    down = build_wall(row.z - 1, line[-1].end, arc.start)
    up = build_wall(0, arc.end, line[0].start)
    return replace(row, trimmed=(*line, down, arc, up))


def _find_truncation(
    rolling: Rolling, mate: IncompleteGear, end: int, radius: float, tip: float, clearance: float
) -> Region:
    """Return the region that the driven gear's horn removes from the driving gear's end teeth."""
    axis, points = rolling.driving_axis, mate.points
    out = points - axis
    ahead = (axis[0] * out[:, 1] - axis[1] * out[:, 0]) * (1 if end else -1) > 0
    horn = points[ahead & (np.hypot(*out.T) < radius + 2 * tip)]
    if not len(horn):
        raise GeometryError(
            f"{mate.name}: the locking arc has no adjacent horn: it cannot lock the dwell"
        )
    # the tips of the horn sweep a circle about the driven axis
    reach = float(np.hypot(*horn.T).max()) + clearance
    return Region(
        (
            TrimmingCircle(rolling.driven_axis(end), reach, "topping"),
            TrimmingCircle(AXIS, radius, "topping", inside=False),
        )
    )


SAGITTA = 5e-4
"""Largest deviation of the chords of an outline, in modules."""
_SAMPLES = 17
"""Points of a piece at which its curvature is checked."""


@dataclass(frozen=True)
class IncompleteGear(Gear):
    """Teeth in a row along part of a pitch curve that does not close, between two of its arc
    lengths [m], and the pieces of the outline that is left of them, if they are trimmed.

    Beyond the row the outline is root or, if `tipped`, tip, which extends the first and the last
    tooth. Pieces, margins and top lands are those that the rack cuts.
    """

    low: float = 0.0
    high: float = 0.0
    tipped: bool = False
    trimmed: tuple[Piece, ...] = ()

    def _arrange(self, rows: Array) -> Array:
        """Return the rows of the teeth and of what the outline has beyond them."""
        inner, last = rows[:-1], 2 * self.z - 1
        if not self.tipped:
            before = [ROOT, -1, 0, 0, self.low, self.paths[0][-1].upper]
            after = [ROOT, -1, self.z - 1, 0, self.paths[last][-1].upper, self.high]
            return np.vstack([before, inner, after])
        tips = np.flatnonzero(inner[:, 0] == TIP)
        inner = inner[tips[0] : tips[-1] + 1].copy()
        inner[0, 4], inner[-1, 5] = self.low, self.high
        return inner

    def outline(self) -> list[Piece]:
        """Return the pieces of the outline in order."""
        return list(self.trimmed) or super().outline()

    @property
    def pitch_line(self) -> Piece:
        """The part of the pitch curve that rolls."""
        return self.curve.part(self.low, self.high)

    @cached_property
    def points(self) -> Array:
        """Vertices (n, 2) [m] of the outline, in its order."""
        vertices = (piece.at(_chord_shares(piece, self._sagitta)[:-1]) for piece in self.outline())
        return np.vstack(list(vertices))

    @cached_property
    def inside(self) -> Array:
        """Vertices (n, 2) [m] of an inscribed polygon: chords, and tangents on concave pieces."""
        return np.vstack([_inner_polygon(piece, self._sagitta) for piece in self.outline()])

    @property
    def _sagitta(self) -> float:
        """Distance of chords from the outline [m]."""
        return SAGITTA * self.rack.module

    @property
    def joins(self) -> float:
        """Largest gap between the end of a piece and the start of the next [m]."""
        ends = np.array([piece.end for piece in self.outline()])
        starts = np.array([piece.start for piece in self.outline()])
        return float(np.hypot(*(ends - np.roll(starts, -1, axis=0)).T).max())


def _chord_shares(piece: Piece, sagitta: float) -> Array:
    """Return the parameters (n + 1,) of chords of a piece within a deviation [m]."""
    shares = np.linspace(0, 1, _SAMPLES)
    length = float(np.hypot(*np.diff(piece.at(shares), axis=0).T).sum())
    chords = length * np.sqrt(float(np.abs(piece.curvature(shares)).max()) / (8 * sagitta))
    return np.linspace(0, 1, 1 + max(1, int(np.ceil(chords))))


def _inner_polygon(piece: Piece, sagitta: float) -> Array:
    """Return a piece without its end point as chords or, if concave, as tangents at the ends of the
    chords.
    """
    shares = _chord_shares(piece, sagitta)
    points, tangents, bends = piece.at(shares), piece.tangent(shares), piece.curvature(shares)
    concave = np.flatnonzero((bends[:-1] < 0) & (bends[1:] < 0))
    chord, start, end = (
        (points[1:] - points[:-1])[concave],
        tangents[concave],
        tangents[concave + 1],
    )
    reach = cross_product(chord.T, end.T) / cross_product(start.T, end.T)
    return np.insert(points[:-1], concave + 1, points[concave] + reach[:, None] * start, axis=0)
