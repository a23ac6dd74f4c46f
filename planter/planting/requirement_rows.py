"""Requirements of a device as rows: smooth functions of the design near a point, with exact derivatives.

Each row is a number at angles that the design moves: the lowest tip point, the ends of the soil, extremes between
them. Near a design such an angle is one Newton step from the angle found there (two for the second derivative of what
is not stationary in it), so that differentiating the row differentiates the angle implicitly. Rows of extremes are
smooth but where two extremes change places.
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
from planter.planting import angle_functions as pitch
from planter.planting.angle_functions import PITCH, TURN, AngleExtreme, AngleFunction, Soil, TipCycle, locate_tip_cycle
from planter.planting.model import Device
from planter.planting.nozzle_motion import HAIR, HALF, NozzleMotion
from planter.planting.requirements_section import BY_NAME, SOIL_LINE, RequirementKind

ABSOLUTE = ("release_tilt", "soil_tilt", "ground_speed_ratio", "catching_tilt")
"""Requirements whose rows have a sign, the limit being on their size."""
STRICT = 1e-3
"""What is to be above a limit, not at it, is kept this far from it: a curvature [1/m]."""
Rates = Callable[[ca.MX], Sequence[ca.MX]]
_GEARS = ("sun", "gear 5", "gear 6", "planet")


@dataclass(frozen=True)
class RequirementRow:
    """A row: its requirement, where it stands, and the gear or contact that it speaks of, if any.

    A row along a pitch curve knows its `stage`, 0 or 1, and whether it lies in the curve's second segment.
    """

    kind: RequirementKind
    value: ca.MX
    angle: ca.MX
    of: str = ""
    stage: int = 0
    second: bool = False


@dataclass(frozen=True)
class RowValues:
    """Rows at a design: values (k,) in SI and where each stands (k,): phi, or u for pitch curves [rad]."""

    x: Array
    given: Array
    values: Array
    places: Array


class RequirementRows:
    """The rows of a device's requirements. Designs x are (p,) in SI.

    Raises ComputationError where a design has no such rows: its tip never leaves the soil.
    """

    def __init__(self, device: Device) -> None:
        section: Any = device.machine.requirements
        if section is None:
            raise InputError(f"{device.machine.source}: requirements is missing: the file sets none")
        self.device, self.section, self.motion = device, section, NozzleMotion(device)
        self.kinds: tuple[RequirementKind, ...] = section.kinds
        self.names = {kind.name for kind in self.kinds}
        self.at = LastCallCache(self._found)
        self._build()

    def setting(self, name: str) -> float:
        """A setting of the section in SI."""
        return float(getattr(self.section, name)) * 1e-3

    @cached_property
    def soil(self) -> Soil | None:
        """Where the soil stands; None where no requirement speaks of it."""
        if not any("soil_depth_mm" in kind.needs for kind in self.kinds):
            return None
        line = getattr(self.section, SOIL_LINE)
        return Soil(depth=self.setting("soil_depth_mm")) if line is None else Soil(line=line * 1e-3)

    @cached_property
    def points(self) -> Array:
        """Points that the tip must pass with the radii of their tubes, (n, 3) [m]."""
        named = self.section.points_mm if "tube_excess" in self.names else None
        return 1e-3 * np.array(named or np.empty((0, 3)))

    @cached_property
    def segments(self) -> list[tuple[str, str, ca.Function, slice, slice]]:
        """Segments of both stages: inner and outer gear, their rows, and what of x and h they take."""
        module = self.setting("module_mm") if "contact_ratio" in self.names else 1e-3
        teeth = pitch.RackTeeth(module, self.device.machine.si("contact.pressure_angle_deg"))
        start, hoisted, found = len(self.device.sidecar["vectors"]["mounting"]), 0, []
        for stage, gears in zip(self.device.stages, (_GEARS[:2], _GEARS[2:]), strict=True):
            px = slice(start, start + len(stage.names))
            ph = slice(hoisted, hoisted + 1 + stage.terms)
            start, hoisted = px.stop, ph.stop
            found += [(*gears, pitch.build_segment_function(stage, second, teeth), px, ph) for second in (False, True)]
        return found

    @cached_property
    def _segment_kernels(self) -> list[Kernel]:
        return [pitch.build_segment_kernel(segment[2]) for segment in self.segments]

    # --- the graph -----------------------------------------------------------------------------------

    def _build(self) -> None:
        f = self.device.functions.prologue_function
        x, c = f.mx_in()
        h = f(x, c)
        given = _Given()
        parts = (self._fixed, self._moving, self._tubes, self._soil, self._teeth)
        rows = [row for part in parts for row in part(x, c, h, given)]
        order = [kind.name for kind in self.kinds]
        self.rows = sorted((row for row in rows if row.kind.name in order), key=lambda r: order.index(r.kind.name))
        values, angles = (ca.vertcat(*parts) for parts in zip(*((r.value, r.angle) for r in self.rows), strict=True))
        inner = ca.Function("rows", [x, c, *given.symbols.values()], [values, angles])
        packed = ca.MX.sym("given", sum(s.numel() for s in given.symbols.values()))
        ends = np.cumsum([0, *(s.numel() for s in given.symbols.values())]).tolist()
        self._order = list(given.symbols)
        inputs, names = [x, c, packed], ["x", "c", "given"]
        values, angles = inner(x, c, *ca.vertsplit(packed, ends))
        self._values = Kernel(ca.Function("requirements", inputs, [values, angles], names, ["rows", "places"]))
        self._slopes = Kernel(ca.Function("slopes", inputs, [ca.densify(ca.jacobian(values, x))], names, ["slopes"]))
        weights = ca.MX.sym("weights", len(self.rows))
        bent, _ = ca.hessian(ca.dot(weights, values), x)
        self._bent = Kernel(ca.Function("bent", [*inputs, weights], [ca.densify(bent)], [*names, "weights"], ["bent"]))

    def _fixed(self, x: ca.MX, c: ca.MX, h: ca.MX, given: _Given) -> list[RequirementRow]:
        machine = self.device.machine
        half = HALF / machine.si("operation.speed_rpm")
        spacing = abs(machine.si("operation.forward_speed_m_s")) * half
        return [self._row("spacing", ca.MX(spacing) + 0 * x[0], ca.MX(0))]

    def _moving(self, x: ca.MX, c: ca.MX, h: ca.MX, given: _Given) -> list[RequirementRow]:
        """At the lowest and the highest tip point, and between the nozzles."""
        z, m = ca.vertcat(x, c, h), self.motion
        self._z = z
        self._low = _root(lambda phi: m.height.call([phi, z])[1:], given.angle("low"))
        self._high = high = _root(lambda phi: m.height.call([phi, z])[1:], given.angle("high"))
        self._bottom = m.height(self._low, z)[0]
        low, top = self._low, m.height(high, z)[0]
        along = m.place(low, z)[1] * self.device.machine.si("operation.speed_rpm")
        speed = abs(self.device.machine.si("operation.forward_speed_m_s"))
        apart = _inside(lambda phi: m.between.call([phi, z])[1:], given.angle("between"))
        return [
            self._row("release_tilt", m.tilt(low, z)[0], low), self._row("catching_tilt", m.tilt(high, z)[0], high),
            self._row("ground_speed_ratio", along / speed, low), self._row("path_height", top - self._bottom, high),
            self._row("funnel_speed", m.funnel_speed(high, z), high),
            self._row("nozzle_distance", m.between(apart, z)[0], apart),
        ]  # fmt: skip

    def _tubes(self, x: ca.MX, c: ca.MX, h: ca.MX, given: _Given) -> list[RequirementRow]:
        """Where the path is nearest to each point."""
        found = []
        for number, (px, py, tube) in enumerate(self.points):
            at = _inside(partial(self._apart_rates, px, py), given.angle(_point(number)))
            distance = ca.sqrt(self.motion.apart(at, self._z, px, py)[0] + HAIR**2)
            found.append(RequirementRow(BY_NAME["tube_excess"], distance - tube, at, _point(number)))
        return found

    def _apart_rates(self, px: float, py: float, phi: ca.MX) -> Sequence[ca.MX]:
        found: Sequence[ca.MX] = self.motion.apart.call([phi, self._z, px, py])[1:]
        return found

    def _soil(self, x: ca.MX, c: ca.MX, h: ca.MX, given: _Given) -> list[RequirementRow]:
        """While the tip is in the soil, and after."""
        if self.soil is None:
            return []
        z, m, low = self._z, self.motion, self._low
        soil = self.soil.level(self._bottom)
        ends = [_root(lambda phi: _passing(m.height.call([phi, z]), soil), given.angle(n)) for n in ("enter", "leave")]

        def extreme(name: str, course: Rates, sides: list[ca.MX]) -> ca.MX:
            weights, start = given.weights(name), given.angle(name)
            within = _inside(lambda phi: course(phi)[1:], start, weights[2])
            return weights[0] * sides[0] + weights[1] * sides[1] + weights[2] * within

        tilts = [*ends, *(extreme(n, lambda phi: m.tilt.call([phi, z]), ends) for n in ("tilt high", "tilt low"))]
        cuts = [extreme(n, lambda phi: m.cut.call([phi, z, soil]), ends) for n in ("cut high", "cut low")]
        found = [self._row("soil_tilt", m.tilt(phi, z)[0], phi) for phi in tilts]
        found.append(self._row("depth", soil - self._bottom, low))
        found.append(self._row("hole_length", m.cut(cuts[0], z, soil)[0] - m.cut(cuts[1], z, soil)[0], cuts[0]))
        if "seedling_clearance" in self.names:
            top, plant = soil + self.setting("seedling_height_mm"), m.place(low, z)[0]
            over = _root(lambda phi: _passing(m.height.call([phi, z]), top), given.angle("over"))
            at = extreme("clearance", lambda phi: m.clearance.call([phi, z, plant, top]), [ends[1], over])
            free = m.clearance(at, z, plant, top)[0] - self.setting("seedling_width_mm") / 2
            found.append(self._row("seedling_clearance", free, at))
        return found

    def _teeth(self, x: ca.MX, c: ca.MX, h: ca.MX, given: _Given) -> list[RequirementRow]:
        """Along both segments of both stages: at the ends, and at the extremes."""
        found = []
        for k, (inner, outer, f, px, ph) in enumerate(self.segments):
            p, q = x[px], h[ph]
            ends = [(ca.MX(u), f(u, p, q)[0]) for u in (0.0, np.pi)]
            for row, of, name, sign in _tooth_rows(inner, outer):
                if name in self.names:
                    key = f"u {k} {row} {sign}"
                    start, flag = given.angle(key), given.weights(key)[2]
                    _, first, second = f(start, p, q)
                    u = start - flag * first[row] / _safe(second[row], flag)
                    everywhere = (*ends, (u, f(u, p, q)[0]))
                    found += [RequirementRow(BY_NAME[name], v[row], at, of, k // 2, k % 2 == 1) for at, v in everywhere]
        return found

    def _row(self, name: str, value: ca.MX, angle: ca.MX) -> RequirementRow:
        return RequirementRow(BY_NAME[name], value, angle)

    # --- at a design ---------------------------------------------------------------------------------

    def _found(self, x: Array) -> RowValues:
        at = self.device.prologue(x)
        given = self._given(x, at.h)
        packed = np.concatenate([np.atleast_1d(given[name]) for name in self._order])
        found = self._values(x=x, c=self.device.constants, given=packed)
        return RowValues(x, packed, found["rows"][:, 0], found["places"][:, 0])

    def _given(self, x: Array, h: Array) -> dict[str, Any]:
        """Angles, and which end an extreme stands at, by the names in the graph."""
        z = np.concatenate([x, self.device.constants, h])
        kernels = self.motion.course_kernels
        place = locate_tip_cycle(AngleFunction(kernels["height"], z=z), self.soil)
        given: dict[str, Any] = {"low": place.low, "high": place.high}
        given["between"] = AngleFunction(kernels["between"], z=z).extreme(0, 2 * np.pi, -1, TURN).place
        for number, (px, py, _) in enumerate(self.points):
            near = AngleFunction(kernels["apart"], z=z, first=px, second=py)
            given[_point(number)] = near.extreme(0, 2 * np.pi, -1, TURN).place
        if self.soil is not None:
            given |= self._in_soil(z, place)
        return given | self._on_pitch_curves(x, h)

    def _in_soil(self, z: Array, place: TipCycle) -> dict[str, Any]:
        kernels = self.motion.course_kernels
        enter, leave, soil = place.soil_ends
        tilt, cut = AngleFunction(kernels["tilt"], z=z), AngleFunction(kernels["cut"], z=z, first=soil)
        extremes = {
            f"{name} {word}": course.extreme(enter, leave, sign)
            for name, course in (("tilt", tilt), ("cut", cut))
            for word, sign in (("high", 1), ("low", -1))
        }
        given: dict[str, Any] = {"enter": enter, "leave": leave}
        if "seedling_clearance" in self.names:
            height = AngleFunction(kernels["height"], z=z)
            top = soil + self.setting("seedling_height_mm")
            given["over"] = over = self._over(height, top, leave, place.high + 2 * np.pi)
            plant = self._plant(z, place.low)
            extremes["clearance"] = AngleFunction(kernels["clearance"], z=z, first=plant, second=top).extreme(
                leave, over, -1
            )
        return given | _named(extremes)

    def _over(self, height: AngleFunction, top: float, leave: float, high: float) -> float:
        """Where the leaving tip passes the top of the seedling; the highest point where it never does."""
        if height.value(high) <= top:
            allowed = "the soil and seedling_height_mm must be less than the height of its path"
            raise ComputationError(f"the tip never rises over the seedling: {allowed}")
        return height.crossing(top, leave, high)

    def _plant(self, z: Array, low: float) -> float:
        return float(self.motion.place_kernel(phi=low, z=z)["f"][0, 0])

    def _on_pitch_curves(self, x: Array, h: Array) -> dict[str, Any]:
        found: dict[str, AngleExtreme] = {}
        for k, (inner, outer, _, px, ph) in enumerate(self.segments):
            course = AngleFunction(self._segment_kernels[k], parameters=x[px], hoisted=h[ph])
            for row, _, name, sign in _tooth_rows(inner, outer):
                if name in self.names:
                    found[f"u {k} {row} {sign}"] = course.of_row(row).extreme(0.0, np.pi, sign, PITCH)
        return _named(found)

    def slopes(self, x: Array) -> Array:
        """Gradients of the rows, (k, p)."""
        found = self.at(x)
        return self._slopes(x=x, c=self.device.constants, given=found.given)["slopes"]

    def curvature(self, x: Array, weights: Array) -> Array:
        """Weighted sum (p, p) of the Hessians of the rows."""
        found = self.at(x)
        return self._bent(x=x, c=self.device.constants, given=found.given, weights=weights)["bent"]


class _Given:
    """Inputs of the graph beside design and constants, made as they are asked for."""

    def __init__(self) -> None:
        self.symbols: dict[str, ca.MX] = {}

    def angle(self, name: str) -> ca.MX:
        return self.symbols.setdefault(name, ca.MX.sym("angle"))

    def weights(self, name: str) -> ca.MX:
        """Of the low end, the high end and the inside for an extreme."""
        return self.symbols.setdefault(f"{name}, where", ca.MX.sym("weights", 3))


def _point(number: int) -> str:
    return f"point {number + 1}"


def _named(extremes: Mapping[str, AngleExtreme]) -> dict[str, Any]:
    places: dict[str, Any] = {name: found.place for name, found in extremes.items()}
    return places | {f"{name}, where": found.weights for name, found in extremes.items()}


def _tooth_rows(inner: str, outer: str) -> list[tuple[int, str, str, int]]:
    """Rows of a segment: which, on which gears, for which requirement, and whether the largest or the least counts."""
    gears = [(row, of, name, sign) for row, of in ((pitch.INNER, inner), (pitch.OUTER, outer))
             for name, sign in zip(pitch.TOOTH[:2], (-1, 1), strict=True)]  # fmt: skip
    return [*gears, (pitch.RATIO, f"{inner} and {outer}", pitch.TOOTH[2], -1)]


def _root(rates: Rates, start: ca.MX) -> ca.MX:
    """The angle where the first of `rates` is zero, by two Newton steps: exact to its second derivative."""
    for _ in range(2):
        value, slope = rates(start)
        start = start - value / slope
    return start


def _inside(rates: Rates, start: ca.MX, flag: ca.MX | float = 1.0) -> ca.MX:
    """The same for an extreme inside, where `flag` is 1: one step, since the extreme itself does not feel the rest."""
    first, second = rates(start)
    return start - flag * first / _safe(second, flag)


def _safe(second: ca.MX, flag: ca.MX | float) -> ca.MX:
    usable = ca.logic_and(ca.MX(flag) > 0, ca.fabs(second) > 1e-12)
    return ca.if_else(usable, second, 1.0)


def _passing(course: Sequence[ca.MX], level: ca.MX) -> tuple[ca.MX, ca.MX]:
    return course[0] - level, course[1]
