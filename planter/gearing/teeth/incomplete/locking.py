"""Incomplete gears whose locking arcs hold them in the dwell: teeth, arcs, and end teeth topped for the entry.

While the driven gear is to stand still a convex arc on the driving gear runs in a concave one on the driven gear, both
about the driving gear's axis. The concave arc is cut into the driven gear's teeth. What of the driving gear's end teeth
would run into the horns beside it is topped: to the convex arc, and to the circle of the horns' tips.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.errors import GeometryError, InputError
from planter.gearing.teeth import limits
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.incomplete import phases
from planter.gearing.teeth.incomplete.arcs import radius_of
from planter.gearing.teeth.incomplete.gear import IncompleteGear, Row
from planter.gearing.teeth.incomplete.phases import Phase
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gearing.teeth.incomplete.segments import Arc, PitchLine, Wall
from planter.gearing.teeth.incomplete.trimming import Circle, Region, opened, without
from planter.gearing.teeth.order import LEAST_TEETH, MOST_TEETH, Order
from planter.gearing.teeth.rack import Rack
from planter.numerics.angles import TURN

AXIS = np.zeros(2)
_CLOSED = 1e-9
"""How far the driven gear may be from its first place after a turn [rad]."""


@dataclass(frozen=True)
class Intermittent:
    """The driving gear and the driven one, with the radius of the convex arc [m] and how far the arcs are apart [m].

    `cut` takes the concave arc out of the driven gear's teeth; `topped` takes from the driving gear's end teeth what
    the horns meet, where its teeth begin and where they end.
    """

    rolling: Rolling
    phase: Phase
    gear: IncompleteGear
    mate: IncompleteGear
    radius: float
    apart: float
    cut: Region
    topped: tuple[Region, Region]

    @property
    def gears(self) -> tuple[IncompleteGear, IncompleteGear]:
        return self.gear, self.mate


def intermittent(rolling: Rolling, module: float, order: Order, name: str, gears: tuple[str, str]) -> Intermittent:
    """Gears with teeth of a module [m] on the toothed arc, which need not be a whole number of pitches long.

    The arcs are of `arcs.radius_of` and stand apart by half the play; the teeth have the phase of `phases.best`. Raises
    InputError for too few teeth, GeometryError for a driven gear that does not turn once, for arcs that do not hold,
    and, with its place, for the first limit that the teeth break.
    """
    if abs(rolling.turned - TURN) > _CLOSED:
        raise GeometryError(
            f"{name}: {gears[1]} turns by {np.degrees(rolling.turned):.6g} deg over the teeth, which is not allowed: "
            f"it must be 360 deg, for over the rest of the turn it stands still"
        )
    pitches = rolling.length / (np.pi * module)
    if not LEAST_TEETH <= pitches <= MOST_TEETH:
        raise InputError(
            f"{name}: {pitches:.4g} teeth are not allowed: there must be {LEAST_TEETH} to {MOST_TEETH} on a gear"
        )
    limits.check_rack(order, module, name)
    rack = order.rack(module)
    radius, apart = radius_of(rolling, rack.mate().sizes["tip"]), order.play / 2
    phase = phases.best(rolling, rack, radius, apart)
    rows = _rows(rolling, rack, phase, gears)
    for row in rows:
        sizes = row.rack.sizes
        limits.check_curve(row.curve, order, sizes["tip"], sizes["root"], row.name)
        limits.check_gear(row, order)
    cut = Region((Circle(rolling.driving_axis, radius + apart, "concave arc"),))
    mate = _driven(rows[1], rolling, cut)
    first, last = (_topping(rolling, mate, end, radius, rack.sizes["tip"], apart) for end in (0, 1))
    return Intermittent(rolling, phase, _driving(rows[0], rolling, radius, (first, last)), mate, radius, apart, cut,
                        (first, last))  # fmt: skip


def _rows(rolling: Rolling, rack: Rack, phase: Phase, names: tuple[str, str]) -> tuple[Row, Row]:
    """Teeth of both gears: those of the driven gear stand in the spaces between the driving gear's and beside them."""
    own, other = ((start, start + rolling.length) for start in (rolling.lead, rolling.behind))
    last = rolling.length - phase.first - (phase.teeth - 0.5) * rack.pitch
    gear, mate = rolling.pair.curves
    return (
        Row(names[0], Flanks(gear, rack, phase.teeth, own[0] + phase.first), *own),
        Row(names[1], Flanks(mate, rack.mate(), phase.teeth + 1, other[0] + last), *other, tipped=True),
    )


def _driven(row: Row, rolling: Rolling, cut: Region) -> IncompleteGear:
    line = row.line()
    closing = Wall(row.z - 1, line[-1].at(np.ones(1))[0], line[0].at(np.zeros(1))[0])
    pieces = without(opened([*line, closing], cut), cut)
    return IncompleteGear(row, tuple(pieces), PitchLine(row.curve, rolling.behind, rolling.behind + rolling.length))


def _driving(row: Row, rolling: Rolling, radius: float, topped: tuple[Region, Region]) -> IncompleteGear:
    line = row.line()
    for region in topped:
        line = without(line, region)
    arc = Arc("convex arc", row.z - 1, AXIS, radius, rolling.over[1], rolling.dwell)
    down = Wall(row.z - 1, line[-1].at(np.ones(1))[0], arc.at(np.zeros(1))[0])
    up = Wall(0, arc.at(np.ones(1))[0], line[0].at(np.zeros(1))[0])
    return IncompleteGear(row, (*line, down, arc, up),
                          PitchLine(row.curve, rolling.lead, rolling.lead + rolling.length))  # fmt: skip


def _topping(rolling: Rolling, mate: IncompleteGear, end: int, radius: float, tip: float, apart: float) -> Region:
    """What the driven gear's horn, beside the line of centres in the dwell, takes from the driving gear's end teeth."""
    axis, seen = rolling.driving_axis, mate.points
    out = seen - axis
    ahead = (axis[0] * out[:, 1] - axis[1] * out[:, 0]) * (1 if end else -1) > 0
    horn = seen[ahead & (np.hypot(*out.T) < radius + 2 * tip)]
    if not len(horn):
        raise GeometryError(f"{mate.name}: the locking arc has no horn beside it: the dwell cannot be held")
    reach = float(np.hypot(*horn.T).max()) + apart
    return Region((Circle(rolling.driven_axis(end), reach, "topping"), Circle(AXIS, radius, "topping", inside=False)))
