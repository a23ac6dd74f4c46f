"""Where over a turn requirements stand at a design: lowest and highest tip, the soil's ends, extremes between them.

Everything is looked for on a grid and refined to rounding by Newton's method in brackets.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, Kernel
from planter.numerics import roots
from planter.numerics.extrema import find_stationary_points

TURN, STRETCH, PITCH = 180, 48, 48
"""Cells of the grids over a turn, over a part of it, and over a segment of a pitch curve."""
FEW = 20
"""More angles than these are a grid."""


@dataclass(frozen=True)
class TipExtreme:
    """An extreme of a course over [low, high]: place, value, and which it is: 0 low end, 1 high end, 2 inside."""

    place: float
    value: float
    where: int

    @property
    def weights(self) -> list[float]:
        return [float(self.where == k) for k in range(3)]


class Course:
    """A function of an angle, with its first two derivatives, over many of it: one row of a kernel.

    Grids are remembered: `of_row` gives another row of the same kernel at no further cost.
    """

    def __init__(self, kernel: Kernel, **given: object) -> None:
        self.kernel, self.row, self.given = kernel, 0, given
        self.name = next(name for name in kernel.names if name in kernel.lanes)
        self._grids: dict[bytes, dict[str, Array]] = {}

    def of_row(self, row: int) -> Course:
        other = copy.copy(self)
        other.row = row
        return other

    def rows(self, angles: Array) -> tuple[Array, Array, Array]:
        found = self._grid(angles) if len(angles) > FEW else self.kernel(**{self.name: angles}, **self.given)
        value, first, second = (found[name][self.row] for name in ("f", "df", "ddf"))
        return value, first, second

    def _grid(self, angles: Array) -> dict[str, Array]:
        key = angles.tobytes()
        if key not in self._grids:
            self._grids[key] = self.kernel(**{self.name: angles}, **self.given)
        return self._grids[key]

    def value(self, angle: float) -> float:
        return float(self.rows(np.array([angle]))[0][0])

    def crossing(self, level: float, low: float, high: float) -> float:
        """The angle in [low, high] where the course passes a level; its ends lie on both sides of it."""
        ends = self.rows(np.array([low, high]))[0] - level

        def above(angle: Array) -> tuple[Array, Array]:
            value, slope, _ = self.rows(angle)
            return value - level, slope

        brackets = np.array([low]), np.array([high])
        return float(roots.find_bracketed_roots(above, *brackets, (ends[:1], ends[1:]))[0])

    def extreme(self, low: float, high: float, sign: int, cells: int = STRETCH) -> TipExtreme:
        """The largest (sign +1) or least (-1) value over [low, high]."""
        grid = np.linspace(low, high, cells + 1)
        value, slope, _ = self.rows(grid)
        ends = [TipExtreme(float(grid[k]), float(value[k]), w) for k, w in ((0, 0), (-1, 1))]
        inside, maxima = find_stationary_points(self._slope, grid, slope)
        inside = inside[maxima == (sign > 0)]
        if not len(inside):
            return max(ends, key=lambda e: sign * e.value)
        found = [TipExtreme(float(a), float(v), 2) for a, v in zip(inside, self.rows(inside)[0], strict=True)]
        return max([*ends, *found], key=lambda e: sign * e.value)

    def _slope(self, angles: Array) -> tuple[Array, Array]:
        _, first, second = self.rows(angles)
        return first, second


@dataclass(frozen=True)
class Turn:
    """Angles [rad] of the lowest tip, of the highest one before it, and of the tip's entering and leaving the soil.

    None for the last two where no requirement speaks of the soil; `soil` is its level [m].
    """

    low: float
    high: float
    enter: float | None = None
    leave: float | None = None
    soil: float | None = None

    @property
    def soil_ends(self) -> tuple[float, float, float]:
        """Where the tip enters the soil and leaves it, and the soil's level, where there is any."""
        assert self.enter is not None
        assert self.leave is not None
        assert self.soil is not None
        return self.enter, self.leave, self.soil


@dataclass(frozen=True)
class Soil:
    """Where the soil stands [m]: so far above the lowest tip point, or at a level of the machine's frame."""

    depth: float | None = None
    line: float | None = None

    def level(self, lowest: Any) -> Any:
        """Its level, with the tip's lowest."""
        return lowest + self.depth if self.line is None else self.line + 0 * lowest


def turn(height: Course, soil: Soil | None) -> Turn:
    """The turn of a tip's course of height [m].

    Raises ComputationError where the tip never leaves the soil, or never reaches it.
    """
    lowest = _around(height, -1)
    high = _around(height, 1, lowest - np.pi)
    if soil is None:
        return Turn(lowest, high)
    bottom, top = height.value(lowest), height.value(high)
    level = float(soil.level(bottom))
    if not bottom < level < top:
        key, told = ("soil_line_mm", level) if soil.line is not None else ("soil_depth_mm", level - bottom)
        never = "leaves" if level >= top else "reaches"
        raise ComputationError(
            f"the tip's path is {1e3 * (top - bottom):.6g} mm high, its lowest point at {1e3 * bottom:.6g} mm, so that "
            f"the tip never {never} the soil with {key} = {1e3 * told:.6g}"
        )
    return Turn(lowest, high, *_ends(height, level, lowest), level)


def _around(course: Course, sign: int, start: float = 0.0) -> float:
    """The place of the extreme of a closed course over the turn that is centred on it, wherever that begins."""
    grid = start + 2 * np.pi * np.arange(TURN) / TURN
    best = grid[int(np.argmax(sign * course.rows(grid)[0]))]
    step = 2 * np.pi / TURN
    return course.extreme(best - 2 * step, best + 2 * step, sign, 4).place


def _ends(height: Course, soil: float, lowest: float) -> tuple[float, float]:
    """Where the tip enters the soil before its lowest point and leaves it after."""
    found = []
    for side in (-1, 1):
        grid = lowest + side * 2 * np.pi * np.arange(TURN) / TURN
        first = int(np.argmax(height.rows(grid)[0] > soil))
        low, high = sorted((float(grid[first - 1]), float(grid[first])))
        found.append(height.crossing(soil, low, high))
    return found[0], found[1]
