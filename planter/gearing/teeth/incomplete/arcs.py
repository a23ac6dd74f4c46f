"""How large locking arcs are, and what holds in them: the horns of the driven gear beside the line of centres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array, formulas

ARCS = formulas.load("locking_arcs")
FRICTION = 0.2
"""Coefficient of friction against which the arcs are to hold: of steel on steel, dry."""
NO_HORN = "the locking arcs find no horn beside the dwell that would hold the driven gear"
_TRIED = 65
"""Places along a line beside the dwell where a horn's edge is looked for."""
_BESIDE = np.radians(60)
"""How far from the dwell it is looked for, as an angle of the driving gear."""
_EDGE = 9
"""Places beside a horn's edge where the tips are looked at."""


class Rolled(Protocol):
    """What arcs need of pitch curves that roll and then dwell (`Rolling` has it)."""

    @property
    def distance(self) -> float:
        """Distance of the axes [m]."""

    @property
    def ends(self) -> tuple[float, float]:
        """Pitch radii of the driving gear where its teeth begin and end [m]."""

    @property
    def length(self) -> float:
        """Length of what rolls [m]."""

    @property
    def driving_axis(self) -> Array:
        """The driving gear's axis in the driven gear's frame in the dwell (2,) [m]."""

    def beside(self, end: int, at: float) -> Array:
        """Place of the driven gear's pitch curve (5, 1), as `rack_teeth` takes it, so far [m] from an end."""


def radius_of(rolling: Rolled, addendum: float) -> float:
    """Radius [m] of arcs that hold the driven gear both ways, whose teeth stand out by an addendum [m].

    The smaller of the driving gear's pitch radii where its teeth begin and end or, where a horn would not hold there,
    the least at which both do. Raises GeometryError where there is none.
    """
    return max(min(rolling.ends), *(_Line(rolling, end, addendum).least for end in (0, 1)))


@dataclass(frozen=True)
class Horn:
    """What is left of the driven gear beside the concave arc, after the dwell or before it.

    Angle at the driving axis over which it reaches [rad]; how far from the driven axis it is [m]; rolling length from
    the end of the dwell up to which it must be without a space to hold [m].
    """

    reach: float
    tips: float
    solid: float


def horn_of(rolling: Rolled, end: int, radius: float, addendum: float, dedendum: float) -> Horn:
    """The horn of arcs of a radius where the rolling begins, 0, or ends, 1. Raises GeometryError where it is none.

    Its spaces do not matter where what is left under them holds.
    """
    tips, roots = (_Line(rolling, end, height) for height in (addendum, -dedendum))
    at = tips.edge(radius)
    beside = [tips.seen(at + step)[1] for step in np.linspace(0, addendum, _EDGE)]
    return Horn(tips.reach(radius), max(beside), 0.0 if roots.holds(radius) else tips.holding)


def reaches_of(rolling: Rolled, radius: float, addendum: float) -> tuple[float, float]:
    """Angles [rad] at the driving axis over which horns reach, after the dwell and before it. Raises GeometryError."""
    first, last = (_Line(rolling, end, addendum).reach(radius) for end in (0, 1))
    return first, last


@dataclass(frozen=True)
class _Line:
    """The line at a height over the driven gear's pitch curve [m], as it stands in the dwell, from an end on."""

    rolling: Rolled
    end: int
    height: float

    @property
    def least(self) -> float:
        """The radius from which on arcs that reach to the line hold however they rub [m]."""
        return self.seen(self.holding)[0]

    @cached_property
    def holding(self) -> float:
        """Where an arc of that radius reaches the line: a rolling length from the end [m]."""
        return self._where(lambda at: self._spare(*self.seen(at)))

    def edge(self, radius: float) -> float:
        """Where an arc of a radius reaches the line. Raises GeometryError where it lies all below it."""
        if self.seen(0.0)[0] > radius:
            raise GeometryError(NO_HORN)
        return self._where(lambda at: self.seen(at)[0] - radius)

    def reach(self, radius: float) -> float:
        """Angle at the driving axis from the line of centres to there [rad]."""
        tips = self.seen(self.edge(radius))[1]
        return ARCS.at("horn", distance=self.rolling.distance, radius=radius, tips=tips)["reach"]

    def holds(self, radius: float) -> bool:
        """Whether arcs of a radius that reach to the line hold."""
        if self.seen(0.0)[0] >= radius:
            return False
        return self._spare(radius, self.seen(self.edge(radius))[1]) >= 0

    def seen(self, at: float) -> tuple[float, float]:
        """Distances of a place, so far from the end [m], from the driving axis and from the driven axis [m]."""
        found = RACK("equidistant", place=self.rolling.beside(self.end, at), height=self.height)
        point = np.array([found["px"][0], found["py"][0]])
        return float(np.hypot(*(point - self.rolling.driving_axis))), float(np.hypot(*point))

    def _spare(self, radius: float, tips: float) -> float:
        """By how much a radius is larger than the least at which an edge so far from the driven axis holds [m]."""
        return radius - ARCS.at("least", distance=self.rolling.distance, tips=tips, friction=FRICTION)["radius"]

    def _where(self, spare: Callable[[float], float]) -> float:
        """The first rolling length from the end at which something is no longer below 0. Raises GeometryError."""
        from scipy.optimize import brentq

        tried = np.linspace(0, min(_BESIDE * self.rolling.ends[self.end], self.rolling.length / 2), _TRIED)
        if spare(0.0) >= 0:
            return 0.0
        for low, high in pairwise(tried.tolist()):
            if spare(high) >= 0:
                return float(brentq(spare, low, high, xtol=1e-16))
        raise GeometryError(NO_HORN)
