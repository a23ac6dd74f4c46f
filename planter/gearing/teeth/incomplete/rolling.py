"""Two pitch curves that roll on each other over part of a turn, and stand still over the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.curve import POLAR, PitchCurve, X, Y
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.numerics.chebyshev import Panels

BEYOND = 0.75
"""How far the pitch curves are gone on with beyond both ends [rad]: end teeth are cut, in part, where none rolls."""


@dataclass(frozen=True)
class Rolling:
    """Pitch curves that roll over angles `over` of the driving gear [rad]; then the driven one stands still.

    `pair` are the curves with what is added beyond both ends; `lead` and `behind` are the lengths [m] of it that come
    first on the gear and on its mate, `length` that of what rolls.
    """

    pair: Pair
    over: tuple[float, float]
    lead: float
    behind: float
    length: float

    @classmethod
    def of(cls, radius: Callable[[Array], Array], over: tuple[float, float], joints: Array, distance: float) -> Rolling:
        """Of pitch radii (n,) [m] of a gear at its polar angles (n,), smooth between joints.

        Beyond its ends the radius goes on by its value, slope and second derivative there.
        """
        first, last = over
        inner = np.unique(np.concatenate([[first, last], joints[(joints > first) & (joints < last)]]))
        told = Panels.of(lambda t: radius(t)[None], inner)
        rows = told, told.slope, told.slope.slope

        def radii(t: Array) -> Array:
            near = np.clip(t, first, last)
            past = t - near
            r, dr, ddr = (part(near)[0] for part in rows)
            return np.array([r + dr * past + ddr * past**2 / 2, dr + ddr * past, ddr])

        def ratios(t: Array) -> Array:
            r, dr, _ = radii(t)
            return np.array(list(RACK("rolling", r=r, dr=dr, a=distance).values()))

        breaks = np.concatenate([[first - BEYOND], inner, [last + BEYOND]])
        turned = Panels.of(lambda t: ratios(t)[:1], breaks).integral

        def contact(t: Array) -> Array:
            return np.vstack([radii(t), ratios(t), turned(t)])

        def gear(t: Array) -> tuple[Array, Array]:
            return np.vstack([t, radii(t)]), np.ones_like(t)

        def mate(t: Array) -> tuple[Array, Array]:
            found = contact(t)
            return np.array(list(RACK("mate", contact=found, a=distance).values())), found[3]

        curves = PitchCurve.traced(gear, breaks, 1), PitchCurve.traced(mate, breaks, -1)
        lead, end = curves[0].arc_within(np.array(over)).tolist()
        return cls(Pair(*curves, distance), over, lead, curves[1].length - end, end - lead)

    def rolled(self, turned: Array) -> Array:
        """Rolling lengths (n,) from the first contact on at angles of the driving gear (n,), within `over`."""
        return self.pair.gear.arc_within(turned) - self.lead

    def places(self, at: Array) -> tuple[Array, Array]:
        """Angle and axis (3, n) of both gears at rolling lengths (n,) from the first contact on."""
        own = self.pair.gear.at(self.lead + at)[POLAR]
        mate = self.pair.mate.at(self.behind + self.length - at)[POLAR]
        zero = np.zeros_like(at)
        return np.array([-own, zero, zero]), np.array([np.pi - mate, np.full_like(at, self.pair.distance), zero])

    def held(self, share: Array) -> tuple[Array, Array]:
        """The same over the dwell, at shares (n,) of it."""
        mate = self.places(np.array([self.length]))[1]
        turned = self.over[1] + share * self.dwell
        zero = np.zeros_like(share)
        return np.array([-turned, zero, zero]), np.tile(mate, len(share))

    @property
    def dwell(self) -> float:
        """Angle of the gear over which its mate stands still [rad]."""
        return TURN - (self.over[1] - self.over[0])

    @property
    def turned(self) -> float:
        """How far the mate turns over the teeth [rad]."""
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
        return _beyond(self.pair.mate, self.behind, self.pair.distance)

    @property
    def distance(self) -> float:
        """Distance of the axes [m]."""
        return self.pair.distance

    def beside(self, end: int, at: float) -> Array:
        """Place of the mate's pitch curve (5, 1), as `rack_teeth` takes it, so far [m] from an end of the rolling."""
        return self.pair.mate.at(np.array([self.behind + (at if end else self.length - at)]))[:POLAR]

    def driven_axis(self, end: int) -> Array:
        """The mate's axis in the gear's frame (2,) [m] where the rolling begins, 0, or ends, 1."""
        return _beyond(self.pair.gear, self.lead + end * self.length, self.pair.distance)


def _beyond(curve: PitchCurve, at: float, distance: float) -> Array:
    """The other gear's axis in a gear's frame while it touches there: at a distance along the pitch point's radius."""
    place = curve.at(np.array([at]))[[X, Y], 0]
    return np.asarray(distance * place / np.hypot(*place))
