"""Functions of an angle with two derivatives: their extremes and crossings, motion of the nozzle,
pitch curves.

Extremes are searched for on a grid and refined to rounding by Newton's method in brackets.
Curvature and contact ratio are functions along the two segments that each pitch curve is deformed
in. A segment has the parameter u from 0 to pi, t = u/m in the first and t = 2 pi - u/m2 in the
second, so that the curvature, which jumps where they meet, has its extremes inside a segment or at
its ends.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.gears.geometry.flanks import TEETH
from planter.gears.geometry.stage import Stage
from planter.kernels import Array, Kernel, formulas
from planter.numerics import roots
from planter.numerics.arrays import double_area
from planter.numerics.extrema import find_stationary_points
from planter.papers.planting.model import Device

CYCLE_CELLS, PART_CELLS, PITCH_CELLS = 180, 48, 48
"""Cells of the grids over a cycle, over a part of it, and over a segment of a pitch curve."""
MAX_UNCACHED = 20
"""More angles than these count as a grid, whose values are cached."""


@dataclass(frozen=True)
class AngleExtreme:
    """An extremum of a function over [low, high]: angle, value, and location: 0 low end, 1 high
    end, 2 inside.
    """

    angle: float
    value: float
    location: int

    @property
    def weights(self) -> list[float]:
        return [float(self.location == k) for k in range(3)]


class AngleFunction:
    """A function of an angle with its first two derivatives: one row of a kernel.

    Values on grids are cached: `select_row` gives another row of the same kernel at no further
    cost.
    """

    def __init__(self, kernel: Kernel, **inputs: object) -> None:
        self.kernel, self.row, self.inputs = kernel, 0, inputs
        self.name = next(name for name in kernel.names if name in kernel.lanes)
        self._grids: dict[bytes, dict[str, Array]] = {}

    def select_row(self, row: int) -> AngleFunction:
        """Return another row of the same kernel."""
        function = copy.copy(self)
        function.row = row
        return function

    def evaluate(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return values and first and second derivatives at angles (n,), (n,) each."""
        outputs = (
            self._evaluate_grid(angles)
            if len(angles) > MAX_UNCACHED
            else self.kernel(**{self.name: angles}, **self.inputs)
        )
        value, first, second = (outputs[name][self.row] for name in ("f", "df", "ddf"))
        return value, first, second

    def _evaluate_grid(self, angles: Array) -> dict[str, Array]:
        key = angles.tobytes()
        if key not in self._grids:
            self._grids[key] = self.kernel(**{self.name: angles}, **self.inputs)
        return self._grids[key]

    def value(self, angle: float) -> float:
        """Return the value at an angle."""
        return float(self.evaluate(np.array([angle]))[0][0])

    def find_crossing(self, level: float, low: float, high: float) -> float:
        """Return the angle in [low, high] where the function passes a level, with one end on either
        side of it.
        """
        ends = self.evaluate(np.array([low, high]))[0] - level

        def above(angle: Array) -> tuple[Array, Array]:
            value, slope, _ = self.evaluate(angle)
            return value - level, slope

        brackets = np.array([low]), np.array([high])
        return float(roots.find_bracketed_roots(above, *brackets, (ends[:1], ends[1:]))[0])

    def find_extremum(
        self, low: float, high: float, sign: int, cells: int = PART_CELLS
    ) -> AngleExtreme:
        """Return the largest (sign +1) or smallest (-1) value over [low, high]."""
        grid = np.linspace(low, high, cells + 1)
        value, slope, _ = self.evaluate(grid)
        ends = [AngleExtreme(float(grid[k]), float(value[k]), w) for k, w in ((0, 0), (-1, 1))]
        inside, maxima = find_stationary_points(self._slope, grid, slope)
        inside = inside[maxima == (sign > 0)]
        if not len(inside):
            return max(ends, key=lambda e: sign * e.value)
        interior = [
            AngleExtreme(float(a), float(v), 2)
            for a, v in zip(inside, self.evaluate(inside)[0], strict=True)
        ]
        return max([*ends, *interior], key=lambda e: sign * e.value)

    def _slope(self, angles: Array) -> tuple[Array, Array]:
        _, first, second = self.evaluate(angles)
        return first, second


@dataclass(frozen=True)
class TipCycle:
    """Angles [rad] of the lowest tip, of the highest one before it, and of the tip's entering and
    leaving the soil.

    None for the last two where no requirement speaks of the soil; `soil` is its level [m].
    """

    lowest: float
    highest: float
    enter: float | None = None
    leave: float | None = None
    soil: float | None = None

    @property
    def soil_ends(self) -> tuple[float, float, float]:
        """Angles at which the tip enters the soil and leaves it, and the level of the soil, if
        there is any.
        """
        assert self.enter is not None
        assert self.leave is not None
        assert self.soil is not None
        return self.enter, self.leave, self.soil


@dataclass(frozen=True)
class Soil:
    """Level of the soil [m], relative to the lowest point of the tip or in the machine's frame."""

    depth: float | None = None
    line: float | None = None

    def level(self, lowest: Any) -> Any:
        """Its level, with the tip's lowest."""
        return lowest + self.depth if self.line is None else self.line + 0 * lowest


def locate_tip_cycle(height: AngleFunction, soil: Soil | None) -> TipCycle:
    """Return the angles of a tip's height [m] over a cycle.

    Raises ComputationError if the tip never leaves the soil, or never reaches it.
    """
    lowest = _find_closed_extremum(height, -1)
    highest = _find_closed_extremum(height, 1, lowest - np.pi)
    if soil is None:
        return TipCycle(lowest, highest)
    bottom, top = height.value(lowest), height.value(highest)
    level = float(soil.level(bottom))
    if not bottom < level < top:
        key, number = (
            ("soil_line_mm", level) if soil.line is not None else ("soil_depth_mm", level - bottom)
        )
        never = "leaves" if level >= top else "reaches"
        raise ComputationError(
            f"the tip's path is {1e3 * (top - bottom):.6g} mm high, its lowest point at "
            f"{1e3 * bottom:.6g} mm, so that "
            f"the tip never {never} the soil with {key} = {1e3 * number:.6g}"
        )
    return TipCycle(lowest, highest, *_find_soil_ends(height, level, lowest), level)


def _find_closed_extremum(function: AngleFunction, sign: int, start: float = 0.0) -> float:
    """Return the angle of the extremum of a periodic function; `start` decides which of its
    periods.
    """
    grid = start + 2 * np.pi * np.arange(CYCLE_CELLS) / CYCLE_CELLS
    best = grid[int(np.argmax(sign * function.evaluate(grid)[0]))]
    step = 2 * np.pi / CYCLE_CELLS
    return function.find_extremum(best - 2 * step, best + 2 * step, sign, 4).angle


def _find_soil_ends(height: AngleFunction, soil: float, lowest: float) -> tuple[float, float]:
    """Return where the tip enters the soil before its lowest point and leaves it after."""
    ends = []
    for side in (-1, 1):
        grid = lowest + side * 2 * np.pi * np.arange(CYCLE_CELLS) / CYCLE_CELLS
        first = int(np.argmax(height.evaluate(grid)[0] > soil))
        low, high = sorted((float(grid[first - 1]), float(grid[first])))
        ends.append(height.find_crossing(soil, low, high))
    return ends[0], ends[1]


TOOTH = ("pitch_curvature", "curvature_radius", "contact_ratio")
"""Requirements on pitch curves."""
INNER, OUTER, RATIO = 0, 1, 2
"""Rows of a segment: curvature of the inner gear and of its conjugate [1/m], contact ratio [-]."""


@dataclass(frozen=True)
class RackTeeth:
    """Rack teeth: module [m], pressure angle [rad]; the addendum is one module."""

    module: float
    pressure_angle: float

    @property
    def sizes(self) -> dict[str, float]:
        """Sizes by the names of the derivation."""
        return {"module": self.module, "ha1": 1.0, "ha2": 1.0, "alpha0": self.pressure_angle}


def build_segment_function(stage: Stage, second: bool, teeth: RackTeeth) -> ca.Function:
    """Return (u, parameters, invariants) -> rows (3,) of a segment, with first and second
    derivatives in u.
    """
    curvature = stage.curvature.function
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", curvature.size1_in(1))
    hoisted = ca.SX.sym("hoisted", curvature.size1_in(2))
    curvatures = curvature(u, p, hoisted)
    inner, outer = curvatures[2:] if second else curvatures[:2]
    rows = ca.vertcat(inner, outer, contact_ratio(inner, outer, teeth))
    first = ca.jacobian(rows, u)
    return ca.Function(
        "segment", [u, p, hoisted], [rows, ca.densify(first), ca.densify(ca.jacobian(first, u))]
    )


def contact_ratio(kappa1: ca.SX, kappa2: ca.SX, teeth: RackTeeth) -> ca.SX:
    """Return the contact ratio of rack teeth on pitch curves of given curvatures at the pitch point
    [1/m].
    """
    return TEETH.composed("contact_ratio", {"kappa1": kappa1, "kappa2": kappa2, **teeth.sizes})[
        "epsilon"
    ]


def build_segment_kernel(f: ca.Function) -> Kernel:
    """Return the kernel of a segment's rows at many u."""
    inputs = f.sx_in()
    named = ca.Function(
        "segment", inputs, f.call(inputs), ["u", "parameters", "hoisted"], ["f", "df", "ddf"]
    )
    return Kernel(named, lanes=["u"])


MOVING = ("x_tip", "x_tip_machine", "y_tip", "alpha", "theta1", "x_B1", "y_B1", "t1", "t2")
NOZZLE = formulas.load("planting_nozzle")
DISTANCE_EPS = 1e-9
"""Regularises a distance d at zero: sqrt(d^2 + eps^2) [m]."""
SIDE_OFFSET = float(np.pi)
"""Side 2 follows half a revolution later [rad]."""


class NozzleMotion:
    """Functions of (phi, z, more), z = (x, c, h) stacked, each with first and second derivative in
    phi: tip, tilt and the distances in the requirements, and where gears touch.
    """

    def __init__(self, device: Device) -> None:
        functions = device.functions
        self.phi, x, c, h = functions.inputs
        self.z = ca.vertcat(x, c, h)
        names = [entry["name"] for entry in device.sidecar["vectors"]["side"]]
        constants = [entry["name"] for entry in device.sidecar["vectors"]["machine"]]
        self._constants = dict(zip(constants, ca.vertsplit(c), strict=True))
        side = functions.side(self.phi)
        moving = ca.vertcat(*(side[names.index(name)] for name in MOVING))
        self._side = ca.Function("one", [self.phi, self.z], [moving])
        self._kernels: dict[str, Kernel] = {}

    def _locate(self, phi: ca.SX) -> dict[str, ca.SX]:
        """Return the quantities of `MOVING`, and `tilt` from the vertical, at a carrier angle."""
        quantities = dict(zip(MOVING, ca.vertsplit(self._side(phi, self.z)), strict=True))
        tilt = NOZZLE.composed("axis", quantities | {"soil": ca.SX(0)})["tilt"]
        return quantities | {"tilt": tilt}

    @cached_property
    def _functions(self) -> dict[str, ca.Function]:
        """The functions by name, lengths in m, angles in rad.

        `ground_intersection` is where over ground the nozzle's axis meets the level of the soil,
        `clearance` the least horizontal distance of a nozzle half, as far as it is lower than the
        seedling's `top`, from the axis of the `plant`, `squared_distance` that of the tip from a
        point in the machine's frame, and `nozzle_distance` that of the nozzles' axes, funnel to
        tip, in their plane: if these cross, the negative of the shortest displacement that
        separates them.
        """
        at, phi = self._locate(self.phi), self.phi
        soil, plant, top = (ca.SX.sym(name) for name in ("soil", "plant", "top"))
        x, y = ca.SX.sym("x"), ca.SX.sym("y")
        half = self._constants | at | {"plant": plant, "top": top, "hair": DISTANCE_EPS}
        squared = (at["x_tip_machine"] - x) ** 2 + (at["y_tip"] - y) ** 2
        rates = ca.vertcat(*(ca.gradient(at[name], phi) for name in ("x_B1", "y_B1")))
        values: dict[str, tuple[ca.SX, ...]] = {
            "height": (at["y_tip"],),
            "position": (at["x_tip"],),
            "tilt": (at["tilt"],),
            "contact1": (at["t1"],),
            "contact2": (at["t2"],),
            "funnel_speed": (ca.norm_2(rates) * self._constants["omega"],),
            "nozzle_distance": (self._separate_nozzles(),),
            "ground_intersection": (NOZZLE.composed("axis", at | {"soil": soil})["cut"], soil),
            "clearance": (NOZZLE.composed("half", half)["clearance"], plant, top),
            "squared_distance": (squared, x, y),
        }
        functions = {}
        for name, (value, *more) in values.items():
            first = ca.gradient(value, phi)
            outputs = [value, first, ca.gradient(first, phi)]
            inputs, names = [phi, self.z, *more], ["phi", "z", "first", "second"]
            functions[name] = ca.Function(
                name, inputs, outputs, names[: len(inputs)], ["f", "df", "ddf"]
            )
        return functions

    def __getitem__(self, name: str) -> ca.Function:
        """Return a function by its name."""
        return self._functions[name]

    def kernel(self, name: str) -> Kernel:
        """Return a function of many angles."""
        if name not in self._kernels:
            self._kernels[name] = Kernel(self._functions[name], lanes=["phi"])
        return self._kernels[name]

    def _separate_nozzles(self) -> ca.SX:
        first, second = (self._locate_axis(self.phi - lag) for lag in (0.0, SIDE_OFFSET))
        pairs = ((first, second), (second, first))
        ends = [_distance_to_segment(p, *target) for points, target in pairs for p in points]
        distance = ca.fmin(ca.fmin(ends[0], ends[1]), ca.fmin(ends[2], ends[3]))
        sides = [double_area(*line, p) * double_area(*line, q) for line, (p, q) in pairs]
        crossing = ca.logic_and(sides[0] < 0, sides[1] < 0)
        return ca.if_else(crossing, -distance, distance)

    def _locate_axis(self, phi: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return funnel and tip in the machine's frame."""
        at = self._locate(phi)
        return ca.vertcat(at["x_B1"], at["y_B1"]), ca.vertcat(at["x_tip_machine"], at["y_tip"])


def _distance_to_segment(p: ca.SX, a: ca.SX, b: ca.SX) -> ca.SX:
    """Return the distance of a point from the segment from a to b."""
    share = ca.dot(p - a, b - a) / ca.sumsqr(b - a)
    return ca.sqrt(ca.sumsqr(p - a - ca.fmin(ca.fmax(share, 0), 1) * (b - a)) + 1e-18)
