"""The reference cycle of the planting device: every quantity at carrier angles, from the built-in machine's file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf

from ...evaluate import DIGITS, GUARD, MachineFile, Point
from ...formulas import value
from ...gearing import pitch_curve
from ...gearing.families import FAMILIES
from ...gearing.pitch_curve import PitchCurve
from ...model import Call, Lane, Let, Step
from ...quantity import Quantity
from . import derivation, flanks
from . import quantities as q

MACHINE = Path(__file__).parents[3] / "planter" / "planting" / "examples" / "wang2017.toml"
WORKING_DIGITS = 25
Composed = Mapping[str, Callable[[Any], tuple[Any, ...]]]
"""Functions that are composed at run time, by name: contacts of the stages, and the law of the cam's flanks."""


class Gears:
    """A pitch curve in numbers: contact with its conjugate at a polar angle."""

    def __init__(self, curve: PitchCurve, values: dict[sp.Symbol, Any]) -> None:
        self.curve, self.values, self.ratio = curve, values, curve.ratio()
        self.steps = (*pitch_curve.parameter_steps(), *pitch_curve.contact_steps(curve))
        self.distance = self._closed()
        self.contact = cache(self._contact)
        """r, dr, ddr, ratio, dratio, turned at a polar angle, found once: that at phi = 0 is asked for often."""

    def _closed(self) -> Any:
        known = self.curve.centre_distance()
        if isinstance(known, sp.Expr):
            return Point(self.values)(known)
        most = Point({**self.values, pitch_curve.u: 0})(self.curve.radius())
        bracket = (most * mpf("1.02"), 4 * most)
        return mpmath.findroot(lambda a: self._turned(mpmath.pi, a) - mpmath.pi, bracket, solver="anderson")

    def _turned(self, u: Any, a: Any) -> Any:
        known = {**self.values, pitch_curve.a: a}

        def ratio(v: Any) -> mpf:
            with mpmath.workdps(DIGITS + GUARD):
                return value(self.ratio, known | {pitch_curve.u: v})

        return mpmath.quad(ratio, [0, u])

    def _contact(self, t: Any) -> tuple[Any, ...]:
        point = Point({**self.values, pitch_curve.a: self.distance, pitch_curve.t: t})
        for step in self.steps:
            if step.symbol == pitch_curve.turned:
                u = point(pitch_curve.u)
                point.set(pitch_curve.ahead, self._turned(u, self.distance) - u)
            point.set(step.symbol, point(step.expr))
        return tuple(point(symbol) for symbol in pitch_curve.CONTACT)


def reference(points: int) -> list[dict[sp.Symbol, mpf]]:
    """All quantities of side 1, those of side 2 and the totals at ``points`` carrier angles of a turn."""
    with mpmath.workdps(WORKING_DIGITS):
        machine = MachineFile.read(MACHINE)
        fixed = {s: in_si(machine, s.shown) for s in (*q.MACHINE, *q.MOUNTING)}
        gears = {f"stage{i}": stage_gears(machine, i, suffix) for i, suffix in ((1, "3"), (2, "6"))}
        fixed |= distances_and_deformations(gears)
        lane, functions = derivation.exact_lane(), composed(machine, gears)
        return [_angle(fixed, functions, lane, 2 * mpmath.pi * k / points) for k in range(points)]


def composed(machine: MachineFile, gears: Mapping[str, Gears]) -> Composed:
    """What the lane of a machine calls."""
    law = flanks.law(machine.tables["cam"]["flank"])

    def flank(x: Any) -> tuple[Any, ...]:
        point = Point({flanks.x: x})
        return tuple(point(expr) for expr in law)

    return {name: stage.contact for name, stage in gears.items()} | {flanks.FLANK.name: flank}


def distances_and_deformations(gears: Mapping[str, Gears]) -> dict[sp.Symbol, Any]:
    """What the lane takes of both stages beside their contacts."""
    first, second = gears["stage1"], gears["stage2"]
    coefficients = {q.m31: first.values[pitch_curve.m], q.m61: second.values[pitch_curve.m]}
    return {q.a1: first.distance, q.a2: second.distance, **coefficients}


def stage_gears(machine: MachineFile, stage: int, suffix: str) -> Gears:
    """The pitch curve of a gear stage of a machine file; ``suffix`` is the number of its inner gear."""
    curve = FAMILIES[machine.tables[f"stage{stage}"]["family"]]
    values: dict[sp.Symbol, Any] = {}
    for parameter in curve.parameters:
        base, dash, unit = parameter.shown.partition("_")
        values[parameter] = in_si(machine, f"{base}{suffix}{dash}{unit}")
    return Gears(curve, values | {pitch_curve.m: in_si(machine, f"m{suffix}1")})


def in_si(machine: MachineFile, shown: str) -> mpf:
    """A number of the machine file in SI: a design parameter, or ``section.key[index]``."""
    return machine.si(shown if "." in shown else f"design.{shown}")


def _angle(fixed: dict[sp.Symbol, Any], functions: Composed, lane: Lane, phi: Any) -> dict[sp.Symbol, mpf]:
    one = one_side({**fixed, q.phi: phi}, functions, lane.steps)
    two = one_side({**fixed, q.phi: phi - mpmath.pi}, functions, lane.steps)
    both = Point(one | {q.twin(s): v for s, v in two.items() if isinstance(s, Quantity)})
    for step in lane.shared.steps if lane.shared else ():
        both.set(step.symbol, both(step.expr))
    return both.values()


def one_side(known: Mapping[sp.Symbol, Any], functions: Composed, steps: Iterable[Step]) -> dict[sp.Symbol, mpf]:
    """What is known (machine, mounting, carrier angle), and every quantity that steps of a lane find from it."""
    point = Point(known)
    for step in steps:
        if isinstance(step, Let):
            point.set(step.symbol, point(step.expr))
        elif isinstance(step, Call):
            found = functions[step.function.name](point(step.argument))
            for symbol, value in zip(step.outputs, found, strict=True):
                if symbol is not None:
                    point.set(symbol, value)
    return point.values()
