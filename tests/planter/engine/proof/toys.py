"""Small objectives: of a curve with kinks over boxes of three parameters, and of two parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from planter.engine.proof.continuation import AssemblyStart
from planter.engine.proof.enclosures import (
    Kinks,
    ResponseProgram,
    RootBranch,
    list_angles,
    list_samples,
)
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import Jet, Space
from planter.engine.proof.objective import (
    BoundedMeasure,
    Box,
    ObjectiveBounds,
    ProvableObjective,
)
from planter.engine.proof.programs import record_program
from planter.kernels import Array

Y = 0.9
"""Extent of a box that has no bound."""
RING_BEST = np.array([-1.012274, 0.0])
"""Where the objective is least: 4 x (x^2 - 1) + 0.1 = 0."""


class Ring:
    """f = (x^2 + y^2 - 1)^2 + 0.1 x; boxes that are wide along y have no bound."""

    batch, floor = 2, -np.inf

    def bound_boxes(
        self, boxes: Sequence[Box], domains: Sequence[Box | None] = ()
    ) -> list[ObjectiveBounds | Unbounded]:
        return [
            Unbounded("too wide") if (upper - lower)[1] > Y else _bound(lower, upper)
            for lower, upper in boxes
        ]


def _bound(lower: Array, upper: Array) -> ObjectiveBounds:
    x, centre = Ball.between(lower, upper), lower + (upper - lower) / 2
    reach = x.power(2).nonnegative().sum() - Ball.exact(1.0)
    slopes = x * reach * Ball.exact(4.0) + Ball.exact(np.array([0.1, 0.0]))
    objective = reach.power(2).nonnegative() + x[0] * Ball.exact(0.1)
    reached = (centre @ centre - 1) ** 2 + 0.1 * centre[0]
    return ObjectiveBounds(
        float(objective.low), float(reached) + 1e-12, slopes, (upper - lower) * slopes.magnitude
    )


def enclose_samples(
    response: ResponseProgram, space: Space, count: int, start: AssemblyStart | None = None
) -> list[Jet]:
    """Return each quantity over a box at `count` angles of a cycle that differ modulo the
    period.
    """
    phi = list_angles(list_samples(response, count))
    box = space.lower, space.upper
    branch = RootBranch(1.0, (), ()) if start is None else start.follow(response, *box)
    return response.enclose(space, space.constant(phi), [branch])


@dataclass(frozen=True)
class Bounded:
    """An objective that is nowhere below zero, bounded by a function of one box."""

    bound: Callable[[Array, Array], ObjectiveBounds]
    batch: int = 1
    floor: float = 0.0

    def bound_boxes(
        self, boxes: Sequence[Box], domains: Sequence[Box | None] = ()
    ) -> list[ObjectiveBounds | Unbounded]:
        results: list[ObjectiveBounds | Unbounded] = []
        for box in boxes:
            try:
                results.append(self.bound(*box))
            except Unbounded as error:
                results.append(error)
        return results


LOWER, UPPER = np.array([0.1, 0.9, -0.04]), np.array([0.6, 1.3, 0.1])
SAMPLES = 24


def evaluate(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
    """F = 2 x0 |sin(phi - x2)| + (x1 - x2^2) cos(2 phi): two halves of a turn, each with kinks
    where phi = x2.
    """
    phi, *x = inputs
    return [x[0] * xp.absolute(xp.sin(phi - x[2])) + (x[1] - x[2] ** 2) / 2 * xp.cos(2 * phi)]


BENT = ResponseProgram(
    3,
    (record_program(evaluate, 4, (3, 0, 1, 2)),),
    (Fraction(0), Fraction(-1, 2)),
    Fraction(1, 2),
    is_continuous=True,
)


def force(x: Array) -> Array:
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    return 2 * x[0] * np.abs(np.sin(phi - x[2])) + (x[1] - x[2] ** 2) * np.cos(2 * phi)


def value(x: Array) -> float:
    enclosed_force = force(x)
    return float(0.6 * np.ptp(enclosed_force) + 0.4 * enclosed_force.var())


def find_kinks(x: Array) -> Kinks:
    """Return the kink of |sin(phi - x2)| within half a turn."""
    return np.array([x[2] % np.pi]), np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 3, 3))


def build_bent(count: int | None, limits: Sequence[BoundedMeasure] = ()) -> ProvableObjective:
    """Return 0.6 range + 0.4 variance of the curve, over samples or true."""
    terms = [BoundedMeasure("range", 0, weight=0.6), BoundedMeasure("variance", 0, weight=0.4)]
    return ProvableObjective(BENT, terms, limits, count, find_kinks=find_kinks)
