"""What stands in the way of a design that satisfies all limits: what the closest one violates,
which limits and bounds cannot hold together there, and what relaxes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from planter.engine.problem import DesignProblem
from planter.engine.solvers.conflict import Conflict, find_conflict
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE, ConstraintReading
from planter.engine.solvers.feasibility import ViolationMinimum
from planter.errors import ComputationError
from planter.files.record import Record
from planter.files.units import display_unit
from planter.report.labels import count_things

MARGIN_SHARE = 1e-3
"""What a limit is missed by differs by more than this share of it from what is missing to the limit
alone if a margin is to be kept.
"""
MOST_BOUNDS = 3
"""Most bounds of a conflict that a sentence names."""


@dataclass(frozen=True)
class LimitViolation(Record):
    """A limit that the closest design violates by `amount`; value and limit are null where its
    quantity has no value there. All are in `unit`.
    """

    name: str
    amount: float
    unit: str
    value: float | None
    limit: float | None

    def __str__(self) -> str:
        unit = _format_unit(self.unit)
        if self.value is None or self.limit is None:
            return f"{self.name} by {self.amount:.3g}{unit}"
        is_reached = abs(abs(self.value - self.limit) - self.amount) <= MARGIN_SHARE * self.amount
        margin = "" if is_reached else " with its margin"
        pair = f"{self.value:.4g} for {self.limit:g}{unit}{margin}"
        return f"{self.name} by {self.amount:.3g}{unit} ({pair})"


@dataclass(frozen=True)
class LimitRelaxation(Record):
    """A single change that makes room for a design, to first order: a limit or a bound, and its new
    number in `unit`. `text` says it as a file has it.
    """

    name: str
    limit: float
    relaxed: float
    unit: str
    text: str


@dataclass(frozen=True)
class Infeasibility(Record):
    """Why searches from some `starts` ended without a feasible design, of those that `scope` says.

    `violations` are those of the closest one, `conflict` and `bounds` the limits and the bounds
    that cannot hold together there, to first order, while all but any one of them can; there are
    none if the search ended where they are not in conflict to first order.
    """

    starts: int
    violations: list[LimitViolation]
    conflict: list[str]
    bounds: list[str]
    relaxations: list[LimitRelaxation]
    scope: str = ""

    def __str__(self) -> str:
        head = f"{count_things(self.starts, 'start')}, none{self.scope} satisfies all limits"
        parts = [f"{head}; the closest misses {join_words(list(map(str, self.violations)))}"]
        if not self.conflict:
            parts.append("more --starts may find a design")
        elif len(self.conflict) + len(self.bounds) > 1:
            count = len(self.bounds)
            bounds = [f"{count} of the bounds"] if count > MOST_BOUNDS else self.bounds
            parts.append(f"{join_words([*self.conflict, *bounds])} cannot hold together there")
        else:
            parts.append(f"no change of the design satisfies {self.conflict[0]} there")
        if self.relaxations:
            changes = join_words([change.text for change in self.relaxations], "or")
            parts.append(f"to first order {changes} makes room")
        return "; ".join(parts)

    def table(self) -> dict[str, Any]:
        """Return the entries of a partial result."""
        return {
            "violations": [violation.table() for violation in self.violations],
            "conflict": [*self.conflict, *self.bounds],
            "relaxations": [change.table() for change in self.relaxations],
        }


def explain_infeasibility(
    problem: DesignProblem, closest: ViolationMinimum, starts: int, scope: str = ""
) -> Infeasibility:
    """Return what stands in the way of feasible designs at the smallest violation that searches
    from some `starts` ended at.

    Raises ComputationError if the constraints have no values there.
    """
    constraints, x = problem.constraints, problem.design(closest.u)
    assert constraints is not None
    readings, violations = constraints.read(x), []
    for kind, reading, excess in zip(
        constraints.kinds, readings, closest.excess.tolist(), strict=True
    ):
        if excess > FEASIBILITY_TOLERANCE:
            value, limit = (None, None) if reading is None else (reading.value, reading.limit)
            entry = LimitViolation(kind.name, excess * kind.step, kind.unit, value, limit)
            violations.append(entry)
    try:
        conflict = find_conflict(problem, constraints, closest.u)
    except ComputationError:  # no slopes where a quantity has a pole
        conflict = None
    if conflict is None:
        return Infeasibility(starts, violations, [], [], [], scope)
    members = [constraints.kinds[k].name for k in conflict.kinds]
    bounds = [_name_bound(problem, index, side) for index, side in conflict.bounds]
    relaxations = _list_relaxations(problem, conflict, readings)
    return Infeasibility(starts, violations, members, bounds, relaxations, scope)


def _list_relaxations(
    problem: DesignProblem, conflict: Conflict, readings: Sequence[ConstraintReading | None]
) -> list[LimitRelaxation]:
    assert problem.constraints is not None
    kinds, changes = problem.constraints.kinds, []
    for change in conflict.relaxations:
        if change.side:
            name, unit, scale = _describe_value(problem, change.index)
            ends = problem.box.lower if change.side == "lower" else problem.box.upper
            sign, bound = (-1 if change.side == "lower" else 1), float(ends[change.index] / scale)
            relaxed = bound + sign * change.amount / scale
            word = "down" if sign < 0 else "up"
            text = f"{name} {word} to {relaxed:.4g}{_format_unit(unit)}"
            changes.append(LimitRelaxation(name, bound, relaxed, unit, text))
            continue
        reading, kind = readings[change.index], kinds[change.index]
        if reading is not None:
            relaxed = reading.limit + reading.sign * change.amount
            text = f"{reading.key} {relaxed:.4g}{_format_unit(kind.unit)}"
            changes.append(LimitRelaxation(kind.name, reading.limit, relaxed, kind.unit, text))
    return changes


def _name_bound(problem: DesignProblem, index: int, side: str) -> str:
    return f"the {side} bound of {_describe_value(problem, index)[0]}"


def _describe_value(problem: DesignProblem, index: int) -> tuple[str, str, float]:
    """Return the name of a value of the design, its unit in the file, and SI units per that."""
    machine = problem.machine
    path = machine.moved_paths[index]
    return machine.design_names[index], display_unit(path), float(machine.scale[index])


def _format_unit(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def join_words(words: Sequence[str], word: str = "and") -> str:
    """Return words as a list in words: a, b and c."""
    return f" {word} ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))
