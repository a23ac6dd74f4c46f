"""Extremes and integrals of many machines of one build, between all their events.

Events of a block of machines are located together; every piece between them has the nodes of
`PiecewiseFunctions`, which are not halved. A machine whose series do not fall off is evaluated
again with more panels, at last by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from functools import cache, cached_property

import casadi as ca
import numpy as np

from planter.engine.machine import LEAST_PIVOT
from planter.engine.response import INPUTS
from planter.engine.rows import ClosedRows, MachineRows
from planter.engine.summary import CycleRow, PiecewiseCycle
from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers, Kernel
from planter.kernels.kernel import StackedKernel
from planter.numerics import piecewise
from planter.numerics.piecewise import MERGED_DISTANCE, NODES
from planter.numerics.roots import Crossings, FunctionWithSlope, locate_crossings

MOST_ROWS = 64
"""Machines of a block."""
ATTEMPTS = (24, 72, 216)
"""Panels of a turn at least, in attempts one after the other."""
FEWEST = 2
"""Panels of a piece at least."""
TOLERANCE = 3e-10
"""A series falls off if its share of the cycle times a last coefficient is below this share of the
mean size.
"""
DENSE, CANDIDATES, STEPS = 25, 4, 5
"""Points of a panel among which its extremum is looked for, panels that are refined, and steps of
Newton's method.
"""

Measures = Mapping[str, Array]
"""Measures (m, rows) by kind."""


class TrueRows:
    """True measures of the quantities of rows of values d (r, v) in SI; see `MachineRows`."""

    def __init__(self, rows: MachineRows) -> None:
        self.rows, self.machine = rows, rows.machine
        kinds = self.machine.event_kinds or ({},) * self._events.numel()
        self._periods = np.array([kind.get("period") or np.inf for kind in kinds])

    def compile(self) -> None:
        """Compile what every row calls."""
        self._values.compile()
        self.rows.hoist.compile()
        if len(self._periods):
            self._scan.compile()
            self._point.compile()
        if self.machine.loops:
            self.machine.loops.compile()

    def evaluate(self, d: Array, threads: int = 1) -> Array:
        """Return measures (r, m, k) of machines with values d (r, v), k as in `KINDS`; NaN without
        a cycle.
        """
        return self.rows.split(
            d, lambda part: self._evaluate(part).reshape(len(part), -1), threads
        ).reshape(len(d), len(self.rows.names), len(KINDS))

    def _evaluate(self, d: Array) -> Array:
        closed = self.rows.close(np.ascontiguousarray(d, dtype=float))
        table = np.full((len(d), len(self.rows.names), len(KINDS)), np.nan)
        alive = np.flatnonzero(closed.alive)
        with np.errstate(all="ignore"):  # of rows that fail
            for start in range(0, len(alive), MOST_ROWS):
                block = alive[start : start + MOST_ROWS]
                table[block] = self._measure(closed, block)
        if len(alive):
            repeats = self.rows.find_repeats(closed, alive).T
            averages = [KINDS.index(kind) for kind in AVERAGED]
            part = table[alive]
            part[np.ix_(range(len(alive)), range(len(self.rows.names)), averages)] = np.where(
                repeats[:, :, None], part[:, :, averages], np.nan
            )
            table[alive] = part
        return table

    def _measure(self, closed: ClosedRows, rows: Integers) -> Array:
        try:
            return self._measure_together(closed, rows)
        except ComputationError:  # a root of one of them, which takes no digit from the others
            if len(rows) == 1:
                return self._measure_alone(closed.d[rows[0]])[None]
            return np.concatenate(
                [self._measure(closed, rows[[index]]) for index in range(len(rows))]
            )

    def _measure_together(self, closed: ClosedRows, rows: Integers) -> Array:
        table = np.full((len(rows), len(self.rows.names), len(KINDS)), np.nan)
        rough, block = np.arange(len(rows)), _Block(self, closed, rows)
        for pieces in self._attempts:
            table[rough], is_resolved = block.measure(pieces)
            if is_resolved.all():
                return table
            rough, block = rough[~is_resolved], block.select(np.flatnonzero(~is_resolved))
        for index in rough:
            table[index] = self._measure_alone(closed.d[rows[index]])
        return table

    @cached_property
    def _attempts(self) -> tuple[int, ...]:
        """The attempts from the first on that resolves the machine's own values: rows do not
        influence each other.
        """
        closed = self.rows.close(self.machine.data[None])
        if closed.alive.all():
            with np.errstate(all="ignore"):
                for index, pieces in enumerate(ATTEMPTS):
                    if _Block(self, closed, np.zeros(1, dtype=np.int64)).measure(pieces)[1].all():
                        return ATTEMPTS[index:]
        return ATTEMPTS

    def _measure_alone(self, d: Array) -> Array:
        """Return the measures (m, k) of one machine."""
        table = np.full((len(self.rows.names), len(KINDS)), np.nan)
        machine = self.machine.with_data(d)
        rows = [
            CycleRow(quantity, machine.graph(quantity.name)) for quantity in self.rows.quantities
        ]
        try:
            cycle = PiecewiseCycle(machine, rows)
            for k, row in enumerate(rows):
                name = row.quantity.name
                if cycle.find_pole(name) is None:
                    high, low = (cycle.extreme(name, sign).value for sign in (1, -1))
                    mean, rms = float(cycle.pieces.mean[k]), float(cycle.pieces.rms[k])
                    table[k] = _list_measures(
                        *map(np.asarray, (high, low, mean, rms, cycle.pieces.variance[k]))
                    )
        except ComputationError:
            pass
        return table

    # --- the functions behind it
    # ---------------------------------------------------------------------

    @cached_property
    def _events(self) -> ca.SX:
        events = self.machine.events
        return ca.SX(0, 1) if events is None else ca.densify(events(*self.machine.symbols))

    def _build(self, name: str, outputs: Mapping[str, ca.SX]) -> ca.Function:
        graphs = ca.cse([ca.densify(graph) for graph in outputs.values()])
        return ca.Function(name, list(self.machine.symbols), graphs, list(INPUTS), list(outputs))

    @cached_property
    def _scan(self) -> StackedKernel:
        """(phi, d, h, q) -> values of events and slopes."""
        slopes = ca.jacobian(self._events, self.machine.symbols[0])
        return StackedKernel(
            self._build("scanned", {"g": self._events, "dg": slopes}), ["phi", "q"], ["d", "h", "q"]
        )

    @cached_property
    def _point(self) -> Kernel:
        """(phi, d, h, q) -> values of events, slopes and second derivatives, a machine in each
        lane.
        """
        first = ca.densify(ca.jacobian(self._events, self.machine.symbols[0]))
        second = ca.jacobian(first, self.machine.symbols[0])
        function = self._build("passed", {"g": self._events, "dg": first, "ddg": second})
        return Kernel(function, lanes=list(INPUTS))

    @cached_property
    def _values(self) -> StackedKernel:
        """(phi, d, h, q) -> quantities of a side, then guards, each machine at its own angles."""
        function = self._build("passing", {"rows": self.rows.graph})
        return StackedKernel(function, ["phi", "q"], list(INPUTS))


class _Block:
    """Some machines with their events."""

    def __init__(self, owner: TrueRows, closed: ClosedRows, rows: Integers) -> None:
        self.owner, self.machine, self.closed, self.rows = owner, owner.machine, closed, rows
        self.data = np.ascontiguousarray(closed.data[:, rows])
        self.h = owner.rows.hoist.masked(d=self.data)[0]["h"]
        self.places = closed.places[:, :, rows]
        crossings = self._locate() if len(owner._periods) else None
        self.edges = [self._list_edges(crossings, row) for row in range(len(rows))]

    def select(self, index: Integers) -> _Block:
        """Return some of the machines."""
        part = copy(self)
        part.rows, part.edges = self.rows[index], [self.edges[row] for row in index]
        part.data = np.ascontiguousarray(self.data[:, index])
        part.h = np.ascontiguousarray(self.h[:, index])
        part.places = self.places[:, :, index]
        return part

    def _locate(self) -> Crossings:
        owner, turn = self.owner, self.machine.turn
        grid = np.append(owner.rows.steps, turn)
        count = len(owner._periods)
        q = np.concatenate(
            [self.places, self.places[:, :1] + self._gained[:, None]], axis=1
        ).transpose(2, 0, 1)
        scan = owner._scan(phi=grid[None], d=self.data.T, h=self.h.T, q=np.ascontiguousarray(q))
        size = len(self.rows) * count
        periods = np.tile(owner._periods, len(self.rows))
        return locate_crossings(
            grid,
            scan["g"].reshape(size, -1),
            scan["dg"].reshape(size, -1),
            periods,
            turn,
            lambda functions: self._pick(functions, "g", "dg"),
            lambda functions: self._pick(functions, "dg", "ddg"),
        )

    @property
    def _gained(self) -> Array:
        return self.closed.gained[:, self.rows]

    def _pick(self, functions: Integers, first: str, second: str) -> FunctionWithSlope:
        rows, events = np.divmod(functions, len(self.owner._periods))
        lanes = np.arange(len(functions))

        def picked(points: Array) -> tuple[Array, Array]:
            if not len(points):
                return points, points
            q = self._close(points[None], rows)[0]
            result = self.owner._point.masked(
                phi=points, d=self.data[:, rows], h=self.h[:, rows], q=q
            )[0]
            return result[first][events, lanes], result[second][events, lanes]

        return picked

    def _close(self, phi: Array, rows: Integers) -> tuple[Array, Flags]:
        """Return coordinates of loops (c, n) at angles (1, n) of machines (n,), and which
        closed.
        """
        loops = self.machine.loops
        if loops is None:
            return np.empty((0, phi.size)), np.ones(phi.size, dtype=bool)
        steps = self.owner.rows.steps
        index = np.round(phi[0] / self.machine.turn * len(steps)).astype(int)
        turns, index = np.divmod(index, len(steps))
        q = self.places[:, index, rows] + turns * self._gained[:, rows]
        q, _, is_closed = loops.close(phi[0], np.ascontiguousarray(self.data[:, rows]), q)
        return q, is_closed

    def _list_edges(self, crossings: Crossings | None, row: int) -> Array:
        """Return the ends of the pieces of a machine, over all sides."""
        turn, angles = self.machine.turn, np.empty(0)
        if crossings is not None:
            count = len(self.owner._periods)
            parts = ((crossings.angles, crossings.rows), (crossings.touches, crossings.touch_rows))
            angles = np.concatenate([angles[rows // count == row] for angles, rows in parts])
        angles = np.sort(np.mod(np.subtract.outer(angles, self.machine.offsets), turn).ravel())
        angles = angles[(angles > MERGED_DISTANCE) & (angles < turn - MERGED_DISTANCE)]
        return np.concatenate(
            [[0.0], angles[np.diff(angles, prepend=0.0) > MERGED_DISTANCE], [turn]]
        )

    def measure(self, pieces: int) -> tuple[Array, Flags]:
        """Return measures (rows, m, k) by that many panels of a turn at least, and which rows these
        resolve.
        """
        phi, weights = self._place(pieces)
        values, is_finite = self._evaluate(phi)
        series = values @ piecewise.to_series()
        share = weights.sum(axis=2)
        mean = np.einsum("rmpn,rpn->rm", values, weights)
        square = np.einsum("rmpn,rpn->rm", values**2, weights)
        variance = np.einsum("rmpn,rpn->rm", (values - mean[:, :, None, None]) ** 2, weights)
        size = np.einsum("rmpn,rpn->rm", np.abs(values), weights)
        tails = np.abs(series[..., -piecewise.TAIL_LENGTH :]).max(axis=3) * share[:, None]
        is_resolved = (tails <= TOLERANCE * size[:, :, None]).all(axis=(1, 2)) & is_finite
        high, low = _find_greatest(series), -_find_greatest(-series)
        return _list_measures(high, low, mean, np.sqrt(square), variance), is_resolved

    def _place(self, pieces: int) -> tuple[Array, Array]:
        """Return angles and weights (rows, p, n) of nodes; short rows repeat their first panel
        without weight.
        """
        turn = self.machine.turn
        rows = [piecewise.place_panels(edges, pieces, turn, FEWEST) for edges in self.edges]
        widest = max(len(angles) for angles, _ in rows)
        phi, weights = np.empty((len(rows), widest, NODES)), np.zeros((len(rows), widest, NODES))
        for row, (angles, row_weights) in enumerate(rows):
            phi[row], phi[row, : len(angles)], weights[row, : len(angles)] = (
                angles[0],
                angles,
                row_weights / turn,
            )
        return phi, weights

    def _evaluate(self, phi: Array) -> tuple[Array, Flags]:
        """Return quantities (rows, m, p, n) at nodes, and which rows are finite and determined."""
        owner = self.owner.rows
        offsets = self.machine.offsets if owner.sides > 1 else (0.0,)
        flat = phi.reshape(len(phi), 1, -1)
        lanes = np.concatenate([flat + offset for offset in offsets], axis=2)
        count = lanes.shape[2]
        index = np.repeat(np.arange(len(phi)), count)
        q, is_closed = self._close(lanes.reshape(1, -1), index)
        q = np.ascontiguousarray(q.reshape(len(q), len(phi), count).transpose(1, 0, 2))
        values = self.owner._values(phi=lanes, d=self.data.T, h=self.h.T, q=q)["rows"]
        size = len(owner.names)
        guards = values[:, size:]
        is_finite: Flags = np.asarray(np.isfinite(values).all(axis=(1, 2)))
        is_finite &= is_closed.reshape(len(phi), -1).all(axis=1)
        for row, guard in zip(guards.transpose(1, 0, 2), owner.guards, strict=True):
            is_determined = row >= LEAST_PIVOT if guard.role == "pivot" else row != 0
            is_finite &= np.asarray(is_determined).all(axis=1)
        sides = values[:, :size].reshape(len(phi), size, len(offsets), -1)
        shared = np.array(owner.shared, dtype=bool)[None, :, None]
        folded = np.where(shared, sides.sum(axis=2), sides[:, :, 0])
        return folded.reshape(len(phi), size, *phi.shape[1:]), is_finite


KINDS = ("max", "min", "range", "mean", "rms", "variance", "std")
"""Kinds of measures, in the order of the tables."""
AVERAGED = ("mean", "rms", "variance", "std")


def _list_measures(high: Array, low: Array, mean: Array, rms: Array, variance: Array) -> Array:
    return np.stack([high, low, high - low, mean, rms, variance, np.sqrt(variance)], axis=-1)


def _find_greatest(series: Array) -> Array:
    """Return the greatest values (r, m) of Legendre series (r, m, p, n) over all panels, their ends
    included.
    """
    legendre = np.polynomial.legendre
    points = np.linspace(-1, 1, DENSE)
    dense = series @ legendre.legvander(points, NODES - 1).T
    peaks = dense.max(axis=3)
    panels = np.argsort(-peaks, axis=2)[:, :, :CANDIDATES]
    chosen = np.take_along_axis(series, panels[..., None], axis=2)
    v = points[np.take_along_axis(dense.argmax(axis=3), panels, axis=2)]
    first, second = (_differentiate(order) for order in (1, 2))
    for _ in range(STEPS):
        basis = legendre.legvander(v, NODES - 1)
        slope, bend = ((basis * (chosen @ matrix)).sum(axis=-1) for matrix in (first, second))
        step = np.where(bend < 0, -slope / bend, 0.0)
        v = np.clip(v + np.clip(step, -2 / DENSE, 2 / DENSE), -1, 1)
    refined = (legendre.legvander(v, NODES - 1) * chosen).sum(axis=-1)
    greatest: Array = np.maximum(refined.max(axis=2), peaks.max(axis=2))
    return greatest


@cache
def _differentiate(order: int) -> Array:
    """Return the matrix (n, n) from a Legendre series, as a row, to that of a derivative."""
    rows = [np.polynomial.legendre.legder(row, order) for row in np.eye(NODES)]
    return np.array([np.pad(row, (0, NODES - len(row))) for row in rows])
