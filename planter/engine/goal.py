"""A sum of measures to be minimised under limits, as a smooth programme in the design and a few variables more.

An extreme becomes a separate variable t that all nodes stay below, or above: the epigraph form. The variables of the
programme are those of the design (p,), then the t's (q,); no function of it has a corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.measures import WITHOUT_SIZE, Extremum, Limit, Measure, MeasureCondition
from planter.engine.nodes import EventNodes, ExtremumNode, FixedNodes, JumpNodes, Nodes, NodeValues, SpanNodes
from planter.errors import InputError
from planter.files import units
from planter.files.units import Unit, parse_unit
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.numerics.statistics import SMOOTH, Statistic
from planter.optimise.constraints import Constraints, NamedConstraint

SIDES = {"max": (1,), "min": (-1,), "range": (1, -1), "jump": (1,)}
"""Sides on which a measure needs a variable: +1 for the greatest value, -1 for the least."""
SHARES = {"max": (1,), "min": (1,), "range": (1, -1), "jump": (1,)}
"""How often the value on each of these sides counts in the measure."""
EVERYWHERE = ("all", "max", "min", "jump")
"""Measures whose limits are those of every node."""
CYCLE, ANGLES, EVENTS, JUMPS = "cycle", "angles", "events", "jumps"

Key = str | Extremum | tuple[MeasureCondition, ...]
"""Which nodes a measure has: of the cycle, its switching points, jumps, angles, an extremum, parts of the cycle."""


def resolve_measure(machine: Machine, measure: Measure) -> Measure:
    """Return a measure with names of the machine's quantities, conditions in their display units.

    Raises InputError for a name that the machine does not have, a unit of another kind, or a size without a measure.
    """
    quantities = [machine.find_quantity(name) for name in measure.names]
    measure = measure.with_names([quantity.name for quantity in quantities])
    rest = quantities[1 + (measure.where is not None) :]
    during = tuple(
        _convert(machine, condition, find_display_unit(machine, Measure("all", quantity.name)))
        for condition, quantity in zip(measure.during, rest, strict=True)
    )
    if measure.size and measure.kind in WITHOUT_SIZE:
        raise InputError(f"{machine.source}: {measure}: over a cycle {measure.kind} takes no abs, which has corners")
    if measure.kind == "work" and quantities[0].unit not in ("W", "N m"):
        raise InputError(f"{machine.source}: {measure}: only a power [W] or a torque [N m] does work")
    return replace(measure, during=during)


def resolve_limit(machine: Machine, limit: Limit) -> Limit:
    """Return a limit with names of the machine's quantities, in their display units. Raises InputError as above."""
    measure = resolve_measure(machine, limit.measure)
    display = find_display_unit(machine, measure)
    return _convert(machine, replace(limit, measure=measure), display)


Bound = TypeVar("Bound", Limit, MeasureCondition)


def find_display_unit(machine: Machine, measure: Measure) -> Unit:
    """Return the unit in which a measure of a machine's quantity is given."""
    if measure.kind == "work":
        return parse_unit("J")
    quantity = machine.find_quantity(measure.name)
    unit = Unit(units.display_unit(quantity.key), quantity.factor, parse_unit(quantity.unit).dimension)
    return unit.squared() if measure.kind == "variance" else unit


def _convert(machine: Machine, bound: Bound, display: Unit) -> Bound:
    """Return a limit or a condition in a display unit."""
    if not bound.unit:
        return bound
    unit = parse_unit(bound.unit)
    if not unit.same_kind(display):
        allowed = f"it must be a unit such as {display.text}" if display.text else "it is a number without a unit"
        raise InputError(f"{machine.source}: {bound}: {bound.unit} is not a unit of {bound.names[0]}; {allowed}")
    return replace(bound, number=bound.number * (unit.factor / display.factor), unit=display.text)


@dataclass(frozen=True)
class GoalTerm:
    """A measure without corners at a design: value, gradient (p,), and what makes its Hessian.

    That is `extra` (p, p) and the Hessians of values and weights of its nodes, `weights` and `weight_weights` (n,).
    """

    value: float
    gradient: Array
    weights: Array
    weight_weights: Array
    extra: Array


@dataclass(frozen=True)
class ConstraintBlock:
    """Rows factor * (a quantity at samples) + share * (variable), within [lower, upper], of one limit, the owner."""

    key: Key
    output: int
    samples: Integers
    factor: float
    variable: int
    share: float
    lower: float
    upper: float
    owner: int


class Goal:
    """A sum of measures under limits, over nodes of a cycle. Variables of the programme are y (p + q,).

    `count` samples of the cycle stand for all of it. Measures and limits are as `resolve_measure` gives them.
    """

    def __init__(
        self, machine: Machine, terms: Sequence[Measure], limits: Sequence[Limit], count: int | None = None,
        nodes: Mapping[Key, Nodes] | None = None, with_events: bool = True,
    ) -> None:  # fmt: skip
        """`with_events` takes extremes at switching points too, not only at samples; `nodes` are ready ones."""
        self.machine, self.terms, self.limits = machine, tuple(terms), tuple(limits)
        self.size = len(machine.design)
        self.measures = (*self.terms, *(limit.measure for limit in self.limits))
        self.at = sorted({measure.angle % 360 for measure in self.measures if measure.angle is not None})
        count = machine.samples if count is None else count
        self.nodes: Mapping[Key, Nodes] = dict(self._build_nodes(count, with_events)) if nodes is None else nodes
        self.variables = [(m, side) for m in self.terms for side in self._sides(m)]
        self._objective_size = len(self.variables)
        ranges = [limit.measure for limit in self.limits if limit.measure.kind == "range" and not limit.is_reached]
        self.variables += [(measure, 1) for measure in ranges]
        self.unit = np.array([self.spread(m) for m, _ in self.variables])
        self.blocks = list(self._build_blocks())

    # --- the function of the programme ---------------------------------------------------------------

    def start(self, x: Array) -> Array:
        """Return a point with the variables as tight as they can be at a design x (p,)."""
        return np.concatenate([x, [self._extreme(x, m, side) for m, side in self.variables]])

    def value(self, y: Array) -> float:
        """Return the objective at variables y (p + q,)."""
        x, variables = np.split(y, [self.size])
        return float(self._linear @ variables) + sum(m.weight * self.term(x, m).value for m in self._smooth)

    def gradient(self, y: Array) -> Array:
        """Return the gradient (p + q,) of the objective."""
        x = y[: self.size]
        total = np.zeros(self.size)
        for measure in self._smooth:
            total += measure.weight * self.term(x, measure).gradient
        return np.concatenate([total, self._linear])

    def hessian(self, y: Array) -> Array:
        """Return the Hessian (p + q, p + q) of the objective."""
        x = y[: self.size]
        bending = Bending(self, x)
        for measure in self._smooth:
            bending.add(measure, measure.weight)
        return self.pad(bending.total())

    def evaluate(self, x: Array) -> float:
        """Return the sum of the measures at a design x (p,)."""
        return self.value(self.start(x))

    def slope(self, x: Array) -> Array:
        """Return the gradient (p,) of the sum at a design; an extreme's is that of the node that has it."""
        return self.gradient(self.start(x))[: self.size] + self._linear @ self.variable_slopes(x)

    def variable_slopes(self, x: Array) -> Array:
        """Return the gradients (q, p) of the variables where they are as tight as they can be at a design."""
        slopes = [self._extreme_with_slope(x, measure, side)[1] for measure, side in self.variables]
        return np.array(slopes).reshape(len(self.variables), self.size)

    def evaluate_limit(self, x: Array, limit: Limit) -> float | None:
        """Return what a limit is on at a design, in its display unit; None if its condition never holds."""
        is_empty = self.nodes[_key(limit.measure)](x).is_empty
        return None if is_empty else self.measure(x, limit.measure, limit.sign)

    def measure(self, x: Array, measure: Measure, side: int = 1) -> float:
        """Return a measure at a design, in its display unit; everywhere is the extreme on a side, +1 or -1."""
        if measure.kind == "range":
            return self._extreme(x, measure, 1) - self._extreme(x, measure, -1)
        if measure.kind in EVERYWHERE:
            return self._extreme(x, measure, {"max": 1, "min": -1}.get(measure.kind, side))
        value = self.term(x, measure).value
        return abs(value) if measure.is_size and measure.kind == "at" else value

    # --- its parts -----------------------------------------------------------------------------------

    def find_nodes(self, x: Array, measure: Measure) -> tuple[NodeValues, int]:
        """Return the nodes of a measure at a design, and the row of its quantity."""
        nodes = self.nodes[_key(measure)]
        return nodes(x), nodes.names.index(measure.name)

    def term(self, x: Array, measure: Measure) -> GoalTerm:
        """Return a measure without corners at a design x (p,)."""
        at, row = self.find_nodes(x, measure)
        values, slopes = at.values[row], at.slopes[row]
        none = np.zeros(len(values))
        if measure.kind == "at":
            node = self._node(measure)
            unit = np.eye(len(values))[node]
            return GoalTerm(float(values[node]), slopes[node], unit, none, np.zeros((self.size, self.size)))
        if measure.kind in SIDES:
            return self._reached(measure, values, slopes)
        if measure.kind == "work":
            return self._work(x, at, row, self.machine.find_quantity(measure.name))
        kind = next(kind for kind in SMOOTH if kind == measure.kind)
        statistic = Statistic(kind, values, np.full(len(values), 1 / len(values)) if at.is_empty else at.weights)
        gradient = statistic.gradient(slopes, at.weight_slopes)
        extra = statistic.curvature(slopes, at.weight_slopes)
        return GoalTerm(statistic.value, gradient, statistic.slope, statistic.weight_slope, extra)

    def _reached(self, measure: Measure, values: Array, slopes: Array) -> GoalTerm:
        """Return an extreme or a range as that of the nodes that have it now, for a limit that one angle satisfies."""
        weights, sizes = np.zeros(len(values)), np.abs(values) if measure.is_size else values
        for side in SIDES[measure.kind]:
            node = int(np.argmax(side * sizes))
            share = float(np.sign(values[node])) if measure.is_size else 1.0
            weights[node] += share * (side if measure.kind == "range" else 1)
        none = np.zeros(len(values))
        return GoalTerm(float(weights @ values), weights @ slopes, weights, none, np.zeros((self.size, self.size)))

    def _work(self, x: Array, at: NodeValues, row: int, quantity: Quantity) -> GoalTerm:
        """Return the work [J] of a power over the time of the nodes, or of a torque over their angle."""
        weights = np.zeros_like(at.weights) if at.is_empty else at.weights
        statistic = Statistic("integral", at.values[row], weights)
        length, rise, bend = self._length(x, quantity)
        gradient = statistic.gradient(at.slopes[row], at.weight_slopes)
        extra = statistic.curvature(at.slopes[row], at.weight_slopes)
        mixed = np.outer(gradient, rise)
        return GoalTerm(
            length * statistic.value, length * gradient + statistic.value * rise, length * statistic.slope,
            length * statistic.weight_slope, length * extra + mixed + mixed.T + statistic.value * bend,
        )  # fmt: skip

    def pad(self, square: Array) -> Array:
        """Return a Hessian in the design as one in all variables."""
        count = self.size + len(self.variables)
        padded = np.zeros((count, count))
        padded[: self.size, : self.size] = square
        return padded

    def spread(self, measure: Measure) -> float:
        """Return the size of what a measure varies by at the machine's own design, in its quantity's display unit."""
        at, row = self.find_nodes(self.machine.design, measure)
        values = at.values[row]
        return float(np.ptp(values)) or float(np.abs(values).max()) or 1.0

    def step(self, limit: Limit) -> float:
        """Return what counts as one in the violation of a limit: the limit, or the spread of what it is on."""
        return abs(limit.number) or self.spread(limit.measure)

    def refine(self, x: Array, tolerance: float) -> Goal | None:
        """Return the goal with nodes where quantities pass their extremes at a design; None if none does.

        `tolerance` is the share of a quantity's spread that an extreme may be passed by.
        """
        nodes, changed = dict(self.nodes), False
        for key, places in self._peaks(x, tolerance).items():
            nodes[key], changed = self.nodes[key].with_nodes(np.unique(places)), True
        return Goal(self.machine, self.terms, self.limits, nodes=nodes) if changed else None

    def _peaks(self, x: Array, tolerance: float) -> dict[Key, Array]:
        peaks: dict[Key, Array] = {}
        searched = {(_key(m), m.name): m for m in self.measures if m.kind in ("range", *EVERYWHERE)}
        for (key, name), measure in searched.items():
            at, row = self.find_nodes(x, measure)
            values = at.values[row]
            slack = tolerance * max(float(np.ptp(values)), np.finfo(float).tiny)
            places, beyond = self.nodes[key].find_peaks(x, name)
            passing = (beyond > values.max() + slack) | (beyond < values.min() - slack)
            if passing.any():
                peaks[key] = np.concatenate([peaks.get(key, np.empty(0)), places[passing]])
        return peaks

    @property
    def _smooth(self) -> list[Measure]:
        return [measure for measure in self.terms if not self._sides(measure)]

    @property
    def _linear(self) -> Array:
        """Weights (q,) of the variables in the objective."""
        weights = [share * m.weight for m in self.terms for share in SHARES.get(m.kind, (1,) * len(self._sides(m)))]
        return np.array([*weights, *[0.0] * (len(self.variables) - len(weights))])

    @staticmethod
    def _sides(measure: Measure) -> tuple[int, ...]:
        return (1,) if measure.is_size and measure.kind == "at" else SIDES.get(measure.kind, ())

    def _extreme(self, x: Array, measure: Measure, side: int) -> float:
        return self._extreme_with_slope(x, measure, side)[0]

    def _extreme_with_slope(self, x: Array, measure: Measure, side: int) -> tuple[float, Array]:
        """Return an extreme among nodes, and the slope (p,) of the node that has it."""
        at, row = self.find_nodes(x, measure)
        chosen = [self._node(measure)] if measure.kind == "at" else slice(None)
        values, slopes = at.values[row][chosen], at.slopes[row][chosen]
        if self._switches(measure):
            switching = self.nodes[EVENTS]
            events, row = switching(x), switching.names.index(measure.name)
            values, slopes = np.append(values, events.values[row]), np.vstack([slopes, events.slopes[row]])
        sizes = np.abs(values) if measure.is_size else values
        node = int(np.argmax(side * sizes))
        sign = np.sign(values[node]) if measure.is_size else 1.0
        return float(sizes[node]), sign * slopes[node]

    def _switches(self, measure: Measure) -> bool:
        """Return whether a measure is an extreme that a quantity may have at a switching point."""
        return EVENTS in self.nodes and _key(measure) == CYCLE and measure.kind in ("range", *EVERYWHERE)

    def _node(self, measure: Measure) -> int:
        return 0 if measure.angle is None else self.at.index(measure.angle % 360)

    def restart(self) -> None:
        """Forget all designs so far: what is evaluated next does not depend on them, to the last digit."""
        for nodes in self.nodes.values():
            nodes.restart()

    def _build_nodes(self, count: int, with_events: bool) -> Iterator[tuple[Key, Nodes]]:
        names: dict[Key, dict[str, None]] = {}
        for measure in self.measures:
            names.setdefault(_key(measure), {})[measure.name] = None
        for key, group in names.items():
            if isinstance(key, Extremum):
                yield key, ExtremumNode(self.machine, tuple(group), key)
            elif isinstance(key, tuple):
                yield key, SpanNodes(self.machine, tuple(group), key)
            elif key == JUMPS:
                yield key, JumpNodes(self.machine, tuple(group))
            else:
                angles = np.radians(self.at) if key == ANGLES else self.machine.list_angles(count)
                yield key, FixedNodes(self.machine, tuple(group), angles)
                if key == CYCLE and with_events and self.machine.events is not None:
                    yield EVENTS, EventNodes(self.machine, tuple(group))

    def _build_blocks(self) -> Iterator[ConstraintBlock]:
        extremes = len(self.limits)
        for t, (measure, side) in enumerate(self.variables):
            for sign in (1, -1) if measure.is_size else (side,):
                bounds = (-np.inf, 0.0) if measure.is_size or side > 0 else (0.0, np.inf)
                factor = (sign if measure.is_size else 1) / self.unit[t]
                yield from self._blocks_of(measure, factor, (t, -1 / self.unit[t]), bounds, extremes)
        spare = iter(range(self._objective_size, len(self.variables)))
        for owner, limit in enumerate(self.limits):
            measure, step = limit.measure, self.step(limit)
            level = limit.number / step
            bounds = (-level if measure.is_size else -np.inf, level) if limit.sign > 0 else (level, np.inf)
            if limit.is_reached:
                continue
            if measure.kind == "range":
                yield from self._blocks_of(measure, 1 / step, (next(spare), -1 / step), (-level, np.inf), owner)
            elif measure.kind in ("at", *EVERYWHERE):
                yield from self._blocks_of(measure, 1 / step, (0, 0.0), bounds, owner)

    def _blocks_of(
        self, measure: Measure, factor: float, variable: tuple[int, float], bounds: tuple[float, float], owner: int
    ) -> Iterator[ConstraintBlock]:
        for key in (_key(measure), EVENTS) if self._switches(measure) else (_key(measure),):
            nodes = self.nodes[key]
            count = nodes(self.machine.design).values.shape[1]
            samples = np.array([self._node(measure)]) if measure.kind == "at" else np.arange(count)
            yield ConstraintBlock(key, nodes.names.index(measure.name), samples, factor, *variable, *bounds, owner)

    def _length(self, x: Array, quantity: Quantity) -> tuple[float, Array, Array]:
        """Return how long a cycle is for the work of a quantity, in time or in angle, with slope and Hessian."""
        rise, bend = np.zeros(self.size), np.zeros((self.size, self.size))
        if quantity.unit == "N m":
            return self.machine.turn, rise, bend
        speed = float(self.machine.build_data(x)[self.machine.speed])
        length = self.machine.turn / abs(speed)
        if self.machine.speed in self.machine.moved:
            place = self.machine.moved.index(self.machine.speed)
            rise[place], bend[place, place] = -length / speed, 2 * length / speed**2
        return length, rise, bend


class Bending:
    """A weighted sum of Hessians (p, p) of measures and rows of a goal at a design x (p,)."""

    def __init__(self, goal: Goal, x: Array) -> None:
        self.goal, self.x = goal, x
        self.extra = np.zeros((goal.size, goal.size))
        self.weights = {key: np.zeros(nodes(x).values.shape) for key, nodes in goal.nodes.items()}
        self.weight_weights = {key: np.zeros(nodes(x).weights.shape) for key, nodes in goal.nodes.items()}

    def add(self, measure: Measure, weight: float) -> None:
        """Add a measure without corners."""
        key, term = _key(measure), self.goal.term(self.x, measure)
        self.weights[key][self.goal.nodes[key].names.index(measure.name)] += weight * term.weights
        self.weight_weights[key] += weight * term.weight_weights
        self.extra += weight * term.extra

    def total(self) -> Array:
        """Return the sum."""
        total = self.extra
        for key, weights in self.weights.items():
            if weights.any() or self.weight_weights[key].any():
                total = total + self.goal.nodes[key](self.x).curvature(weights, self.weight_weights[key])
        return total


class GoalConstraints(Constraints):
    """The rows of a goal: nodes beyond no variable and within limits, then limits on measures without corners."""

    def __init__(self, goal: Goal) -> None:
        self.goal, blocks = goal, goal.blocks
        pointwise = ("at", "range", *EVERYWHERE)
        self._smooth = [
            (k, h) for k, h in enumerate(goal.limits) if h.is_reached or h.measure.kind not in pointwise
        ]  # fmt: skip
        self._steps = np.array([goal.step(h) for _, h in self._smooth])
        levels = np.array([h.number for _, h in self._smooth]) / self._steps
        upper = np.array([h.sign > 0 for _, h in self._smooth], dtype=bool)

        def spread(field: Callable[[ConstraintBlock], float]) -> Array:
            return np.concatenate([np.empty(0), *(np.full(len(block.samples), field(block)) for block in blocks)])

        self.lower = np.concatenate([spread(lambda b: b.lower), np.where(upper, -np.inf, levels)])
        self.upper = np.concatenate([spread(lambda b: b.upper), np.where(upper, levels, np.inf)])
        owners = [*spread(lambda b: b.owner), *(k for k, _ in self._smooth)]
        self.owner: Integers = np.array(owners, dtype=np.int64)
        self.kinds = [*(_name(goal, limit) for limit in goal.limits), NamedConstraint("extremes")]

    def values(self, y: Array) -> Array:
        """Return the rows (k,) at variables y (p + q,)."""
        x, variables = np.split(y, [self.goal.size])
        rows = [np.empty(0)]
        for block in self.goal.blocks:
            row = block.factor * self._at(block, x).values[block.output, block.samples]
            rows.append(row + block.share * variables[block.variable] if block.share else row)
        smooth = [self.goal.term(x, limit.measure).value for _, limit in self._smooth]
        return np.concatenate([*rows, np.array(smooth) / self._steps])

    def slopes(self, y: Array) -> Array:
        """Return the Jacobian (k, p + q) of the rows."""
        x, size = y[: self.goal.size], self.goal.size
        jacobian = np.zeros((self.count, len(y)))
        first = 0
        for block in self.goal.blocks:
            rows = slice(first, first + len(block.samples))
            jacobian[rows, :size] = block.factor * self._at(block, x).slopes[block.output, block.samples]
            if block.share:
                jacobian[rows, size + block.variable] = block.share
            first = rows.stop
        for row, (_, limit) in enumerate(self._smooth):
            jacobian[first + row, :size] = self.goal.term(x, limit.measure).gradient / self._steps[row]
        return jacobian

    def curvature(self, y: Array, weights: Array) -> Array:
        """Return the sum (p + q, p + q) of the Hessians of the rows with weights (k,)."""
        bending = Bending(self.goal, y[: self.goal.size])
        first = 0
        for block in self.goal.blocks:
            part = weights[first : first + len(block.samples)]
            np.add.at(bending.weights[block.key][block.output], block.samples, part * block.factor)
            first += len(block.samples)
        for row, (_, limit) in enumerate(self._smooth):
            bending.add(limit.measure, weights[first + row] / self._steps[row])
        return self.goal.pad(bending.total())

    def _at(self, block: ConstraintBlock, x: Array) -> NodeValues:
        return self.goal.nodes[block.key](x)


def _name(goal: Goal, limit: Limit) -> NamedConstraint:
    return NamedConstraint(str(limit), ("max" if limit.sign > 0 else "min",), "1", goal.step(limit))


def _key(measure: Measure) -> Key:
    if measure.kind == "jump":
        return JUMPS
    if measure.where is not None:
        return measure.where
    if measure.angle is not None:
        return ANGLES
    return measure.during or CYCLE
