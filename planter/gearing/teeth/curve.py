"""Closed pitch curves by arc length: point, tangent, curvature and polar angle, accurate to rounding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics import roots
from planter.numerics.angles import TURN
from planter.numerics.chebyshev import Panels

X, Y, TX, TY, KAPPA, POLAR = range(6)
"""Rows of a curve: point [m], unit tangent, curvature [1/m], polar angle [rad]."""
_JUMP_TOLERANCE = 1e-9
"""Share of the largest curvature below which a jump is rounding."""
_SIDE_SHIFT = 1e-9
"""Shift towards the requested side of a breakpoint, as a share."""

Trace = Callable[[Array], tuple[Array, Array]]
"""Polar places (4, n) of a curve at parameters (n,), as `rack_teeth` takes them, and polar angle per parameter (n,)."""


@dataclass(frozen=True)
class PitchCurve:
    """A closed curve round its gear's axis, anticlockwise; `joints` are arc lengths in [0, L) where curvature jumps."""

    rows: Panels
    joints: Array

    @classmethod
    def from_trace(cls, trace: Trace, breaks: Array, sense: int) -> PitchCurve:
        """Return a curve whose polar angle runs anticlockwise (sense +1) or clockwise (-1) with its parameter.

        `breaks` are the parameters (m,) from its start to its end between which it is smooth.
        """

        def speed(u: Array) -> Array:
            polar, pace = trace(u)
            return RACK("pitch", polar_place=polar, sense=sense)["speed"][None] * pace

        length = Panels.of(speed, breaks).integral
        at_ends = length(length.ends)[0]
        at_ends[0] = 0.0
        total = at_ends[-1]

        def parameter(s: Array) -> Array:
            index = np.clip(np.searchsorted(at_ends, s, "right") - 1, 0, len(at_ends) - 2)
            low, high = length.ends[index], length.ends[index + 1]
            ends = np.minimum(at_ends[index] - s, -0.0), np.maximum(at_ends[index + 1] - s, 0.0)

            def rates(u: Array) -> tuple[Array, Array]:
                return length(u, index)[0] - s, speed(u)[0]

            return roots.newton(rates, low, high, ends)

        def rows(arcs: Array) -> Array:
            polar, _ = trace(parameter(arcs if sense > 0 else total - arcs))
            columns = list(RACK("pitch", polar_place=polar, sense=sense).values())[:5]
            angle = polar[0] if sense > 0 else TURN - polar[0]
            return np.array([*columns, angle])

        ends = at_ends if sense > 0 else total - at_ends[::-1]
        return cls.from_panels(Panels.of(rows, ends))

    @classmethod
    def from_panels(cls, rows: Panels) -> PitchCurve:
        """Return a curve with breakpoints at the ends of panels with different curvature."""
        count = np.arange(len(rows.series))
        start, end = rows(rows.ends[:-1], count)[KAPPA], rows(rows.ends[1:], count)[KAPPA]
        jump = np.abs(start - np.roll(end, 1)) > _JUMP_TOLERANCE * np.abs(start).max()
        return cls(rows, rows.ends[:-1][jump])

    @property
    def length(self) -> float:
        return float(self.rows.ends[-1])

    def at(self, s: Array, towards: Array | None = None) -> Array:
        """Return rows (6, n) at arc lengths (n,) [m] of any turn, on the side of breakpoints that lies `towards` (n,) "
        "[m]."""
        seen = s if towards is None else s + _SIDE_SHIFT * (towards - s)
        turns = np.floor(seen / self.length)
        past = turns * self.length
        rows = self.rows(s - past, self.rows.panel(seen - past))
        rows[POLAR] += TURN * turns
        return rows

    def arc(self, polar: Array) -> Array:
        """Return arc lengths (n,) [m] at polar angles (n,) [rad] of any turn."""
        turns = np.floor(polar / TURN)
        return np.asarray(self.arc_within(polar - TURN * turns) + turns * self.length)

    def arc_within(self, polar: Array) -> Array:
        """Return arc lengths (n,) [m] at polar angles (n,) [rad] between those of its ends."""
        starts = self._starts
        index = np.clip(np.searchsorted(starts, polar, "right") - 1, 0, len(starts) - 2)
        slope = self.rows.slope

        def rates(s: Array) -> tuple[Array, Array]:
            return self.rows(s, index)[POLAR] - polar, slope(s, index)[POLAR]

        ends = np.minimum(starts[index] - polar, -0.0), np.maximum(starts[index + 1] - polar, 0.0)
        return roots.newton(rates, self.rows.ends[index], self.rows.ends[index + 1], ends)

    @cached_property
    def _starts(self) -> Array:
        """Polar angles at the ends of the panels."""
        count = np.arange(len(self.rows.series))
        return np.append(self.rows(self.rows.ends[:-1], count)[POLAR], self.rows(self.rows.ends[-1:])[POLAR])

    def bends(self, s: Array, towards: Array | None = None) -> Array:
        """Return curvature [1/m] and its first two derivatives by arc length (3, n), on the side that lies "
        "`towards`."""
        seen = s if towards is None else s + _SIDE_SHIFT * (towards - s)
        past = np.floor(seen / self.length) * self.length
        panel, arcs = self.rows.panel(seen - past), s - past
        first = self.rows.slope
        return np.array([part(arcs, panel)[KAPPA] for part in (self.rows, first, first.slope)])

    def scaled(self, factor: float) -> PitchCurve:
        """Return the curve with all lengths multiplied by a factor."""
        factors = np.array([factor, factor, 1.0, 1.0, 1 / factor, 1.0])
        return PitchCurve(Panels(self.rows.ends * factor, self.rows.series * factors[:, None]), self.joints * factor)

    def places(self, share: Array) -> Array:
        """Return points (n, 2) [m] at shares (n,) of the length."""
        return self.at(share * self.length)[[X, Y]].T
