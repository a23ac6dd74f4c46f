"""Requirements of a device as rows: smooth functions of the design near a point, with exact
derivatives.

Each row is a number at angles that the design moves: the lowest tip point, the ends of the soil,
extremes between them. Near a design such an angle is one Newton step from the angle found there
(two for the second derivative of what is not stationary in it), so that differentiating the row
differentiates the angle implicitly. Rows of extremes are smooth but where two extremes change
places.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError, InputError
from planter.kernels import Array, Kernel
from planter.numerics.arrays import LastCallCache
from planter.papers.planting import angle_functions as pitch
from planter.papers.planting.angle_functions import (
    CYCLE_CELLS,
    DISTANCE_EPS,
    PITCH_CELLS,
    SIDE_OFFSET,
    AngleExtreme,
    AngleFunction,
    NozzleMotion,
    Soil,
    TipCycle,
    locate_tip_cycle,
)
from planter.papers.planting.model import Device
from planter.papers.planting.requirements_section import BY_NAME, SOIL_LINE, RequirementKind

ABSOLUTE = ("release_tilt", "soil_tilt", "ground_speed_ratio", "catching_tilt")
"""Requirements whose rows have a sign, the limit being on their size."""
STRICT_MARGIN = 1e-3
"""Distance of a curvature [1/m] from a limit that it must exceed, not only reach."""
Rates = Callable[[ca.MX], Sequence[ca.MX]]
_GEARS = ("sun", "gear 5", "gear 6", "planet")


@dataclass(frozen=True)
class RequirementRow:
    """A row: its requirement, value, angle, and the gear, contact or point that it concerns, if
    any.

    A row on a pitch curve has its `stage`, 0 or 1, and whether it lies in the curve's second
    segment.
    """

    kind: RequirementKind
    value: ca.MX
    angle: ca.MX
    subject: str = ""
    stage: int = 0
    second: bool = False


@dataclass(frozen=True)
class RowValues:
    """Rows at a design: values (k,) in SI and their angles (k,): phi, or u for pitch curves [rad].

    `inputs` are the angles and weights that the graph takes in addition to design and constants.
    """

    x: Array
    inputs: Array
    values: Array
    angles: Array


class RequirementRows:
    """The rows of a device's requirements. Designs x are (p,) in SI.

    Raises ComputationError if a design has no such rows: its tip never leaves the soil.
    """

    def __init__(self, device: Device) -> None:
        section: Any = device.machine.requirements
        if section is None:
            raise InputError(f"{device.machine.source}: the file has no [requirements]")
        self.device, self.section, self.motion = device, section, NozzleMotion(device)
        self.kinds: tuple[RequirementKind, ...] = section.kinds
        self.names = {kind.name for kind in self.kinds}
        self.at = LastCallCache(self._evaluate)
        self._build()

    def setting(self, name: str) -> float:
        """Return a setting of the section in SI."""
        return float(getattr(self.section, name)) * 1e-3

    @cached_property
    def soil(self) -> Soil | None:
        """Level of the soil, None if no requirement depends on it."""
        if not any("soil_depth_mm" in kind.needs for kind in self.kinds):
            return None
        line = getattr(self.section, SOIL_LINE)
        return Soil(depth=self.setting("soil_depth_mm")) if line is None else Soil(line=line * 1e-3)

    @cached_property
    def points(self) -> Array:
        """Points that the tip must pass, with the radii of their tubes, (n, 3) [m]."""
        named = self.section.points_mm if "tube_excess" in self.names else None
        return 1e-3 * np.array(named or np.empty((0, 3)))

    @cached_property
    def segments(self) -> list[tuple[str, str, ca.Function, slice, slice]]:
        """Segments of both stages: inner and outer gear, their rows, and their parts of x and h."""
        module = self.setting("module_mm") if "contact_ratio" in self.names else 1e-3
        teeth = pitch.RackTeeth(module, self.device.machine.si("contact.pressure_angle_deg"))
        start, hoisted, segments = len(self.device.sidecar["vectors"]["mounting"]), 0, []
        for stage, gears in zip(self.device.stages, (_GEARS[:2], _GEARS[2:]), strict=True):
            px = slice(start, start + len(stage.names))
            ph = slice(hoisted, hoisted + 1 + stage.terms)
            start, hoisted = px.stop, ph.stop
            segments += [
                (*gears, pitch.build_segment_function(stage, second, teeth), px, ph)
                for second in (False, True)
            ]
        return segments

    @cached_property
    def _segment_kernels(self) -> list[Kernel]:
        return [pitch.build_segment_kernel(segment[2]) for segment in self.segments]

    # --- the graph
    # -----------------------------------------------------------------------------------

    def _build(self) -> None:
        f = self.device.functions.prologue_function
        x, c = f.mx_in()
        h = f(x, c)
        inputs = _GraphInputs()
        parts = (self._fixed, self._moving, self._tubes, self._soil, self._teeth)
        rows = [row for part in parts for row in part(x, c, h, inputs)]
        order = [kind.name for kind in self.kinds]
        self.rows = sorted(
            (row for row in rows if row.kind.name in order), key=lambda r: order.index(r.kind.name)
        )
        values, angles = (
            ca.vertcat(*parts)
            for parts in zip(*((r.value, r.angle) for r in self.rows), strict=True)
        )
        inner = ca.Function("rows", [x, c, *inputs.symbols.values()], [values, angles])
        packed = ca.MX.sym("given", sum(s.numel() for s in inputs.symbols.values()))
        ends = np.cumsum([0, *(s.numel() for s in inputs.symbols.values())]).tolist()
        self._order = list(inputs.symbols)
        symbols, names = [x, c, packed], ["x", "c", "given"]
        values, angles = inner(x, c, *ca.vertsplit(packed, ends))
        self._values = Kernel(
            ca.Function("requirements", symbols, [values, angles], names, ["rows", "places"])
        )
        self._slopes = Kernel(
            ca.Function("slopes", symbols, [ca.densify(ca.jacobian(values, x))], names, ["slopes"])
        )
        weights = ca.MX.sym("weights", len(self.rows))
        hessian, _ = ca.hessian(ca.dot(weights, values), x)
        self._hessian = Kernel(
            ca.Function(
                "bent", [*symbols, weights], [ca.densify(hessian)], [*names, "weights"], ["bent"]
            )
        )

    def _fixed(self, x: ca.MX, c: ca.MX, h: ca.MX, inputs: _GraphInputs) -> list[RequirementRow]:
        machine = self.device.machine
        half = SIDE_OFFSET / machine.si("operation.speed_rpm")
        spacing = abs(machine.si("operation.forward_speed_m_s")) * half
        return [self._row("spacing", ca.MX(spacing) + 0 * x[0], ca.MX(0))]

    def _moving(self, x: ca.MX, c: ca.MX, h: ca.MX, inputs: _GraphInputs) -> list[RequirementRow]:
        """Return the rows at the lowest and the highest tip point, and between the nozzles."""
        z, m = ca.vertcat(x, c, h), self.motion
        self._z = z
        self._low = _find_root(lambda phi: m["height"].call([phi, z])[1:], inputs.angle("low"))
        self._high = high = _find_root(
            lambda phi: m["height"].call([phi, z])[1:], inputs.angle("high")
        )
        self._bottom = m["height"](self._low, z)[0]
        low, top = self._low, m["height"](high, z)[0]
        speed_over_ground = m["position"](low, z)[1] * self.device.machine.si("operation.speed_rpm")
        speed = abs(self.device.machine.si("operation.forward_speed_m_s"))
        closest = _find_interior_extremum(
            lambda phi: m["nozzle_distance"].call([phi, z])[1:], inputs.angle("between")
        )
        return [
            self._row("release_tilt", m["tilt"](low, z)[0], low),
            self._row("catching_tilt", m["tilt"](high, z)[0], high),
            self._row("ground_speed_ratio", speed_over_ground / speed, low),
            self._row("path_height", top - self._bottom, high),
            self._row("funnel_speed", m["funnel_speed"](high, z)[0], high),
            self._row("nozzle_distance", m["nozzle_distance"](closest, z)[0], closest),
        ]

    def _tubes(self, x: ca.MX, c: ca.MX, h: ca.MX, inputs: _GraphInputs) -> list[RequirementRow]:
        """Return the rows where the path is nearest to each point."""
        rows = []
        for number, (px, py, tube) in enumerate(self.points):
            at = _find_interior_extremum(
                partial(self._distance_rates, px, py), inputs.angle(_point(number))
            )
            distance = ca.sqrt(
                self.motion["squared_distance"](at, self._z, px, py)[0] + DISTANCE_EPS**2
            )
            rows.append(RequirementRow(BY_NAME["tube_excess"], distance - tube, at, _point(number)))
        return rows

    def _distance_rates(self, px: float, py: float, phi: ca.MX) -> Sequence[ca.MX]:
        rates: Sequence[ca.MX] = self.motion["squared_distance"].call([phi, self._z, px, py])[1:]
        return rates

    def _soil(self, x: ca.MX, c: ca.MX, h: ca.MX, inputs: _GraphInputs) -> list[RequirementRow]:
        """Return the rows while the tip is in the soil, and after."""
        if self.soil is None:
            return []
        z, m, low = self._z, self.motion, self._low
        soil = self.soil.level(self._bottom)
        ends = [
            _find_root(
                lambda phi: _subtract_level(m["height"].call([phi, z]), soil), inputs.angle(n)
            )
            for n in ("enter", "leave")
        ]

        def extreme(name: str, function: Rates, sides: list[ca.MX]) -> ca.MX:
            weights, start = inputs.weights(name), inputs.angle(name)
            interior = _find_interior_extremum(lambda phi: function(phi)[1:], start, weights[2])
            return weights[0] * sides[0] + weights[1] * sides[1] + weights[2] * interior

        tilts = [
            *ends,
            *(
                extreme(n, lambda phi: m["tilt"].call([phi, z]), ends)
                for n in ("tilt high", "tilt low")
            ),
        ]
        cuts = [
            extreme(n, lambda phi: m["ground_intersection"].call([phi, z, soil]), ends)
            for n in ("cut high", "cut low")
        ]
        rows = [self._row("soil_tilt", m["tilt"](phi, z)[0], phi) for phi in tilts]
        rows.append(self._row("depth", soil - self._bottom, low))
        rows.append(
            self._row(
                "hole_length",
                m["ground_intersection"](cuts[0], z, soil)[0]
                - m["ground_intersection"](cuts[1], z, soil)[0],
                cuts[0],
            )
        )
        if "seedling_clearance" in self.names:
            top, plant = soil + self.setting("seedling_height_mm"), m["position"](low, z)[0]
            over = _find_root(
                lambda phi: _subtract_level(m["height"].call([phi, z]), top), inputs.angle("over")
            )
            at = extreme(
                "clearance", lambda phi: m["clearance"].call([phi, z, plant, top]), [ends[1], over]
            )
            free = m["clearance"](at, z, plant, top)[0] - self.setting("seedling_width_mm") / 2
            rows.append(self._row("seedling_clearance", free, at))
        return rows

    def _teeth(self, x: ca.MX, c: ca.MX, h: ca.MX, inputs: _GraphInputs) -> list[RequirementRow]:
        """Return the rows along both segments of both stages: at the ends, and at the extrema."""
        rows = []
        for k, (inner, outer, f, px, ph) in enumerate(self.segments):
            p, q = x[px], h[ph]
            ends = [(ca.MX(u), f(u, p, q)[0]) for u in (0.0, np.pi)]
            for row, subject, name, sign in _tooth_rows(inner, outer):
                if name in self.names:
                    key = f"u {k} {row} {sign}"
                    start, flag = inputs.angle(key), inputs.weights(key)[2]
                    _, first, second = f(start, p, q)
                    u = start - flag * first[row] / _safe(second[row], flag)
                    positions = (*ends, (u, f(u, p, q)[0]))
                    rows += [
                        RequirementRow(BY_NAME[name], v[row], at, subject, k // 2, k % 2 == 1)
                        for at, v in positions
                    ]
        return rows

    def _row(self, name: str, value: ca.MX, angle: ca.MX) -> RequirementRow:
        return RequirementRow(BY_NAME[name], value, angle)

    # --- at a design
    # ---------------------------------------------------------------------------------

    def _evaluate(self, x: Array) -> RowValues:
        at = self.device.prologue(x)
        inputs = self._locate(x, at.h)
        packed = np.concatenate([np.atleast_1d(inputs[name]) for name in self._order])
        rows = self._values(x=x, c=self.device.constants, given=packed)
        return RowValues(x, packed, rows["rows"][:, 0], rows["places"][:, 0])

    def _locate(self, x: Array, h: Array) -> dict[str, Any]:
        """Return the inputs of the graph by name: angles, and at which end an extremum is."""
        z = np.concatenate([x, self.device.constants, h])
        kernel = self.motion.kernel
        tip = locate_tip_cycle(AngleFunction(kernel("height"), z=z), self.soil)
        inputs: dict[str, Any] = {"low": tip.lowest, "high": tip.highest}
        distance = AngleFunction(kernel("nozzle_distance"), z=z)
        inputs["between"] = distance.find_extremum(0, 2 * np.pi, -1, CYCLE_CELLS).angle
        for number, (px, py, _) in enumerate(self.points):
            distance = AngleFunction(kernel("squared_distance"), z=z, first=px, second=py)
            inputs[_point(number)] = distance.find_extremum(0, 2 * np.pi, -1, CYCLE_CELLS).angle
        if self.soil is not None:
            inputs |= self._locate_in_soil(z, tip)
        return inputs | self._locate_on_pitch_curves(x, h)

    def _locate_in_soil(self, z: Array, tip: TipCycle) -> dict[str, Any]:
        kernel = self.motion.kernel
        enter, leave, soil = tip.soil_ends
        tilt = AngleFunction(kernel("tilt"), z=z)
        cut = AngleFunction(kernel("ground_intersection"), z=z, first=soil)
        extremes = {
            f"{name} {word}": function.find_extremum(enter, leave, sign)
            for name, function in (("tilt", tilt), ("cut", cut))
            for word, sign in (("high", 1), ("low", -1))
        }
        inputs: dict[str, Any] = {"enter": enter, "leave": leave}
        if "seedling_clearance" in self.names:
            height = AngleFunction(kernel("height"), z=z)
            top = soil + self.setting("seedling_height_mm")
            inputs["over"] = over = self._find_clear_angle(
                height, top, leave, tip.highest + 2 * np.pi
            )
            plant = float(self.motion.kernel("position")(phi=tip.lowest, z=z)["f"][0, 0])
            extremes["clearance"] = AngleFunction(
                kernel("clearance"), z=z, first=plant, second=top
            ).find_extremum(leave, over, -1)
        return inputs | _name_extrema(extremes)

    def _find_clear_angle(
        self, height: AngleFunction, top: float, leave: float, high: float
    ) -> float:
        """Return where the leaving tip passes the top of the seedling.

        Raises ComputationError if it never does.
        """
        if height.value(high) <= top:
            allowed = "the soil and seedling_height_mm must be less than the height of its path"
            raise ComputationError(f"the tip never rises over the seedling: {allowed}")
        return height.find_crossing(top, leave, high)

    def _locate_on_pitch_curves(self, x: Array, h: Array) -> dict[str, Any]:
        extremes: dict[str, AngleExtreme] = {}
        for k, (inner, outer, _, px, ph) in enumerate(self.segments):
            function = AngleFunction(self._segment_kernels[k], parameters=x[px], hoisted=h[ph])
            for row, _, name, sign in _tooth_rows(inner, outer):
                if name in self.names:
                    extremes[f"u {k} {row} {sign}"] = function.select_row(row).find_extremum(
                        0.0, np.pi, sign, PITCH_CELLS
                    )
        return _name_extrema(extremes)

    def slopes(self, x: Array) -> Array:
        """Return the gradients of the rows, (k, p)."""
        return self._slopes(x=x, c=self.device.constants, given=self.at(x).inputs)["slopes"]

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the weighted sum (p, p) of the rows' Hessians."""
        return self._hessian(
            x=x, c=self.device.constants, given=self.at(x).inputs, weights=weights
        )["bent"]


class _GraphInputs:
    """Inputs of the graph in addition to design and constants, created on first use."""

    def __init__(self) -> None:
        self.symbols: dict[str, ca.MX] = {}

    def angle(self, name: str) -> ca.MX:
        """Return the symbol of an angle."""
        return self.symbols.setdefault(name, ca.MX.sym("angle"))

    def weights(self, name: str) -> ca.MX:
        """Return the weights of low end, high end and interior for an extremum."""
        return self.symbols.setdefault(f"{name}, where", ca.MX.sym("weights", 3))


def _point(number: int) -> str:
    return f"point {number + 1}"


def _name_extrema(extremes: Mapping[str, AngleExtreme]) -> dict[str, Any]:
    inputs: dict[str, Any] = {name: extreme.angle for name, extreme in extremes.items()}
    return inputs | {f"{name}, where": extreme.weights for name, extreme in extremes.items()}


def _tooth_rows(inner: str, outer: str) -> list[tuple[int, str, str, int]]:
    """Return the rows of a segment: index, gears, requirement, and whether the largest or the
    smallest value counts.
    """
    gears = [
        (row, gear, name, sign)
        for row, gear in ((pitch.INNER, inner), (pitch.OUTER, outer))
        for name, sign in zip(pitch.TOOTH[:2], (-1, 1), strict=True)
    ]
    return [*gears, (pitch.RATIO, f"{inner} and {outer}", pitch.TOOTH[2], -1)]


def _find_root(rates: Rates, start: ca.MX) -> ca.MX:
    """Return the angle where the first of `rates` is zero by two Newton steps: exact to its second
    derivative.
    """
    for _ in range(2):
        value, slope = rates(start)
        start = start - value / slope
    return start


def _find_interior_extremum(rates: Rates, start: ca.MX, flag: ca.MX | float = 1.0) -> ca.MX:
    """Return the interior extremum after one Newton step, which suffices because the value is
    stationary there.

    Where `flag` is 0, the extremum is at an end and the start is returned.
    """
    first, second = rates(start)
    return start - flag * first / _safe(second, flag)


def _safe(second: ca.MX, flag: ca.MX | float) -> ca.MX:
    usable = ca.logic_and(ca.MX(flag) > 0, ca.fabs(second) > 1e-12)
    return ca.if_else(usable, second, 1.0)


def _subtract_level(function: Sequence[ca.MX], level: ca.MX) -> tuple[ca.MX, ca.MX]:
    return function[0] - level, function[1]
