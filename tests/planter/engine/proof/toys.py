"""An objective over boxes of two parameters that a worker builds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from planter.engine.proof.enclosures import (
    ResponseProgram,
    RootStart,
    list_angles,
    list_samples,
)
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import Jet, Space
from planter.engine.proof.objective import ObjectiveBounds
from planter.kernels import Array

Y = 0.9
"""Extent of a box that has no bound."""
BEST = np.array([-1.012274, 0.0])
"""Where the objective is least: 4 x (x^2 - 1) + 0.1 = 0."""


class Ring:
    """f = (x^2 + y^2 - 1)^2 + 0.1 x; boxes that are wide along y have no bound."""

    batch, floor = 2, -np.inf

    def bound_boxes(
        self, boxes: Sequence[tuple[Array, Array]]
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
    response: ResponseProgram, space: Space, count: int, starts: Sequence[RootStart] = ()
) -> list[Jet]:
    """Return each quantity over a box at `count` angles of a cycle that differ modulo the
    period.
    """
    phi = list_angles(list_samples(response, count))
    return response.enclose(space, space.constant(phi), [starts])


@dataclass(frozen=True)
class Bounded:
    """An objective that is nowhere below zero, bounded by a function of one box."""

    bound: Callable[[Array, Array], ObjectiveBounds]
    batch: int = 1
    floor: float = 0.0

    def bound_boxes(
        self, boxes: Sequence[tuple[Array, Array]]
    ) -> list[ObjectiveBounds | Unbounded]:
        results: list[ObjectiveBounds | Unbounded] = []
        for box in boxes:
            try:
                results.append(self.bound(*box))
            except Unbounded as error:
                results.append(error)
        return results
