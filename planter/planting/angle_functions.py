"""Functions of an angle with two derivatives: their extremes and crossings, the cycle of the tip, the pitch curves.

Extremes are searched for on a grid and refined to rounding by Newton's method in brackets. Curvature and contact ratio
stand along the two segments that each pitch curve is deformed in. A segment has the parameter u from 0 to pi, t = u/m
in the first and t = 2 pi - u/m2 in the second, so that the curvature, which jumps where they meet, has its extremes
inside a segment or at its ends.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.gear_geometry.flanks import TEETH
from planter.gear_geometry.stage import Stage
from planter.kernels import Array, Kernel
from planter.numerics import roots
from planter.numerics.extrema import find_stationary_points

TURN, STRETCH, PITCH = 180, 48, 48
"""Cells of the grids over a turn, over a part of it, and over a segment of a pitch curve."""
FEW = 20
"""More angles than these are a grid."""


@dataclass(frozen=True)
class AngleExtreme:
    """An extreme of a course over [low, high]: place, value, and which it is: 0 low end, 1 high end, 2 inside."""

    place: float
    value: float
    where: int

    @property
    def weights(self) -> list[float]:
        return [float(self.where == k) for k in range(3)]


class AngleFunction:
    """A function of an angle, with its first two derivatives, over many of it: one row of a kernel.

    Grids are remembered: `of_row` gives another row of the same kernel at no further cost.
    """

    def __init__(self, kernel: Kernel, **given: object) -> None:
        self.kernel, self.row, self.given = kernel, 0, given
        self.name = next(name for name in kernel.names if name in kernel.lanes)
        self._grids: dict[bytes, dict[str, Array]] = {}

    def of_row(self, row: int) -> AngleFunction:
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

    def extreme(self, low: float, high: float, sign: int, cells: int = STRETCH) -> AngleExtreme:
        """The largest (sign +1) or least (-1) value over [low, high]."""
        grid = np.linspace(low, high, cells + 1)
        value, slope, _ = self.rows(grid)
        ends = [AngleExtreme(float(grid[k]), float(value[k]), w) for k, w in ((0, 0), (-1, 1))]
        inside, maxima = find_stationary_points(self._slope, grid, slope)
        inside = inside[maxima == (sign > 0)]
        if not len(inside):
            return max(ends, key=lambda e: sign * e.value)
        found = [AngleExtreme(float(a), float(v), 2) for a, v in zip(inside, self.rows(inside)[0], strict=True)]
        return max([*ends, *found], key=lambda e: sign * e.value)

    def _slope(self, angles: Array) -> tuple[Array, Array]:
        _, first, second = self.rows(angles)
        return first, second


@dataclass(frozen=True)
class TipCycle:
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


def locate_tip_cycle(height: AngleFunction, soil: Soil | None) -> TipCycle:
    """The turn of a tip's course of height [m].

    Raises ComputationError where the tip never leaves the soil, or never reaches it.
    """
    lowest = _around(height, -1)
    high = _around(height, 1, lowest - np.pi)
    if soil is None:
        return TipCycle(lowest, high)
    bottom, top = height.value(lowest), height.value(high)
    level = float(soil.level(bottom))
    if not bottom < level < top:
        key, told = ("soil_line_mm", level) if soil.line is not None else ("soil_depth_mm", level - bottom)
        never = "leaves" if level >= top else "reaches"
        raise ComputationError(
            f"the tip's path is {1e3 * (top - bottom):.6g} mm high, its lowest point at {1e3 * bottom:.6g} mm, so that "
            f"the tip never {never} the soil with {key} = {1e3 * told:.6g}"
        )
    return TipCycle(lowest, high, *_ends(height, level, lowest), level)


def _around(course: AngleFunction, sign: int, start: float = 0.0) -> float:
    """The place of the extreme of a closed course over the turn that is centred on it, wherever that begins."""
    grid = start + 2 * np.pi * np.arange(TURN) / TURN
    best = grid[int(np.argmax(sign * course.rows(grid)[0]))]
    step = 2 * np.pi / TURN
    return course.extreme(best - 2 * step, best + 2 * step, sign, 4).place


def _ends(height: AngleFunction, soil: float, lowest: float) -> tuple[float, float]:
    """Where the tip enters the soil before its lowest point and leaves it after."""
    found = []
    for side in (-1, 1):
        grid = lowest + side * 2 * np.pi * np.arange(TURN) / TURN
        first = int(np.argmax(height.rows(grid)[0] > soil))
        low, high = sorted((float(grid[first - 1]), float(grid[first])))
        found.append(height.crossing(soil, low, high))
    return found[0], found[1]


TOOTH = ("pitch_curvature", "curvature_radius", "contact_ratio")
"""Requirements that stand along pitch curves."""
INNER, OUTER, RATIO = 0, 1, 2
"""Rows of a segment: curvature of the inner gear and of its conjugate [1/m], contact ratio [-]."""


@dataclass(frozen=True)
class RackTeeth:
    """Rack teeth: module [m], pressure angle [rad]; the addendum is one module."""

    module: float
    pressure_angle: float

    @property
    def sizes(self) -> dict[str, float]:
        """By the names of the derivation."""
        return {"module": self.module, "ha1": 1.0, "ha2": 1.0, "alpha0": self.pressure_angle}


def build_segment_function(stage: Stage, second: bool, teeth: RackTeeth) -> ca.Function:
    """(u, parameters, hoisted) -> rows (3,) of a segment, and their first and second derivatives in u."""
    curvature = stage.curvature.function
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", curvature.size1_in(1))
    hoisted = ca.SX.sym("hoisted", curvature.size1_in(2))
    found = curvature(u, p, hoisted)
    one, two = found[2:] if second else found[:2]
    rows = ca.vertcat(one, two, contact_ratio(one, two, teeth))
    first = ca.jacobian(rows, u)
    return ca.Function("segment", [u, p, hoisted], [rows, ca.densify(first), ca.densify(ca.jacobian(first, u))])


def contact_ratio(one: ca.SX, two: ca.SX, teeth: RackTeeth) -> ca.SX:
    """Contact ratio of rack teeth on two pitch curves by their curvatures at the pitch point [1/m]."""
    return TEETH.composed("contact_ratio", {"kappa1": one, "kappa2": two, **teeth.sizes})["epsilon"]


def build_segment_kernel(f: ca.Function) -> Kernel:
    """A segment's rows at many u."""
    inputs = f.sx_in()
    named = ca.Function("segment", inputs, f.call(inputs), ["u", "parameters", "hoisted"], ["f", "df", "ddf"])
    return Kernel(named, lanes=["u"])
