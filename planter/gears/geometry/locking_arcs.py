"""Pitch curves that roll over part of a turn and then rest, and the arcs and horns that lock them
in the dwell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.gears.geometry.pitch_curves import (
    POLAR,
    RACK,
    CurvePair,
    PitchCurve,
    X,
    Y,
    build_contact,
    place_gears,
    trace_pair,
)
from planter.kernels import Array, formulas
from planter.numerics.arrays import TURN
from planter.numerics.piecewise import ChebyshevPanels

ARCS = formulas.load("locking_arcs")
FRICTION = 0.2
"""Coefficient of friction against which the arcs must lock: dry steel on steel."""
NO_HORN = "the driven gear has no horn next to the dwell that would lock in the arcs"
_SAMPLES = 65
"""Points of a line next to the dwell in the search for a horn's edge."""
_SEARCH_ANGLE = np.radians(60)
"""Range of this search, as an angle of the driving gear [rad]."""
_EDGE_SAMPLES = 9
"""Points next to a horn's edge at which the tips are checked."""


def compute_arc_radius(rolling: Rolling, addendum: float) -> float:
    """Return the radius [m] of arcs that lock the driven gear, with an addendum [m], in both
    directions.

    It is the smaller pitch radius of the driving gear at the ends of its teeth or, if a horn would
    not lock there, the smallest radius at which both do. Raises GeometryError without such a
    radius.
    """
    return max(
        min(rolling.ends), *(_OffsetLine(rolling, end, addendum).min_radius for end in (0, 1))
    )


@dataclass(frozen=True)
class Horn:
    """A horn of the driven gear next to the concave arc, after the dwell or before it.

    `reach` is its angle at the driving axis [rad], `tips` its largest distance from the driven axis
    [m], `solid` the rolling length from the end of the dwell up to which it must have no space in
    order to lock [m].
    """

    reach: float
    tips: float
    solid: float


def compute_horn(
    rolling: Rolling, end: int, radius: float, addendum: float, dedendum: float
) -> Horn:
    """Return the horn of arcs of a radius at the end 0 or 1 of the rolling.

    Raises GeometryError without a horn.

    Its spaces do not matter if the material under them locks.
    """
    tips, roots = (_OffsetLine(rolling, end, height) for height in (addendum, -dedendum))
    # beyond the edge a tip may reach farther from the axis than at it
    at = tips.edge(radius)
    distances = [tips.seen(at + step)[1] for step in np.linspace(0, addendum, _EDGE_SAMPLES)]
    return Horn(tips.reach(radius), max(distances), 0.0 if roots.holds(radius) else tips.holding)


def compute_horn_reaches(rolling: Rolling, radius: float, addendum: float) -> tuple[float, float]:
    """Return the angles [rad] of the horns at the driving axis, after and before the dwell.

    Raises GeometryError.
    """
    first, last = (_OffsetLine(rolling, end, addendum).reach(radius) for end in (0, 1))
    return first, last


@dataclass(frozen=True)
class _OffsetLine:
    """The line at a height over the driven gear's pitch curve [m] in the dwell, from an end on."""

    rolling: Rolling
    end: int
    height: float

    @property
    def min_radius(self) -> float:
        """Smallest radius of arcs up to the line that lock against friction [m]."""
        return self.seen(self.holding)[0]

    @cached_property
    def holding(self) -> float:
        """Rolling length from the end [m] at which an arc of that radius reaches the line."""
        return self._find_crossing(lambda at: self._spare(*self.seen(at)))

    def edge(self, radius: float) -> float:
        """Return the rolling length [m] at which an arc reaches the line.

        Raises GeometryError if it never does.
        """
        if self.seen(0.0)[0] > radius:
            raise GeometryError(NO_HORN)
        return self._find_crossing(lambda at: self.seen(at)[0] - radius)

    def reach(self, radius: float) -> float:
        """Return the angle at the driving axis from the line of centres to that edge [rad]."""
        tips = self.seen(self.edge(radius))[1]
        return ARCS.at("horn", distance=self.rolling.pair.distance, radius=radius, tips=tips)[
            "reach"
        ]

    def holds(self, radius: float) -> bool:
        """Return whether arcs of a radius up to the line lock."""
        if self.seen(0.0)[0] >= radius:
            return False
        return self._spare(radius, self.seen(self.edge(radius))[1]) >= 0

    def seen(self, at: float) -> tuple[float, float]:
        """Return the distances [m] of a point, `at` [m] from the end, from the driving axis and the
        driven axis.
        """
        columns = RACK(
            "equidistant", place=self.rolling.place_near_end(self.end, at), height=self.height
        )
        point = np.array([columns["px"][0], columns["py"][0]])
        return float(np.hypot(*(point - self.rolling.driving_axis))), float(np.hypot(*point))

    def _spare(self, radius: float, tips: float) -> float:
        """Return the excess [m] of a radius over the smallest that locks an edge at a distance from
        the driven axis.
        """
        return (
            radius
            - ARCS.at("least", distance=self.rolling.pair.distance, tips=tips, friction=FRICTION)[
                "radius"
            ]
        )

    def _find_crossing(self, spare: Callable[[float], float]) -> float:
        """Return the first rolling length [m] from the end at which `spare` is not negative.

        Raises GeometryError.
        """
        trials = np.linspace(
            0, min(_SEARCH_ANGLE * self.rolling.ends[self.end], self.rolling.length / 2), _SAMPLES
        )
        if spare(0.0) >= 0:
            return 0.0
        for low, high in pairwise(trials.tolist()):
            if spare(high) >= 0:
                return float(scipy.optimize.brentq(spare, low, high, xtol=1e-16))
        raise GeometryError(NO_HORN)


EXTENSION = 0.75
"""Extension of the pitch curves beyond both ends [rad], on which parts of the end teeth are cut."""


@dataclass(frozen=True)
class Rolling:
    """Pitch curves that roll over angles `over` of the driving gear [rad]; then the driven gear
    rests.

    `pair` are the curves with their extensions; `lead` and `behind` are the lengths [m] of the
    extension that comes first on the gear and on its mate, `length` is the rolling length.
    """

    pair: CurvePair
    over: tuple[float, float]
    lead: float
    behind: float
    length: float

    @classmethod
    def from_radius(
        cls,
        radius: Callable[[Array], Array],
        over: tuple[float, float],
        joints: Array,
        distance: float,
    ) -> Rolling:
        """Return the rolling of pitch radii (n,) [m] of a gear at its polar angles (n,) [rad],
        smooth between joints.

        Beyond its ends the radius is extrapolated by its value, slope and second derivative.
        """
        first, last = over
        inner = np.unique(
            np.concatenate([[first, last], joints[(joints > first) & (joints < last)]])
        )
        panels = ChebyshevPanels.fit(lambda t: radius(t)[None], inner)
        rows = panels, panels.slope, panels.slope.slope

        def radii(t: Array) -> Array:
            # end teeth are cut on parts of the curve beyond its ends, which must be smooth there
            clamped = np.clip(t, first, last)
            past = t - clamped
            r, dr, ddr = (part(clamped)[0] for part in rows)
            return np.array([r + dr * past + ddr * past**2 / 2, dr + ddr * past, ddr])

        breaks = np.concatenate([[first - EXTENSION], inner, [last + EXTENSION]])
        gear, mate = trace_pair(build_contact(radii, distance, breaks), distance)
        curves = PitchCurve.from_trace(gear, breaks, 1), PitchCurve.from_trace(mate, breaks, -1)
        lead, end = curves[0].arc_within(np.array(over)).tolist()
        return cls(CurvePair(*curves, distance), over, lead, curves[1].length - end, end - lead)

    def rolled(self, turned: Array) -> Array:
        """Return rolling lengths (n,) [m] from the first contact at angles of the driving gear (n,)
        [rad] within " "`over`.
        """
        return self.pair.gear.arc_within(turned) - self.lead

    def places(self, at: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at rolling lengths (n,) [m] from the
        first contact.
        """
        gear = self.pair.gear.at(self.lead + at)[POLAR]
        mate = self.pair.mate.at(self.behind + self.length - at)[POLAR]
        return place_gears(gear, mate, self.pair.distance)

    def dwell_positions(self, share: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at shares (n,) of the dwell."""
        mate = self.places(np.array([self.length]))[1]
        turned = self.over[1] + share * self.dwell
        zero = np.zeros_like(share)
        return np.array([-turned, zero, zero]), np.tile(mate, len(share))

    @property
    def dwell(self) -> float:
        """Angle of the gear over which its mate rests [rad]."""
        return TURN - (self.over[1] - self.over[0])

    @property
    def turned(self) -> float:
        """Rotation of the mate over the teeth [rad]."""
        before, after = self.places(np.array([0.0, self.length]))[1][0]
        return float(after - before)

    @property
    def ends(self) -> tuple[float, float]:
        """Pitch radii of the gear where its teeth begin and end [m]."""
        first, last = np.hypot(*self.pair.gear.at(self.lead + np.array([0.0, self.length]))[[X, Y]])
        return float(first), float(last)

    @property
    def driving_axis(self) -> Array:
        """The gear's axis in its mate's frame in the dwell (2,) [m]."""
        return _project_axis(self.pair.mate, self.behind, self.pair.distance)

    def place_near_end(self, end: int, at: float) -> Array:
        """Return the mate's pitch curve (5, 1), in the form of `rack_teeth`, at a distance [m] from
        an end.
        """
        return self.pair.mate.at(np.array([self.behind + (at if end else self.length - at)]))[
            :POLAR
        ]

    def driven_axis(self, end: int) -> Array:
        """Return the mate's axis in the gear's frame (2,) [m] at the end 0 or 1 of the rolling."""
        return _project_axis(self.pair.gear, self.lead + end * self.length, self.pair.distance)


def _project_axis(curve: PitchCurve, at: float, distance: float) -> Array:
    """Return the other gear's axis (2,) [m] in a gear's frame, at a distance along the pitch
    point's radius.
    """
    place = curve.at(np.array([at]))[[X, Y], 0]
    return distance * place / np.hypot(*place)
