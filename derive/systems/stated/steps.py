"""Values by the steps of a model, to many digits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mpmath
from mpmath import mpf

from ...evaluate import Point
from ...model import Let, LinearSolve, Step
from ...quantity import Quantity
from .given import Values


def after(steps: Iterable[Step], values: Mapping[Quantity, mpf]) -> Values:
    """Values with those that steps give. Raises ZeroDivisionError where equations determine nothing."""
    found = dict(values)
    for step in steps:
        found |= _stepped(step, Point(found))
    return found


def _stepped(step: Step, point: Point) -> Values:
    if isinstance(step, Let):
        return {step.symbol: point(step.expr)}
    assert isinstance(step, LinearSolve)
    matrix = mpmath.matrix([[point(entry) for entry in row] for row in step.matrix])
    right = mpmath.matrix([point(entry) for entry in step.right])
    return {**dict(zip(step.symbols, mpmath.lu_solve(matrix, right), strict=True)), step.pivot: mpf(1)}
