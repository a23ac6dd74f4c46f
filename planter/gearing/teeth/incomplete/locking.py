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
from planter.gearing.teeth.curve import PitchCurve, X, Y
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.incomplete.gear import IncompleteGear, Row
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gearing.teeth.incomplete.segments import Arc, PitchLine, Wall
from planter.gearing.teeth.incomplete.trimming import Circle, Region, opened, without
from planter.gearing.teeth.order import LEAST_TEETH, Order
from planter.kernels import Array
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
    gear: IncompleteGear
    mate: IncompleteGear
    radius: float
    apart: float
    cut: Region
    topped: tuple[Region, Region]

    @property
    def gears(self) -> tuple[IncompleteGear, IncompleteGear]:
        return self.gear, self.mate


def intermittent(rolling: Rolling, z: int, order: Order, name: str, gears: tuple[str, str]) -> Intermittent:
    """Gears with z whole teeth on the toothed arc, which begins and ends in spaces of the driving gear.

    The arcs lie at the larger of the pitch radii where its teeth end, so that horns hold on both sides; they stand
    apart by half the play. Raises InputError for too few teeth, GeometryError for a driven gear that does not turn
    once, and, with its place, for the first limit that the teeth break.
    """
    if abs(rolling.turned - TURN) > _CLOSED:
        raise GeometryError(
            f"{name}: {gears[1]} turns by {np.degrees(rolling.turned):.6g} deg over the teeth, which is not allowed: "
            f"it must be 360 deg"
        )
    if z < LEAST_TEETH:
        raise InputError(f"{name}: {z} teeth are not allowed: there must be at least {LEAST_TEETH} on a gear")
    module = rolling.length / (np.pi * z)
    limits.check_rack(order, module, name)
    rack = order.rack(module)
    curves = rolling.pair.curves
    rows = (
        Row(gears[0], Flanks(curves[0], rack, z, rolling.lead + rack.pitch / 2)),
        Row(gears[1], Flanks(curves[1], rack.mate(), z + 1, rolling.behind), halved=True),
    )
    for row in rows:
        sizes = row.rack.sizes
        limits.check_curve(row.curve, order, sizes["tip"], sizes["root"], row.name)
        limits.check_gear(row, order)
    radius, apart = max(rolling.ends), order.play / 2
    cut = Region((Circle(_driving_axis(rolling), radius + apart, "concave arc"),))
    mate = _driven(rows[1], rolling, cut)
    first, last = (_topping(rolling, mate, at, radius, rack.sizes["tip"], apart) for at in (0.0, rolling.length))
    return Intermittent(rolling, _driving(rows[0], rolling, radius, (first, last)), mate, radius, apart, cut,
                        (first, last))  # fmt: skip


def _driving_axis(rolling: Rolling) -> Array:
    """The driving gear's axis in the driven gear's frame in the dwell (2,) [m]."""
    return _beyond(rolling.pair.mate, rolling.behind, rolling.pair.distance)


def _beyond(curve: PitchCurve, at: float, distance: float) -> Array:
    """The other gear's axis in a gear's frame while it touches there: at a distance along the pitch point's radius."""
    place = curve.at(np.array([at]))[[X, Y], 0]
    return np.asarray(distance * place / np.hypot(*place))


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


def _topping(rolling: Rolling, mate: IncompleteGear, at: float, radius: float, tip: float, apart: float) -> Region:
    """What the driven gear's horn, beside the line of centres in the dwell, takes from the driving gear's end teeth."""
    axis, seen = _driving_axis(rolling), mate.points
    out = seen - axis
    ahead = (axis[0] * out[:, 1] - axis[1] * out[:, 0]) * (1 if at else -1) > 0
    horn = seen[ahead & (np.hypot(*out.T) < radius + 2 * tip)]
    if not len(horn):
        raise GeometryError(f"{mate.name}: the locking arc has no horn beside it: the dwell cannot be held")
    centre = _beyond(rolling.pair.gear, rolling.lead + at, rolling.pair.distance)
    reach = float(np.hypot(*horn.T).max()) + apart
    return Region((Circle(centre, reach, "topping"), Circle(AXIS, radius, "topping", inside=False)))
