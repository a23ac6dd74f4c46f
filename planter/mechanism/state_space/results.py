"""What `planter linearise` returns, key by key: SI units and radians."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record

Matrix = list[list[float]]


@dataclass(frozen=True)
class VariableResult(Record):
    """A state, input or output with its value where the model is linearised."""

    name: str
    unit: str
    meaning: str
    value: float


@dataclass(frozen=True)
class ConstraintResult(Record):
    """Constraints that are kept as `rows` and those that follow from them; `pivot` is the least
    pivot of the rows over the largest, 1 without rows.
    """

    rows: list[str]
    left_out: list[str]
    pivot: float


@dataclass(frozen=True)
class MinimalForm(Record):
    """The linear model in states that no constraint ties to each other."""

    state: list[str]
    A: Matrix
    B: Matrix
    C: Matrix


@dataclass(frozen=True)
class LinearModelResult(Record):
    """x' = A x + B u, y = C x + D u for small changes of state, inputs and outputs.

    `eigenvalues` [1/s] are pairs of a real and an imaginary part of the motions that the
    constraints allow, by decreasing real part. Columns of `basis` are changes of the whole state
    that keep the constraints, one for each state of the minimal form. `drift` is the largest rate
    or acceleration there: zero at rest.
    """

    machine: str
    at: str
    state: list[VariableResult]
    inputs: list[VariableResult]
    outputs: list[VariableResult]
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    eigenvalues: list[tuple[float, float]]
    constraints: ConstraintResult
    basis: Matrix
    minimal: MinimalForm
    drift: float


COMMANDS = {"linearise": LinearModelResult}
"""Results by command."""
