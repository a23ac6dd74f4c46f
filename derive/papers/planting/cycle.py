"""The reference cycle of the planting device: all quantities of the built-in machine at carrier
angles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf

from ...evaluate import DIGITS, GUARD, MachineFile, Point
from ...formulas import evaluate_expression
from ...mechanics.gearing import pitch_curve
from ...mechanics.gearing.families import FAMILIES
from ...mechanics.gearing.pitch_curve import PitchCurve
from ...model import Call, Lane, Let, Step
from ...quantity import Quantity
from . import derivation, flanks
from . import quantities as q

MACHINE = (
    Path(__file__).parents[3] / "planter" / "papers" / "planting" / "examples" / "wang2017.toml"
)
WORKING_DIGITS = 25
RuntimeFunctions = Mapping[str, Callable[[Any], tuple[Any, ...]]]
"""Functions that are selected at run time, by name: contacts of the stages, and the law of the
cam's flanks.
"""


class NumericGearPair:
    """A pitch curve with values: contact with its conjugate at a polar angle."""

    def __init__(self, curve: PitchCurve, values: dict[sp.Symbol, Any]) -> None:
        self.curve, self.values, self.ratio = curve, values, curve.ratio()
        self.steps = (*pitch_curve.parameter_steps(), *pitch_curve.contact_steps(curve))
        self.distance = self._close_pair()
        self.contact = cache(self._contact)
        """r, dr, ddr, ratio, dratio, turned at a polar angle, cached since that at phi = 0 is
        needed often.
        """

    def _close_pair(self) -> Any:
        """Return the centre distance [m] at which the conjugate turns once per revolution."""
        distance = self.curve.centre_distance()
        if isinstance(distance, sp.Expr):
            return Point(self.values)(distance)
        largest = Point({**self.values, pitch_curve.u: 0})(self.curve.radius())
        bracket = (largest * mpf("1.02"), 4 * largest)
        return mpmath.findroot(
            lambda a: self._integrate_ratio(mpmath.pi, a) - mpmath.pi, bracket, solver="anderson"
        )

    def _integrate_ratio(self, u: Any, a: Any) -> Any:
        values = {**self.values, pitch_curve.a: a}

        def ratio(v: Any) -> mpf:
            with mpmath.workdps(DIGITS + GUARD):
                return evaluate_expression(self.ratio, values | {pitch_curve.u: v})

        return mpmath.quad(ratio, [0, u])

    def _contact(self, t: Any) -> tuple[Any, ...]:
        point = Point({**self.values, pitch_curve.a: self.distance, pitch_curve.t: t})
        for step in self.steps:
            if step.symbol == pitch_curve.turned:
                u = point(pitch_curve.u)
                point.set(pitch_curve.ahead, self._integrate_ratio(u, self.distance) - u)
            point.set(step.symbol, point(step.expr))
        return tuple(point(symbol) for symbol in pitch_curve.CONTACT)


def compute_reference_cycle(points: int) -> list[dict[sp.Symbol, mpf]]:
    """Return all quantities of both sides and the totals at ``points`` carrier angles of a
    revolution.
    """
    with mpmath.workdps(WORKING_DIGITS):
        machine = MachineFile.read(MACHINE)
        fixed = {s: read_si(machine, s.shown) for s in (*q.MACHINE, *q.MOUNTING)}
        gears = {f"stage{i}": stage_gears(machine, i, suffix) for i, suffix in ((1, "3"), (2, "6"))}
        fixed |= distances_and_deformations(gears)
        lane, functions = derivation.exact_lane(), build_runtime_functions(machine, gears)
        return [
            _evaluate_angle(fixed, functions, lane, 2 * mpmath.pi * k / points)
            for k in range(points)
        ]


def build_runtime_functions(
    machine: MachineFile, gears: Mapping[str, NumericGearPair]
) -> RuntimeFunctions:
    """Return the functions that the lane of a machine calls."""
    law = flanks.derive_flank_law(machine.tables["cam"]["flank"])

    def flank(x: Any) -> tuple[Any, ...]:
        point = Point({flanks.x: x})
        return tuple(point(expr) for expr in law)

    return {name: stage.contact for name, stage in gears.items()} | {flanks.FLANK.name: flank}


def distances_and_deformations(gears: Mapping[str, NumericGearPair]) -> dict[sp.Symbol, Any]:
    """Return the inputs of the lane from both stages: centre distances and deformation
    coefficients.
    """
    first, second = gears["stage1"], gears["stage2"]
    coefficients = {q.m31: first.values[pitch_curve.m], q.m61: second.values[pitch_curve.m]}
    return {q.a1: first.distance, q.a2: second.distance, **coefficients}


def stage_gears(machine: MachineFile, stage: int, suffix: str) -> NumericGearPair:
    """Return the pitch curve of a gear stage of a machine file; ``suffix`` is the number of its
    inner gear.
    """
    curve = FAMILIES[machine.tables[f"stage{stage}"]["family"]]
    values: dict[sp.Symbol, Any] = {}
    for parameter in curve.parameters:
        base, dash, unit = parameter.shown.partition("_")
        values[parameter] = read_si(machine, f"{base}{suffix}{dash}{unit}")
    return NumericGearPair(curve, values | {pitch_curve.m: read_si(machine, f"m{suffix}1")})


def read_si(machine: MachineFile, key: str) -> mpf:
    """Return a number of the machine file in SI: a design parameter, or ``section.key[index]``."""
    return machine.si(key if "." in key else f"design.{key}")


def _evaluate_angle(
    fixed: dict[sp.Symbol, Any], functions: RuntimeFunctions, lane: Lane, phi: Any
) -> dict[sp.Symbol, mpf]:
    side1 = evaluate_side({**fixed, q.phi: phi}, functions, lane.steps)
    side2 = evaluate_side({**fixed, q.phi: phi - mpmath.pi}, functions, lane.steps)
    both = Point(side1 | {q.twin(s): v for s, v in side2.items() if isinstance(s, Quantity)})
    for step in lane.shared.steps if lane.shared else ():
        both.set(step.symbol, both(step.expr))
    return both.values()


def evaluate_side(
    values: Mapping[sp.Symbol, Any], functions: RuntimeFunctions, steps: Iterable[Step]
) -> dict[sp.Symbol, mpf]:
    """Return the values (machine, mounting, carrier angle) with every quantity that steps of a lane
    give.
    """
    point = Point(values)
    for step in steps:
        if isinstance(step, Let):
            point.set(step.symbol, point(step.expr))
        elif isinstance(step, Call):
            results = functions[step.function.name](point(step.argument))
            for symbol, result in zip(step.outputs, results, strict=True):
                if symbol is not None:
                    point.set(symbol, result)
    return point.values()
