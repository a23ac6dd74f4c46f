"""The sum of measures that a machine's file minimises, as a function of statistics of samples over a cycle.

A row is a quantity, or its size, at the samples; its statistics are `STATISTICS`. Values at single angles are nodes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.engine.goal import find_display_unit, resolve_measure
from planter.engine.machine import Machine, Quantity
from planter.engine.measures import Measure, format_sum, parse_distance
from planter.engine.response import Response
from planter.kernels import Array

STATISTICS = ("high", "low", "mean", "variance")
FIELDS = ("range", "variance", "mean")
"""What is reported of each row."""
TINY = 1e-300
"""Variances below it have the root of it, whose derivative is zero."""


@dataclass(frozen=True)
class Row:
    """A quantity at the samples of a cycle, or its size; `shared` ones are sums over the sides."""

    quantity: Quantity
    absolute: bool
    shared: bool

    @property
    def label(self) -> str:
        """The name as part of a C identifier."""
        return f"{'abs_' if self.absolute else ''}{self.quantity.name}"


@dataclass(frozen=True)
class Field:
    """A number that is reported of a cycle: its C name, and that with its SI unit."""

    name: str
    printed: str


class SampledGoal:
    """A machine's sum over equal samples of a turn; without a sum, statistics of all its results.

    `samples` make a turn, of which the first `angles` differ; `response` has the rows (m,). Raises InputError for a
    sum of what the machine does not have.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.measures = tuple(resolve_measure(machine, measure) for measure in machine.least)
        if self.reason_missing:
            self.measures = ()
        pairs = [(m.name, m.size) for m in self.measures] or [(q.name, False) for q in machine.results]
        names = tuple(dict.fromkeys(pairs))
        self.response = Response(machine, [name for name, _ in names])
        shared = self.response.shared
        quantities = (machine.find_quantity(name) for name, _ in names)
        self.rows = tuple(Row(q, size, share) for q, (_, size), share in zip(quantities, names, shared, strict=True))
        self._names = names
        self.samples = machine.least_samples if self.measures else machine.samples
        self.angles = self.count_angles(self.samples)

    def count_angles(self, samples: int) -> int:
        """Return how many samples of a turn differ: a part of them where all rows are sums over equal sides."""
        sides = len(self.machine.offsets)
        return samples // sides if all(self.response.shared) and samples % sides == 0 else samples

    @property
    def reason_missing(self) -> str:
        """What keeps a stated sum out of C, empty if nothing does."""
        for measure in self.machine.least:
            if measure.is_moving:
                return f"{measure} is of a part of the cycle that the design moves, and has no form in C"
            if any(parse_distance(name) for name in measure.names):
                return f"{measure} is of a curve in a file, and has no form in C"
        return ""

    @cached_property
    def nodes(self) -> tuple[tuple[int, float], ...]:
        """Rows and angles [rad] of values at single angles."""
        at = [(self._row(m), float(np.radians(m.angle % 360))) for m in self.measures if m.angle is not None]
        return tuple(dict.fromkeys(at))

    @property
    def phi(self) -> Array:
        """The samples and the angles of the nodes [rad], (n,)."""
        return np.concatenate(
            [self.machine.turn * np.arange(self.angles) / self.samples, [angle for _, angle in self.nodes]]
        )

    @property
    def fields(self) -> list[Field]:
        """What is reported of a cycle: the sum if there is one, then `FIELDS` of each row."""
        found = [Field("objective", "objective")] if self.measures else []
        for row in self.rows:
            suffix = f"_{row.label}" if len(self.rows) > 1 else ""
            unit = row.quantity.unit
            for name in FIELDS:
                field = f"{name}{suffix}"
                found.append(Field(field, f"{field}{_unit_suffix(unit, 2 if name == 'variance' else 1)}"))
        return found

    @property
    def text(self) -> str:
        """The sum as the file has it."""
        return format_sum(self.measures)

    @cached_property
    def function(self) -> ca.Function:
        """(d, statistics (4 m,), nodes (n,)) -> the sum, its slopes in statistics, nodes and moved values."""
        machine = self.machine
        d = ca.SX.sym("d", len(machine.values))
        statistics = ca.SX.sym("statistics", len(STATISTICS) * len(self.rows))
        nodes = ca.SX.sym("nodes", max(len(self.nodes), 1))  # C has no arrays without elements
        total = ca.SX(0)
        for measure in self.measures:
            total += measure.weight * self._evaluate(measure, d, statistics, nodes)
        moved = ca.gradient(total, d)[list(machine.moved)] if machine.moved else ca.SX(0)
        outputs = [total, ca.gradient(total, statistics), ca.gradient(total, nodes), moved]
        return ca.Function(
            "weigh", [d, statistics, nodes], ca.cse([ca.densify(output) for output in outputs]),
            ["d", "statistics", "nodes"], ["objective", "slope", "node_slope", "moved_slope"],
        )  # fmt: skip

    def _row(self, measure: Measure) -> int:
        return self._names.index((measure.name, measure.size))

    def _evaluate(self, measure: Measure, d: ca.SX, statistics: ca.SX, nodes: ca.SX) -> ca.SX:
        """Return a measure in its display unit."""
        machine, row = self.machine, self._row(measure)
        if measure.angle is not None:
            value = nodes[self.nodes.index((row, float(np.radians(measure.angle % 360))))]
            return value / find_display_unit(machine, measure).factor
        high, low, mean, variance = (statistics[len(STATISTICS) * row + i] for i in range(len(STATISTICS)))
        values = {
            "max": high, "min": low, "range": high - low, "mean": mean, "variance": variance,
            "std": _root(variance), "rms": _root(variance + mean**2),
        }  # fmt: skip
        if measure.kind == "work":
            turn = machine.turn / (ca.fabs(d[machine.speed]) if machine.find_quantity(measure.name).unit == "W" else 1)
            return turn * mean
        return values[measure.kind] / find_display_unit(machine, measure).factor


def _root(square: ca.SX) -> ca.SX:
    return ca.sqrt(ca.fmax(square, TINY))


def _unit_suffix(unit: str, power: int) -> str:
    """Return an SI unit, or a power of it, as the end of a name.

    >>> _unit_suffix("N", 2), _unit_suffix("m/s2", 2), _unit_suffix("N m", 1), _unit_suffix("1", 1)
    ('_N2', '_m2_s4', '_Nm', '')
    """
    parts = ["".join(_factor(word, power) for word in part.split()) for part in unit.split("/")]
    return "".join(f"_{part}" for part in parts if part)


def _factor(word: str, power: int) -> str:
    match = re.fullmatch(r"([A-Za-z]+)(\d*)", word)
    if match is None:
        return ""
    exponent = int(match[2] or 1) * power
    return f"{match[1]}{exponent if exponent > 1 else ''}"


def list_guards(machine: Machine) -> list[str]:
    """Return names of quantities that say whether forces are determined: pivots, then numbers of states."""
    return [q.name for role in ("pivot", "states") for q in machine.quantities if q.role == role]
