"""Pitch curves that roll on each other over part of a turn, and rest over the remaining part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.curve import POLAR, PitchCurve, X, Y
from planter.gearing.teeth.pair import CurvePair
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.numerics.chebyshev import Panels

EXTENSION = 0.75
"""Extension of the pitch curves beyond both ends [rad], on which parts of the end teeth are cut."""


@dataclass(frozen=True)
class Rolling:
    """Pitch curves that roll over angles `over` of the driving gear [rad]; then the driven gear rests.

    `pair` are the curves with their extensions; `lead` and `behind` are the lengths [m] of the extension that comes
    first on the gear and on its mate, `length` is the rolling length.
    """

    pair: CurvePair
    over: tuple[float, float]
    lead: float
    behind: float
    length: float

    @classmethod
    def from_radius(
        cls, radius: Callable[[Array], Array], over: tuple[float, float], joints: Array, distance: float
    ) -> Rolling:
        """Return the rolling of pitch radii (n,) [m] of a gear at its polar angles (n,) [rad], smooth between joints.

        Beyond its ends the radius is extrapolated by its value, slope and second derivative.
        """
        first, last = over
        inner = np.unique(np.concatenate([[first, last], joints[(joints > first) & (joints < last)]]))
        panels = Panels.of(lambda t: radius(t)[None], inner)
        rows = panels, panels.slope, panels.slope.slope

        def radii(t: Array) -> Array:
            clamped = np.clip(t, first, last)
            past = t - clamped
            r, dr, ddr = (part(clamped)[0] for part in rows)
            return np.array([r + dr * past + ddr * past**2 / 2, dr + ddr * past, ddr])

        def ratios(t: Array) -> Array:
            r, dr, _ = radii(t)
            return np.array(list(RACK("rolling", r=r, dr=dr, a=distance).values()))

        breaks = np.concatenate([[first - EXTENSION], inner, [last + EXTENSION]])
        turned = Panels.of(lambda t: ratios(t)[:1], breaks).integral

        def contact(t: Array) -> Array:
            return np.vstack([radii(t), ratios(t), turned(t)])

        def gear(t: Array) -> tuple[Array, Array]:
            return np.vstack([t, radii(t)]), np.ones_like(t)

        def mate(t: Array) -> tuple[Array, Array]:
            columns = contact(t)
            return np.array(list(RACK("mate", contact=columns, a=distance).values())), columns[3]

        curves = PitchCurve.from_trace(gear, breaks, 1), PitchCurve.from_trace(mate, breaks, -1)
        lead, end = curves[0].arc_within(np.array(over)).tolist()
        return cls(CurvePair(*curves, distance), over, lead, curves[1].length - end, end - lead)

    def rolled(self, turned: Array) -> Array:
        """Return rolling lengths (n,) [m] from the first contact at angles of the driving gear (n,) [rad] within "
        "`over`."""
        return self.pair.gear.arc_within(turned) - self.lead

    def places(self, at: Array) -> tuple[Array, Array]:
        """Return angle [rad] and axis [m] (3, n) of both gears at rolling lengths (n,) [m] from the first contact."""
        gear = self.pair.gear.at(self.lead + at)[POLAR]
        mate = self.pair.mate.at(self.behind + self.length - at)[POLAR]
        zero = np.zeros_like(at)
        return np.array([-gear, zero, zero]), np.array([np.pi - mate, np.full_like(at, self.pair.distance), zero])

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

    @property
    def distance(self) -> float:
        """Distance of the axes [m]."""
        return self.pair.distance

    def place_near_end(self, end: int, at: float) -> Array:
        """Return the mate's pitch curve (5, 1), in the form of `rack_teeth`, at a distance [m] from an end."""
        return self.pair.mate.at(np.array([self.behind + (at if end else self.length - at)]))[:POLAR]

    def driven_axis(self, end: int) -> Array:
        """Return the mate's axis in the gear's frame (2,) [m] at the end 0 or 1 of the rolling."""
        return _project_axis(self.pair.gear, self.lead + end * self.length, self.pair.distance)


def _project_axis(curve: PitchCurve, at: float, distance: float) -> Array:
    """Return the other gear's axis (2,) [m] in a gear's frame, at a distance along the pitch point's radius."""
    place = curve.at(np.array([at]))[[X, Y], 0]
    return np.asarray(distance * place / np.hypot(*place))
