"""The audit subject of frames and points without bodies: any configuration, velocities and
accelerations.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from functools import cached_property

import mpmath
import sympy as sp
from mpmath import mpf

from ...equations import (
    Claimed,
    Equation,
    by_claim,
    defining_equation,
    derived_equation,
    loop,
    what,
)
from ...evaluate import DIGITS, GUARD, Point
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...quantity import Quantity
from ..paper import Subject
from .subject import Values, draw_values, mechanism_values

TRIALS = 50
REACH = {"rad": 1.2}
"""Largest value of a coordinate, by its unit; 1 of any other."""
NEARBY = 8


class ConfigurationSubject(Subject):
    """Frames and points at random values of their coordinates, rates and accelerations.

    The values satisfy the loops, and the rates and accelerations also what rolls without slip.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        loops = mechanism.loops
        self._solved = [c for c in loops.coordinates if c.value in loops.start][: len(loops.gaps)]
        if len(self._solved) < len(loops.gaps):
            raise MechanismError(
                f"{mechanism.name}: {len(loops.gaps)} gaps need a start of as many coordinates, "
                f"not {len(self._solved)}"
            )

    @property
    def quantities(self) -> frozenset[Quantity]:
        """All quantities that have a value."""
        named = (let.symbol for let in self.mechanism.named)
        return frozenset((*self.mechanism.given.values(), *self.mechanism.loops.all, *named))

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return definitions of named quantities, and the gaps of loops."""
        gaps = self.mechanism.loops.gaps.items()
        return by_claim(
            (
                *(
                    defining_equation(what(let.symbol), let.symbol, let.expr)
                    for let in self.mechanism.named
                ),
                *(derived_equation(loop(name.removeprefix("gap_")), gap) for name, gap in gaps),
            )
        )

    @cached_property
    def _stages(self) -> tuple[list[sp.Expr], list[sp.Expr], list[sp.Expr]]:
        """The gaps, their rates with the slips, and the rates of those."""
        gaps = [sp.sympify(gap) for gap in self.mechanism.loops.gaps.values()]
        slips = [sp.sympify(slip) for slip in self.mechanism.slips.values()]
        rates = [*(sp.sympify(self.mechanism.motion.rate(gap)) for gap in gaps), *slips]
        return gaps, rates, [sp.sympify(self.mechanism.motion.rate(rate)) for rate in rates]

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Draw data and a configuration with its rates.

        Raises MechanismError if the loops close for no draw.
        """
        with mpmath.workdps(DIGITS + GUARD):
            for _ in range(TRIALS):
                values = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
                if self.mechanism.angle is not None:
                    values[self.mechanism.angle] = mpf(rng.uniform(0, 2 * float(mpmath.pi)))
                try:
                    return self._complete(values, rng)
                except (ValueError, ZeroDivisionError):
                    continue
        raise MechanismError(
            f"{self.mechanism.name}: its loops close nowhere near the values that are given"
        )

    def _complete(self, values: Values, rng: random.Random) -> Values:
        """Return values with those of coordinates, rates, accelerations and named quantities."""
        solved = self._solved
        for let in self.mechanism.named:
            if let.expr.free_symbols <= values.keys():
                values[let.symbol] = Point(values)(let.expr)
        for coordinate in self.mechanism.loops.coordinates:
            for part in (coordinate.value, coordinate.rate, coordinate.acceleration):
                reach = REACH.get(part.unit, 1.0)
                values[part] = mpf(rng.uniform(-reach, reach))
        if solved:
            start = [Point(values)(self.mechanism.loops.start[c.value]) for c in solved]
            tolerance = mpf(10) ** (8 - 2 * mpmath.mp.dps)
            solution = mpmath.findroot(lambda *x: self._gaps_at(values, x), start, tol=tolerance)
            values |= zip((c.value for c in solved), list(solution), strict=True)
        _, rates, accelerations = self._stages
        if self.mechanism.slips:
            coordinates = self.mechanism.loops.coordinates
            for residuals, jacobian, unknowns in (
                (rates, self._jacobians[0], [c.rate for c in coordinates]),
                (accelerations, self._jacobians[1], [c.acceleration for c in coordinates]),
            ):
                values |= self._project(residuals, jacobian, unknowns, values)
        elif solved:
            values |= self._solve_linear(rates, [c.rate for c in solved], values)
            values |= self._solve_linear(accelerations, [c.acceleration for c in solved], values)
        for let in self.mechanism.named:
            values[let.symbol] = Point(values)(let.expr)
        return values

    def _gaps_at(self, values: Values, solution: Sequence[mpf]) -> list[mpf]:
        point = Point(values | dict(zip((c.value for c in self._solved), solution, strict=True)))
        return [point(gap) for gap in self._stages[0]]

    @staticmethod
    def _solve_linear(
        residuals: Sequence[sp.Expr], unknowns: Sequence[Quantity], values: Values
    ) -> Values:
        matrix, right = sp.linear_eq_to_matrix(residuals, list(unknowns))
        point = Point(values)
        size = len(unknowns)
        system = mpmath.matrix([[point(matrix[i, j]) for j in range(size)] for i in range(size)])
        solution = mpmath.lu_solve(system, mpmath.matrix([point(right[i]) for i in range(size)]))
        return dict(zip(unknowns, solution, strict=True))

    @cached_property
    def _jacobians(self) -> tuple[list[list[sp.Expr]], list[list[sp.Expr]]]:
        """The derivatives of the rates to those of the coordinates, and of the accelerations to
        accelerations.
        """
        coordinates = self.mechanism.loops.coordinates
        _, rates, accelerations = self._stages
        return (
            [[rate.diff(c.rate) for c in coordinates] for rate in rates],
            [
                [acceleration.diff(c.acceleration) for c in coordinates]
                for acceleration in accelerations
            ],
        )

    @staticmethod
    def _project(
        residuals: Sequence[sp.Expr],
        derivatives: Sequence[Sequence[sp.Expr]],
        unknowns: Sequence[Quantity],
        values: Values,
    ) -> Values:
        """Return the values of ``unknowns`` nearest to the present ones at which residuals, linear
        in them, vanish.
        """
        point = Point(values)
        jacobian = mpmath.matrix([[point(entry) for entry in row] for row in derivatives])
        present = mpmath.matrix([point(residual) for residual in residuals])
        change = jacobian.T * mpmath.lu_solve(jacobian * jacobian.T, present)
        return {unknown: values[unknown] - change[index] for index, unknown in enumerate(unknowns)}

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return the values of random configurations, since nothing moves the mechanism along a
        cycle.
        """
        return [self.admissible(random.Random(1000 + index)) for index in range(points)]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return further configurations."""
        return [self.admissible(rng) for _ in range(NEARBY)]


def is_free_of_bodies(mechanism: Mechanism) -> bool:
    """Return whether a mechanism states frames and points alone, so that only its kinematics can be
    judged.
    """
    return all(body == mechanism.ground for body in mechanism.assembly.bodies)
