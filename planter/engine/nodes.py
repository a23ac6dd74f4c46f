"""Angles of a cycle at which a measure takes quantities: fixed ones, an extremum of a quantity, parts of the cycle.

Angles and weights that move with the design are linear in a few anchors: angles at which a condition's quantity passes
its limit, or at which the derivative of a quantity vanishes. With G(phi, x) = 0 at an anchor a(x), implicit
differentiation gives a' = -G_x / G_phi, and a'' = -H / G_phi, where H is the second derivative of G along (a', 1).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Extremum, MeasureCondition
from planter.engine.response import DesignPoint, MachineResponse, Switchings
from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import extrema, roots
from planter.numerics.arrays import Integers, LastCallCache

SCANNED = 360
"""Samples of a cycle among which anchors are looked for, at least."""
SIDE = 1e-9
"""Distance of the nodes on both sides of a switching point [rad]."""
CORNER = 1e-6
"""Share of the slopes a step away that a slope keeps at an extremum only if it jumps there: it is a corner."""
SPAN_NODES = 65
"""Nodes of a part of a cycle, its ends included."""
SPARE_EVENTS = 2
"""Switching points that may appear beyond those of the machine's own design."""
SPARE_SPANS = 1
"""Parts of a cycle that may appear beyond those of the machine's own design."""


@dataclass(frozen=True)
class NodeValues:
    """Quantities (m, n) at the nodes of a design in the units of their keys, with Jacobians (m, n, p) in the design.

    `weights` (n,) are those of the nodes in an integral over the cycle, whose length is 1, with slopes (n, p).
    `curvature` (weights of the values (m, n), of the weights (n,)) is the weighted sum of all their Hessians (p, p).
    `is_empty` holds if a condition never does; the nodes are then where it is nearest to it.
    """

    values: Array
    slopes: Array
    weights: Array
    weight_slopes: Array
    curvature: Callable[[Array, Array], Array]
    is_empty: bool = False


class Nodes(ABC):
    """Quantities by name at nodes over designs x (p,)."""

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.machine, self.names = machine, tuple(names)
        self.response = MachineResponse(machine, names)
        self.units = np.array([quantity.factor for quantity in self.response.quantities])
        self._latest = LastCallCache(self.evaluate)

    def restart(self) -> None:
        """Forget all designs so far, as `Response.restart`."""
        self.response.restart()
        self._latest = LastCallCache(self.evaluate)

    def __call__(self, x: Array) -> NodeValues:
        """Return the quantities at a design. Raises ComputationError where loops do not close."""
        return self._latest(x)

    @abstractmethod
    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at a design x (p,), without a cache."""

    def find_peaks(self, x: Array, name: str) -> tuple[Array, Array]:
        """Return where a quantity may have extremes between nodes, as `with_nodes` takes it, and its values there.

        The end of a turn is among them, since not every quantity is there what it was at its beginning.
        """
        return np.empty(0), np.empty(0)

    def with_nodes(self, places: Array) -> Nodes:
        """Return the nodes with more of them, which have no weight."""
        return self

    def _stationary(self, x: Array, name: str, grid: Array) -> tuple[Array, Array]:
        """Return angles between those of a grid (n,) at which a quantity is stationary, and its values there."""
        row, point = self.names.index(name), self.response.at(x)

        def rates(phi: Array) -> tuple[Array, Array]:
            first, second = self.response.rates(point, phi)
            return first[row], second[row]

        angles, _ = extrema.find_stationary_points(rates, grid, rates(grid)[0])
        values: Array = self.response.values(point, angles)[row] / self.units[row] if len(angles) else np.empty(0)
        return angles, values


class FixedNodes(Nodes):
    """Nodes at angles (n,) [rad], with weights (n,) that count the same unless they are given."""

    def __init__(self, machine: Machine, names: Sequence[str], angles: Array, weights: Array | None = None) -> None:
        super().__init__(machine, names)
        self.angles = angles
        self.weights = np.full(len(angles), 1 / max(len(angles), 1)) if weights is None else weights

    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at the nodes of a design x (p,)."""
        point, units = self.response.at(x), self.units[:, None]
        values, slopes = self.response.slopes(point, self.angles)

        def curvature(weights: Array, _: Array) -> Array:
            return self.response.curvature(point, self.angles, weights / units)[1:, 1:]

        fixed = np.zeros((len(self.angles), len(x)))
        return NodeValues(values / units, slopes[:, :, 1:] / units[:, :, None], self.weights, fixed, curvature)

    def find_peaks(self, x: Array, name: str) -> tuple[Array, Array]:
        """Return places of extremes between nodes, as `with_nodes` takes them, and the values there."""
        turn = self.machine.turn
        angles, values = self._stationary(x, name, np.append(self.angles[self.angles < turn], turn))
        end = self.response.values(self.response.at(x), np.array([turn]))[self.names.index(name)]
        return np.append(angles, turn), np.append(values, end / self.units[self.names.index(name)])

    def with_nodes(self, places: Array) -> FixedNodes:
        """Return the nodes with more of them at some places, which have no weight."""
        places = np.setdiff1d(places, self.angles)
        order = np.argsort(np.concatenate([self.angles, places]))
        angles, weights = np.append(self.angles, places), np.append(self.weights, np.zeros(len(places)))
        return FixedNodes(self.machine, self.names, angles[order], weights[order])


@dataclass(frozen=True)
class Placement:
    """Nodes as linear functions of anchors (a,): angles = fixed + mix @ anchors, weights = given + shares @ anchors.

    `rows` (a,) are the rows of the anchors' response that vanish there, or pass a constant.
    """

    anchors: Array
    rows: Integers
    fixed: Array
    mix: Array
    weights: Array
    shares: Array
    is_empty: bool = False

    @classmethod
    def at_rest(cls, angles: Array, is_empty: bool = False) -> Placement:
        """Return a placement of nodes that do not move and count the same."""
        count, none = len(angles), np.empty((len(angles), 0))
        weights = np.full(count, 1 / count)
        return cls(np.empty(0), np.empty(0, dtype=np.int64), angles, none, weights, none, is_empty)


class MovingNodes(Nodes):
    """Nodes that move with the design by anchors, which are zeros of rows of another response."""

    def __init__(self, machine: Machine, names: Sequence[str], anchors: MachineResponse) -> None:
        super().__init__(machine, names)
        self.anchors = anchors
        count = max(machine.samples, SCANNED)
        self.grid = machine.list_angles(count)

    def restart(self) -> None:
        """Forget all designs so far, of the anchors too."""
        super().restart()
        self.anchors.restart()

    @abstractmethod
    def place(self, point: DesignPoint) -> Placement:
        """Return where the nodes are at a design."""

    def evaluate(self, x: Array) -> NodeValues:
        """Return the quantities at the nodes of a design x (p,)."""
        point, units = self.response.at(x), self.units[:, None]
        placement = self.place(point)
        angles = placement.fixed + placement.mix @ placement.anchors
        count = np.arange(len(placement.anchors))
        rises, moving = np.ones(len(count)), np.empty((len(count), len(x)))
        if len(count):
            slopes = self.anchors.slopes(point, placement.anchors)[1][placement.rows, count]
            rises = slopes[:, 0]
            moving = -slopes[:, 1:] / rises[:, None]
        angle_slopes = placement.mix @ moving
        values, slopes = self.response.slopes(point, angles)

        def curvature(weights: Array, weight_weights: Array) -> Array:
            scaled = weights / units
            total = self.response.curvature_along(point, angles, scaled, angle_slopes)
            if len(count):
                bending = placement.mix.T @ (scaled * slopes[:, :, 0]).sum(axis=0) + placement.shares.T @ weight_weights
                rows = np.zeros((len(self.anchors.quantities), len(count)))
                rows[placement.rows, count] = -bending / rises
                total = total + self.anchors.curvature_along(point, placement.anchors, rows, moving)
            return total

        return NodeValues(
            values / units,
            (slopes[:, :, 1:] + slopes[:, :, :1] * angle_slopes) / units[:, :, None],
            placement.weights + placement.shares @ placement.anchors,
            placement.shares @ moving,
            curvature,
            placement.is_empty,
        )


class ExtremumNode(MovingNodes):
    """The angle at which a quantity is greatest or least over the cycle."""

    def __init__(self, machine: Machine, names: Sequence[str], extremum: Extremum) -> None:
        super().__init__(machine, names, MachineResponse(machine, [extremum.name], rates=[extremum.name]))
        self.extremum = extremum

    def place(self, point: DesignPoint) -> Placement:
        """Return the placement of the nodes at a design."""
        values = self.anchors.values(point, self.grid)[0]
        index = extrema.index_first_extremum(self.grid, values, self.extremum.sign)
        step = self.grid[1]
        bracket = self.grid[index] + np.array([-step, step])
        ends = self.anchors.values(point, bracket)[1]

        def rate(phi: Array) -> tuple[Array, Array]:
            rates, slopes = self.anchors.slopes(point, phi)
            return rates[1], slopes[1, :, 0]

        is_corner = ends[0] * ends[1] > 0
        if not is_corner:
            anchor = roots.find_bracketed_roots(rate, bracket[:1], bracket[1:], (ends[:1], ends[1:]))
            is_corner = abs(float(rate(anchor)[0][0])) > CORNER * np.abs(ends).max()
        if is_corner:
            angle = np.degrees(self.grid[index])
            raise ComputationError(f"{self.machine.name}: {self.extremum} at a corner, near {angle:.6g} deg")
        unit = np.ones((1, 1))
        return Placement(anchor, np.array([1]), np.zeros(1), unit, np.ones(1), 0 * unit)


class EventNodes(MovingNodes):
    """Both sides of the switching points of a machine, at which its quantities may jump.

    There are as many as at the machine's own design; where a design has fewer, the first stands for the others.
    """

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.switchings = Switchings(machine, max(machine.samples, SCANNED))
        super().__init__(machine, names, self.switchings.response)
        self.count = max(len(self.switchings.find(self.response.at(machine.design))[0]), 1)

    def place(self, point: DesignPoint) -> Placement:
        """Return the placement of the nodes at a design."""
        angles, rows = self.switchings.find(point)
        if not len(angles):
            return Placement.at_rest(np.zeros(2 * self.count))
        return _place_around(angles, rows, self.count, SIDE * np.array([-1.0, 1.0]))


def _place_around(angles: Array, rows: Integers, count: int, sides: Array) -> Placement:
    """Return nodes at distances (k,) from `count` anchors, of which the first takes the place of missing ones."""
    chosen = np.arange(count)
    chosen[len(angles) :] = 0
    mix = np.repeat(np.eye(len(angles))[chosen], len(sides), axis=0)
    return Placement(angles, rows, np.tile(sides, count), mix, np.zeros(len(mix)), np.zeros_like(mix))


class JumpNodes(MovingNodes):
    """The jumps of quantities where a law of a machine changes, one a node, in place of their values.

    Events of order 0 count: it is the order of the forces, and no result is rougher than they. One-sided values are
    continued from two points of a side up to the event, so that what does not jump there has no jump but rounding.
    There are as many nodes as events at the machine's own design, and some to spare; those that are missing are the
    first event's. Without events every jump is zero.
    """

    SIDES = SIDE * np.array([-2.0, -1.0, 1.0, 2.0])
    SHARES = np.array([1.0, -2.0, 2.0, -1.0])

    def __init__(self, machine: Machine, names: Sequence[str]) -> None:
        self.switchings = Switchings(machine, max(machine.samples, SCANNED))
        super().__init__(machine, names, self.switchings.response)
        rough = [row for row, kind in enumerate(self.switchings.kinds) if kind.get("order", 0) == 0]
        self.rough = np.array(rough, dtype=np.int64)
        events = len(self._find(self.response.at(machine.design))[0])
        self.count = events + SPARE_EVENTS if len(self.rough) else 1

    def _find(self, point: DesignPoint) -> tuple[Array, Integers]:
        """Return the angles (s,) at which forces jump, and the rows of these events."""
        angles, rows = self.switchings.find(point)
        chosen = np.isin(rows, self.rough)
        return angles[chosen], rows[chosen]

    def place(self, point: DesignPoint) -> Placement:
        """Return two nodes on each side of every event."""
        angles, rows = self._find(point)
        if not len(angles):
            return Placement.at_rest(np.zeros(4 * self.count), is_empty=True)
        if len(angles) > self.count:
            raise ComputationError(f"{self.machine.name}: a law changes {len(angles)} times in the cycle")
        return _place_around(angles, rows, self.count, self.SIDES)

    def evaluate(self, x: Array) -> NodeValues:
        """Return the jumps in place of values, without weights."""
        at = super().evaluate(x)
        shares = np.kron(np.eye(self.count), np.zeros(4) if at.is_empty else self.SHARES)

        def curvature(weights: Array, _: Array) -> Array:
            return at.curvature(weights @ shares, np.zeros(4 * self.count))

        none = np.zeros(self.count)
        slopes = np.einsum("kn,mnp->mkp", shares, at.slopes)
        return NodeValues(at.values @ shares.T, slopes, none, np.zeros((self.count, len(x))), curvature)


class SpanNodes(MovingNodes):
    """The parts of the cycle on which all conditions hold.

    Every part has nodes at the same shares (k,) of its length, both ends among them, with the weights of Clenshaw and
    Curtis's quadrature. If there are fewer parts than places for them, the first stands for those that are missing.
    """

    def __init__(
        self, machine: Machine, names: Sequence[str], conditions: Sequence[MeasureCondition],
        shares: Array | None = None, weights: Array | None = None, capacity: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__(machine, names, MachineResponse(machine, [condition.name for condition in conditions]))
        self.conditions = tuple(conditions)
        factors = np.array([quantity.factor for quantity in self.anchors.quantities])
        self.levels = factors * [condition.number for condition in conditions]
        quadrature = clenshaw_curtis(SPAN_NODES)
        self.shares = quadrature[0] if shares is None else shares
        self.share_weights = quadrature[1] if weights is None else weights
        self.capacity = capacity or max(len(self._spans(self.response.at(machine.design))[0]), 1) + SPARE_SPANS

    def place(self, point: DesignPoint) -> Placement:
        """Return the placement of the nodes at a design."""
        anchors, rows, excess = self._spans(point)
        spans, count = len(anchors), len(self.shares)
        if not spans:
            if (excess <= 0).all():
                return Placement.at_rest(self.machine.list_angles(self.capacity * count))
            return Placement.at_rest(np.full(self.capacity * count, self.grid[int(np.argmin(excess))]), is_empty=True)
        if spans > self.capacity:
            conditions = " and ".join(map(str, self.conditions))
            raise ComputationError(f"{self.machine.name}: the cycle has {spans} parts on which {conditions}")
        mix = np.zeros((self.capacity, count, 2 * spans))
        weights = np.zeros((self.capacity, count, 2 * spans))
        for place in range(self.capacity):
            span = place if place < spans else 0
            mix[place, :, 2 * span] = 1 - self.shares
            mix[place, :, 2 * span + 1] = self.shares
            if place < spans:
                weights[place, :, 2 * span] = -self.share_weights / self.machine.turn
                weights[place, :, 2 * span + 1] = self.share_weights / self.machine.turn
        total = self.capacity * count
        flat = (total, 2 * spans)
        nothing = np.zeros(total)
        return Placement(anchors.ravel(), rows.ravel(), nothing, mix.reshape(flat), nothing, weights.reshape(flat))

    def find_peaks(self, x: Array, name: str) -> tuple[Array, Array]:
        """Return places of extremes between nodes, as `with_nodes` takes them, and the values there."""
        placement = self.place(self.response.at(x))
        if not len(placement.anchors):
            return super().find_peaks(x, name)
        places, values = [], []
        for begin, end in placement.anchors.reshape(-1, 2):
            angles, peaks = self._stationary(x, name, begin + (end - begin) * np.sort(self.shares))
            places.append((angles - begin) / (end - begin))
            values.append(peaks)
        return np.concatenate(places), np.concatenate(values)

    def with_nodes(self, places: Array) -> SpanNodes:
        """Return the nodes with more of them at some places, which have no weight."""
        places = np.setdiff1d(places, self.shares)
        weights = np.append(self.share_weights, np.zeros(len(places)))
        shares = np.append(self.shares, places)
        return SpanNodes(self.machine, self.names, self.conditions, shares, weights, self.capacity)

    def _spans(self, point: DesignPoint) -> tuple[Array, Integers, Array]:
        """Return begin and end of all parts (s, 2), the conditions that end them, and by how much the grid misses all.

        The list is empty if the conditions hold everywhere or nowhere on the grid.
        """
        excess, _, _ = self._excess(point, self.grid)
        inside = excess <= 0
        following = np.roll(inside, -1)
        changes = np.flatnonzero(inside != following)
        if not len(changes):
            return np.empty((0, 2)), np.empty((0, 2), dtype=np.int64), excess
        low, step = self.grid[changes], self.grid[1]

        def function(phi: Array) -> tuple[Array, Array]:
            value, slope, _ = self._excess(point, phi)
            return value, slope

        ends = excess[changes], np.roll(excess, -1)[changes]
        places = roots.find_bracketed_roots(function, low, low + step, ends)
        rows = self._excess(point, places)[2]
        first = int(inside[changes[0]])  # the part at the grid's first angle begins before it
        places, rows = np.roll(places, -first), np.roll(rows, -first)
        if first:
            places[-1] += self.machine.turn
        return places.reshape(-1, 2), rows.reshape(-1, 2), excess

    def _excess(self, point: DesignPoint, phi: Array) -> tuple[Array, Array, Integers]:
        """Return by how much the worst condition is missed (n,), its slope in the angle, and which one that is."""
        values, slopes = self.anchors.slopes(point, phi)
        rises = slopes[:, :, 0]
        absolute = np.array([condition.absolute for condition in self.conditions])[:, None]
        signs = np.array([float(condition.sign) for condition in self.conditions])[:, None]
        rises = signs * np.where(absolute, np.sign(values) * rises, rises)
        excess = signs * (np.where(absolute, np.abs(values), values) - self.levels[:, None])
        worst = np.argmax(excess, axis=0)
        lanes = np.arange(len(phi))
        return excess[worst, lanes], rises[worst, lanes], worst


def clenshaw_curtis(count: int) -> tuple[Array, Array]:
    """Return nodes (n,) on [0, 1], the ends among them, and weights (n,): exact for polynomials of degree n - 1."""
    angles = np.pi * np.arange(count) / (count - 1)
    orders = np.arange(0, count, 2)
    moments = 1 / (1.0 - orders**2)
    moments[1:] *= 2
    if count % 2:
        moments[-1] /= 2
    weights = np.cos(np.outer(angles, orders)) @ moments / (count - 1)
    weights[[0, -1]] /= 2
    return (1 - np.cos(angles)) / 2, weights
