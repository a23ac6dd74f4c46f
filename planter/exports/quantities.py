"""What exports take of a machine: quantities of its sides, its sum of measures over samples,
motions over time.

A row is a quantity, or its size, at the samples; its statistics are `STATISTICS`. Values at single
angles are nodes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.engine.goal import find_display_unit, resolve_measure
from planter.engine.machine import Machine, Quantity, check_samples
from planter.engine.measures import Measure, format_sum, parse_distance
from planter.engine.response import INPUTS, MachineResponse
from planter.errors import InputError
from planter.exports.motion_tables import Column, MotionTable
from planter.files import units
from planter.kernels import Array, Kernel

STATISTICS = ("high", "low", "mean", "variance")
FIELDS = ("range", "variance", "mean")
"""Statistics that are reported of each row."""
TINY = 1e-300
"""Variances below it have the root of it, whose derivative is zero."""
FEWEST_SAMPLES = 8
"""Smallest number of samples of a cycle in a table over time."""
MOST_ROWS = 200_000


@dataclass(frozen=True)
class SideQuantity:
    """A quantity of side 1, 2, .. of a machine or, with side 0, of all sides together.

    `name` is a plain word, beyond side 1 with the side's number behind it, as `key`, which ends in
    the unit of tables. `sides` is the number of the machine's sides.
    """

    name: str
    key: str
    side: int
    sides: int
    quantity: Quantity

    @property
    def meaning(self) -> str:
        """The meaning, with the side if there are several."""
        side = f", side {self.side}" if self.side and self.sides > 1 else ""
        return f"{self.quantity.meaning}{side}"


def list_quantities(machine: Machine) -> list[SideQuantity]:
    """Return the results side by side, then those of all sides together."""
    sides = len(machine.offsets)
    quantities = [
        _number_side(q, side, sides)
        for side in range(1, sides + 1)
        for q in machine.results
        if not q.total
    ]
    return quantities + [
        SideQuantity(q.name, q.key, 0, sides, q) for q in machine.results if q.total
    ]


def _number_side(quantity: Quantity, side: int, sides: int) -> SideQuantity:
    name, key = quantity.name, quantity.key
    if side > 1:
        suffix = units.unit_suffix(key)
        name, key = f"{name}_{side}", f"{key.removesuffix(suffix)}_{side}{suffix}"
    return SideQuantity(name, key, side, sides, quantity)


def list_fixed(machine: Machine) -> list[int]:
    """Return the indices of the values that a search does not move."""
    return [index for index in range(len(machine.values)) if index not in machine.moved]


def build_name(machine: Machine) -> str:
    """Return the machine's name as a C identifier, with the model where that is not the usual
    one.
    """
    name, variant = to_identifier(machine.name), machine.documentation.variant
    return f"{name}_{variant}" if variant else name


def to_identifier(text: str) -> str:
    """Return a text as a C identifier.

    >>> to_identifier("My machine 2!"), to_identifier("2nd")
    ('my_machine_2', 'm_2nd')
    """
    plain = re.sub(r"\W+", "_", text.lower(), flags=re.ASCII).strip("_")
    return plain if re.match(r"[a-z]", plain) else f"m_{plain}"


def build_headline(machine: Machine) -> str:
    """Return the machine and its model in a line."""
    title = machine.documentation.title
    return f"{machine.name}: {title}" if title else machine.name


def build_prologues(machine: Machine, tangent: ca.Function) -> list[ca.Function]:
    """Return `hoisting` (d) -> h and `prologue` (d) -> h, dh."""
    d = machine.create_symbol("d", len(machine.values))
    return [
        ca.Function("hoisting", [d], [ca.densify(machine.prologue(d))], ["d"], ["h"]),
        ca.Function("prologue", [d], list(tangent(d)), ["d"], ["h", "dh"]),
    ]


def build_cycle(machine: Machine) -> ca.Function:
    """Return (phi, d, h, q) -> results of side 1, of side 2, .., of all sides together."""
    phi, d, h, q = machine.symbols
    sides = [machine.lane(phi + offset, d, h, q) for offset in machine.offsets]
    outputs = {f"side{k}": side[_list_results(machine, False)] for k, side in enumerate(sides, 1)}
    if machine.totals is not None:
        outputs["totals"] = machine.totals(*sides, d)[_list_results(machine, True)]
    dense = [ca.densify(output) for output in outputs.values()]
    return ca.Function("cycle", [phi, d, h, q], dense, list(INPUTS), list(outputs))


def _list_results(machine: Machine, total: bool) -> list[int]:
    """Return the places of results among the quantities of a side, or of all sides together."""
    quantities = (q for q in machine.quantities if q.total == total)
    return [index for index, q in enumerate(quantities) if q.role == "result"]


@dataclass(frozen=True)
class SampledRow:
    """A quantity at the samples of a cycle, or its size; `shared` ones are sums over the sides."""

    quantity: Quantity
    absolute: bool
    shared: bool

    @property
    def label(self) -> str:
        """The name as part of a C identifier."""
        return f"{'abs_' if self.absolute else ''}{self.quantity.name}"


class SampledGoal:
    """A machine's sum over equal samples of a turn; without a sum, statistics of all its results.

    `samples` make a turn, of which the first `angles` differ; `response` has the rows (m,). Raises
    InputError for a sum of what the machine does not have.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.measures = tuple(resolve_measure(machine, measure) for measure in machine.objective)
        if self.reason_missing:
            self.measures = ()
        pairs = [(m.name, m.size) for m in self.measures] or [
            (q.name, False) for q in machine.results
        ]
        names = tuple(dict.fromkeys(pairs))
        self.response = MachineResponse(machine, [name for name, _ in names])
        shared = self.response.shared
        quantities = (machine.find_quantity(name) for name, _ in names)
        self.rows = tuple(
            SampledRow(q, size, share)
            for q, (_, size), share in zip(quantities, names, shared, strict=True)
        )
        self._names = names
        self.samples = machine.objective_samples if self.measures else machine.samples
        self.angles = self.count_angles(self.samples)

    def count_angles(self, samples: int) -> int:
        """Return how many samples of a turn differ: a part of them where all rows are sums over
        equal sides.
        """
        sides = len(self.machine.offsets)
        return samples // sides if all(self.response.shared) and samples % sides == 0 else samples

    @property
    def reason_missing(self) -> str:
        """The reason why an objective has no form in C, empty if it has one."""
        for measure in self.machine.objective:
            if measure.is_moving:
                return (
                    f"{measure} is of a part of the cycle that the design moves, and has no "
                    f"form in C"
                )
            if any(parse_distance(name) for name in measure.names):
                return f"{measure} is of a distance of a point, and has no form in C"
        return ""

    @cached_property
    def nodes(self) -> tuple[tuple[int, float], ...]:
        """Rows and angles [rad] of values at single angles."""
        at = [self._node(measure) for measure in self.measures if measure.angle is not None]
        return tuple(dict.fromkeys(at))

    @property
    def phi(self) -> Array:
        """The samples and the angles of the nodes [rad], (n,)."""
        return np.concatenate(
            [
                self.machine.list_angles(self.samples)[: self.angles],
                [angle for _, angle in self.nodes],
            ]
        )

    @property
    def fields(self) -> dict[str, str]:
        """The numbers that are reported of a cycle by their C names, each with its SI unit behind:
        the objective if there is one, then `FIELDS` of each row.
        """
        fields = {"objective": "objective"} if self.measures else {}
        for row in self.rows:
            suffix = f"_{row.label}" if len(self.rows) > 1 else ""
            for name in FIELDS:
                unit = _unit_suffix(row.quantity.unit, 2 if name == "variance" else 1)
                fields[name + suffix] = f"{name}{suffix}{unit}"
        return fields

    @property
    def text(self) -> str:
        """The sum as the file has it."""
        return format_sum(self.measures)

    @cached_property
    def function(self) -> ca.Function:
        """(d, statistics (4 m,), nodes (n,)) -> the sum, its slopes in statistics, nodes and moved
        values.
        """
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
            "weigh",
            [d, statistics, nodes],
            ca.cse([ca.densify(output) for output in outputs]),
            ["d", "statistics", "nodes"],
            ["objective", "slope", "node_slope", "moved_slope"],
        )

    def _row(self, measure: Measure) -> int:
        return self._names.index((measure.name, measure.size))

    def _node(self, measure: Measure) -> tuple[int, float]:
        assert measure.angle is not None
        return self._row(measure), float(np.radians(measure.angle % 360))

    def _evaluate(self, measure: Measure, d: ca.SX, statistics: ca.SX, nodes: ca.SX) -> ca.SX:
        """Return a measure in its display unit."""
        machine, row = self.machine, self._row(measure)
        if measure.angle is not None:
            value = nodes[self.nodes.index(self._node(measure))]
            return value / find_display_unit(machine, measure).factor
        first = len(STATISTICS) * row
        high, low, mean, variance = ca.vertsplit(statistics[first : first + len(STATISTICS)])
        values = {
            "max": high,
            "min": low,
            "range": high - low,
            "mean": mean,
            "variance": variance,
            "std": _root(variance),
            "rms": _root(variance + mean**2),
        }
        if measure.kind == "work":
            turn = machine.turn / (
                ca.fabs(d[machine.speed]) if machine.find_quantity(measure.name).unit == "W" else 1
            )
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


def build_motion(machine: Machine, turns: int = 1, samples: int | None = None) -> MotionTable:
    """Return all quantities, and places of the bodies' points, over whole turns at the machine's
    speed.

    There are `samples` to a turn, and the last turn's end is included. Raises InputError for
    numbers of turns or samples out of range, or a machine that stands still; ComputationError where
    loops do not close, or forces are not determined.
    """
    count = _check_numbers(machine, turns, samples)
    speed = float(machine.data[machine.speed])
    phi = np.copysign(machine.turn, speed) * np.arange(turns * count + 1) / count
    columns = (
        Column("time", "time_s", "s", "time", "angle of the drive over its speed", phi / speed),
        Column("phi", "phi_deg", "rad", "angle of the drive", "given", phi),
        *_build_columns(machine, phi),
    )
    rpm = f"{speed * 30 / np.pi:g} r/min"
    notes = (
        f"{build_headline(machine)}; {turns} {'turn' if turns == 1 else 'turns'} at a constant "
        f"speed of {rpm}",
        *([f"Assumes: {'; '.join(machine.assumptions)}."] if machine.assumptions else []),
    )
    return MotionTable(build_name(machine), notes, columns)


def _check_numbers(machine: Machine, turns: int, samples: int | None) -> int:
    """Return the samples of a turn."""
    count = machine.samples if samples is None else samples
    check_samples(samples, FEWEST_SAMPLES)
    if not 1 <= turns <= MOST_ROWS // count:
        allowed = f"it must be between 1 and {MOST_ROWS // count} with {count} samples to a turn"
        raise InputError.for_value("--turns", turns, allowed)
    if not machine.data[machine.speed]:
        raise InputError(
            f"{machine.source}: {machine.values[machine.speed].path} = 0: at rest there is no "
            f"time of a turn"
        )
    return count


def _build_columns(machine: Machine, phi: Array) -> list[Column]:
    guards = MachineResponse(machine, [guard.name for guard in machine.guards])
    d = machine.data
    point = guards.at_data(d)
    q = guards.coordinates(d, phi)
    guards.check(guards.values(point, phi), phi)
    quantities = list_quantities(machine)
    labels = [(q.name, q.key, q.quantity.unit, q.meaning, q.quantity.source) for q in quantities]
    inputs = {"phi": phi, "d": d, "h": point.h, "q": q}
    rows = [
        row
        for part in Kernel(build_cycle(machine), lanes=["phi", "q"])(**inputs).values()
        for row in part
    ]
    if places := machine.stages.get("places"):
        labels += [(q.name, q.key, q.unit, q.meaning, q.source) for q in places.quantities]
        rows += list(Kernel(places.function, lanes=["phi", "q"])(**inputs)["y"])
    return [Column(*label, row) for label, row in zip(labels, rows, strict=True)]
