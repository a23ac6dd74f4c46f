"""Laws of the arm: its angle phi1 over the carrier's angle t from the farthest tip, with a dwell if there is one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from scipy.interpolate import BSpline

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.angles import TURN

MODEL, NEEDLE = "pickup_exact", "pickup_needle"
"""The generated formulas of the pick-up."""
ROUNDING = 1e-12
"""Angles this close to an end of the dwell lie in it [rad]."""


@dataclass(frozen=True)
class Dwell:
    """Where the locking arcs act: carrier angles in rad, 0 <= start < 2 pi, end after start."""

    start: float
    end: float

    @property
    def width(self) -> float:
        return self.end - self.start

    def holds(self, t: Array) -> Array:
        """Whether angles lie in the dwell, its ends included; any turn."""
        inside = (t - self.start + ROUNDING) % TURN <= self.width + 2 * ROUNDING
        return np.asarray(inside)


class ArmLaw(Protocol):
    """phi1(t) with phi1(t + 2 pi) = phi1(t) + 2 pi."""

    @property
    def dwell(self) -> Dwell | None: ...

    @property
    def transition(self) -> float:
        """How far on either side of the dwell the arm is driven by other means than teeth [rad]."""

    def arm(self, t: Array) -> Array:
        """The arm's angle [rad]."""

    def slopes(self, t: Array) -> Array:
        """Slope on the teeth and its two derivatives, (3, n); in the dwell they continue those of the teeth."""

    def joints(self) -> Array:
        """Angles in the toothed range between which the law is smooth, both ends included, in order."""


def toothed_range(dwell: Dwell | None) -> tuple[float, float]:
    """First and last angle of the teeth: the turn without the dwell, from the dwell's end on."""
    return (0.0, TURN) if dwell is None else (dwell.end - TURN, dwell.start)


@dataclass(frozen=True)
class CosineLaw:
    """Slope c (1 + p cos t) on the teeth; c lets the arm gain one turn in a turn of the carrier."""

    p: float
    dwell: Dwell
    phi1_far: float = np.pi
    transition: ClassVar[float] = 0.0

    @property
    def _vector(self) -> Array:
        return np.array([self.p, self.dwell.start, self.dwell.end, self.phi1_far])

    def arm(self, t: Array) -> Array:
        return load(MODEL)("law", t=t, law=self._vector)["phi1"]

    def slopes(self, t: Array) -> Array:
        found = load(MODEL)("law", t=t, law=self._vector)
        return np.array([found[name] for name in ("g", "dg", "ddg")])

    def joints(self) -> Array:
        return np.array(toothed_range(self.dwell))

    @property
    def mean_on_teeth(self) -> float:
        """c [-]."""
        return load(MODEL).at("law", t=np.pi / 2, law=self._vector)["g"]


@dataclass(frozen=True)
class SplineLaw:
    """A law by its lead phi1 - t, a spline over the toothed range; `held` is phi1 in the dwell that follows it."""

    lead: BSpline
    dwell: Dwell | None
    held: float
    transition: ClassVar[float] = 0.0

    def _within(self, t: Array) -> Array:
        """The angles brought into the turn that begins where the teeth do."""
        first, _ = toothed_range(self.dwell)
        return first + (np.asarray(t, dtype=float) - first) % TURN

    def arm(self, t: Array) -> Array:
        within = self._within(t)
        last = toothed_range(self.dwell)[1]
        on_teeth = self.lead(np.minimum(within, last)) + within
        return np.asarray(np.where(within <= last, on_teeth, self.held) + np.asarray(t, dtype=float) - within)

    def slopes(self, t: Array) -> Array:
        within = self._within(t)
        first, last = toothed_range(self.dwell)
        if self.dwell is not None:
            closer_to_end = within > last + self.dwell.width / 2
            within = np.where(closer_to_end, first, np.minimum(within, last))
        return np.array([self.lead(within, 1) + 1, self.lead(within, 2), self.lead(within, 3)])

    def joints(self) -> Array:
        first, last = toothed_range(self.dwell)
        knots = np.unique(first + (self.lead.t - first) % TURN) if self.dwell is None else np.unique(self.lead.t)
        return np.concatenate([[first], knots[(knots > first) & (knots < last)], [last]])
