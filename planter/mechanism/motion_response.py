"""Quantities of a mechanism that moves freely over its time, with exact derivatives in the design.

The states follow from an integration, and their derivatives S in the design from the variational
equations along it,

    S' = A S + F,    A = df/dx,  F = df/dp,

by Gauss collocation on the integrator's steps. At the time t(x, p) at which an event e vanishes,
dt/dp = -(e_x S + e_p) / (e_t + e_x f-). Where another law begins there, S jumps by (f- - f+) dt/dp;
where an impact leads to the state R(t, x, p), it becomes R_x S + R_p + (R_x f- + R_t - f+) dt/dp
(saltation: Leine and Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004,
chapter 7).
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from threadpoolctl import threadpool_limits

from planter.engine.response import DesignPoint, MachineResponse, add_moving_angles
from planter.errors import ComputationError
from planter.kernels import Array, Integers, Kernel
from planter.mechanism.dynamics import EVENT_SAMPLES, Dynamics, MotionStep, Passage
from planter.mechanism.file import MechanismFile
from planter.mechanism.input_history import InputHistory
from planter.mechanism.state_space.model import DynamicsModel

TOLERANCE = 1e-10
"""Relative tolerance of the integrator."""
STAGES = 8
"""Nodes of the collocation in a step: its polynomial is as exact as the integrator's."""
DIFFERENCE = 1e-5
"""Step of the differences that second derivatives are, in parts of a value's range and of a turn."""
START_STEP = 1e-4
"""Step of the differences by which a start on constraints follows the design, in parts of it."""
AGREEMENT = 1e-6
"""Accelerations of the model and of the integration agree to this share: else a normal force that
friction follows from has changed its sign, or the constraints are others than at the start.
"""
TANGENT = 1e-6
"""Slopes of events over the whole time below this share of the largest value touch zero."""
MARGIN = 1e-12
"""Share of the whole time before an event, which is located to that, in which values are still those
of the arc before it.
"""
MOST_MOTIONS = 32
"""Motions that are kept: those of a design and of its neighbours, by which second derivatives
follow.
"""


class Motions:
    """The motions of a mechanism from its start to a time [s], each computed once."""

    def __init__(self, file: MechanismFile, span: float) -> None:
        data = file.data()
        history = InputHistory(values={i: data[i : i + 1] for i in range(len(data))})
        self.dynamics = Dynamics(file, history)
        self.model, self.span = DynamicsModel(Dynamics(file), open_signs=True), span
        names = [entry["name"] for entry in file.entries]
        self.inputs = [names.index(variable.name) for variable in self.model.inputs]
        self.parameters = [names.index(variable.name) for variable in self.model.parameters]
        self._motions: dict[bytes, SensitiveMotion] = {}
        self._recorded: dict[bytes, Sequence[MotionStep]] = {}

    def record(self, d: Array, steps: Sequence[MotionStep]) -> None:
        """Use an integration at values d (v,) for motions up to its end, instead of another one, until
        the next is recorded.

        Its steps are those of `Dynamics.integrate` with explicit steps, to `TOLERANCE`.
        """
        self._recorded = {d.tobytes(): steps}  # the latest alone: a page records many

    def over(self, span: float) -> Motions:
        """Return the motions to another time [s], which share the functions of these."""
        same = copy.copy(self)
        same.span, same._motions = span, {}
        return same

    def find(self, d: Array, moved: tuple[int, ...]) -> SensitiveMotion:
        """Return the motion at values d (v,) with its derivatives in those that are moved."""
        key = d.tobytes() + bytes(str(moved), "ascii")
        if key not in self._motions:
            if len(self._motions) >= MOST_MOTIONS:
                del self._motions[next(iter(self._motions))]
            self._motions[key] = SensitiveMotion(self, d, moved, self._find_steps(d))
        return self._motions[key]

    def _find_steps(self, d: Array) -> list[MotionStep]:
        """Return the recorded steps at values d (v,) up to the end of the span; none if they do not
        reach it.
        """
        recorded = self._recorded.get(d.tobytes(), ())
        if not recorded or recorded[-1].end < self.span:
            return []
        *steps, last = (step for step in recorded if step.start < self.span)
        crossed = [passage for passage in last.crossed if passage.time <= self.span]
        return [*steps, replace(last, end=min(last.end, self.span), crossed=crossed)]

    def split(self, d: Any) -> tuple[Any, Any]:
        """Return the inputs u and the parameters p of values d (v,)."""
        return d[self.inputs], d[self.parameters]

    @cached_property
    def slopes_kernel(self) -> Kernel:
        """(t, x, signs, d) -> A (2k 2k,), F (2k v,) by all values, column by column, and x'
        (2k,).
        """
        (t, x, d), signs = self._symbols, self._signs
        u, p = self.split(d)
        a, b, f = self.model.f_jacobian(t, x, u, p, signs)
        by_values = ca.SX(x.numel(), d.numel())
        by_values[:, self.inputs], by_values[:, self.parameters] = b, f
        outputs = [a, by_values, self.model.f(t, x, u, p, signs)[0]]
        outputs = ca.cse([ca.densify(ca.vec(part)) for part in outputs])
        function = ca.Function(
            "motion_slopes",
            [t, x, signs, d],
            outputs,
            ["t", "x", "signs", "d"],
            ["a", "f", "x_dot"],
        )
        return Kernel(function, ["t", "x", "signs"])

    @cached_property
    def rates_kernel(self) -> Kernel:
        """(t, x, signs, d) -> x' (2k,)."""
        (t, x, d), signs = self._symbols, self._signs
        rates = ca.densify(self.model.f(t, x, *self.split(d), signs)[0])
        names = ["t", "x", "signs", "d"]
        function = ca.Function("motion_rates", [t, x, signs, d], [rates], names, ["x_dot"])
        return Kernel(function, ["t", "x", "signs"])

    @cached_property
    def events_slopes(self) -> ca.Function:
        """(t, x, d) -> slopes (e, 1 + 2k + v) of the events in these."""
        t, x, d = self._symbols
        values = self.dynamics.formulas.function("events")
        symbols = {"time": t, "state": x, "data": d}
        events = values(*(symbols[name] for name in values.name_in()))
        slopes = ca.densify(ca.jacobian(events, ca.vertcat(t, x, d)))
        return ca.Function("events_slopes", [t, x, d], [slopes])

    @cached_property
    def impulse_slopes(self) -> ca.Function:
        """(t, x, d, jump (k,), impulses (c + i,)) -> slopes of the balance of impulses of all
        constraints and impacts, by jump and impulses, and by t, x, d.
        """
        graphs, size = self.dynamics.graphs, self.dynamics.size
        ways = ca.vertcat(graphs.slopes, graphs.opening_slopes)
        jump, impulses = ca.SX.sym("jump", size), ca.SX.sym("impulses", ways.size1())
        closing = ca.vertcat(
            ca.SX(graphs.slopes.size1(), 1), (1 + graphs.restitutions) * graphs.openings
        )
        balance = ca.vertcat(graphs.inertia @ jump - ways.T @ impulses, ways @ jump + closing)
        of_motion = [graphs.time, graphs.state, self.dynamics.history.symbols]
        unknowns = ca.vertcat(jump, impulses)
        slopes = [ca.jacobian(balance, v) for v in (unknowns, ca.vertcat(*of_motion))]
        outputs = list(map(ca.densify, slopes))
        return ca.Function("impulse_slopes", [*of_motion, jump, impulses], outputs)

    @cached_property
    def constraint_slopes(self) -> ca.Function:
        """(t, x, d) -> slopes (c, 2k + v) of gaps and speeds that the constraints keep zero."""
        t, x, d = self._symbols
        u, p = self.split(d)
        values = self.model.constraint_values(t, x, u, p, self.model.start_signs)
        return ca.Function(
            "constraints", [t, x, d], [ca.densify(ca.jacobian(values, ca.vertcat(x, d)))]
        )

    @cached_property
    def start_slopes(self) -> ca.Function:
        """(d) -> slopes (2k, v) of the stated start."""
        d = self._symbols[2]
        start = self.dynamics.formulas.function("start")(d)
        return ca.Function("start_slopes", [d], [ca.densify(ca.jacobian(start, d))])

    @cached_property
    def _signs(self) -> ca.SX:
        return ca.SX.sym("signs", len(self.model.start_signs))

    @cached_property
    def _symbols(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        sizes = {"x": 2 * self.dynamics.size, "d": len(self.dynamics.data)}
        return ca.SX.sym("t"), ca.SX.sym("x", sizes["x"]), ca.SX.sym("d", sizes["d"])


class SensitiveMotion:
    """A motion at values d (v,): states (2k,) and their derivatives (2k, p) in moved values, at
    times (n,) [s]; integrated unless its steps are recorded.

    Raises ComputationError as `Dynamics.integrate`, and where the model of the derivatives is not
    that of the motion.
    """

    def __init__(
        self,
        motions: Motions,
        d: Array,
        moved: tuple[int, ...],
        recorded: Sequence[MotionStep] = (),
    ) -> None:
        self.motions, self.d, self.moved = motions, d, list(moved)
        self.dynamics = motions.dynamics.with_data(d)
        self.steps = list(recorded)
        if not recorded:
            with threadpool_limits(1, "blas"):
                start = self.dynamics.find_start()
                times = np.array([0.0, motions.span])
                self.dynamics.integrate(times, TOLERANCE, start, steps=self.steps)
        self.starts = np.array([step.start for step in self.steps])
        self.lengths = np.array([step.end - step.start for step in self.steps])
        changes = [bool(step.crossed) for step in self.steps]
        self.arcs = np.concatenate([[0], np.cumsum(changes[:-1])]).astype(np.int64)

    @cached_property
    def spans(self) -> list[tuple[float, float]]:
        """First and last times [s] of the arcs between events, without what is undecided there."""
        margin, spans = MARGIN * self.motions.span, []
        for arc in range(1 + self.arcs[-1]):
            steps = np.flatnonzero(self.arcs == arc)
            start, last = self.starts[steps[0]], self.steps[steps[-1]]
            end = min([passage.time - margin for passage in last.crossed], default=last.end)
            spans.append((start + (margin if arc else 0.0), end))
        return spans

    def place(self, times: Array, arcs: Integers | None = None) -> Integers:
        """Return the steps (n,) in which times lie, those of given arcs between events if any are
        given.
        """
        steps = np.clip(
            np.searchsorted(self.starts, times, side="right") - 1, 0, len(self.steps) - 1
        )
        if arcs is None:
            return steps
        first = np.searchsorted(self.arcs, arcs, side="left")
        last = np.searchsorted(self.arcs, arcs, side="right") - 1
        return np.clip(steps, np.minimum(first, len(self.steps) - 1), np.maximum(last, 0))

    @cached_property
    def signs(self) -> Array:
        """Signs (f, s) of the normal forces that friction follows from, of each step."""
        if not len(self.motions.model.start_signs):
            return np.empty((0, len(self.steps)))
        middles = self.starts + self.lengths / 2
        states = self.states(middles, np.arange(len(self.steps)))
        pairs = zip(middles, states.T, strict=True)
        forces = [self.dynamics.find_normal_forces(time, state) for time, state in pairs]
        return np.copysign(1.0, np.array(forces).T)

    def states(self, times: Array, steps: Integers) -> Array:
        """Return states (2k, n) at times in given steps."""
        states = np.empty((2 * self.dynamics.size, len(times)))
        for index in np.unique(steps):
            chosen = steps == index
            states[:, chosen] = self.steps[index].states(times[chosen])
        return states

    def slopes(self, times: Array, steps: Integers) -> Array:
        """Return the derivatives (n, 2k, p) of the states in the moved values."""
        begun, stages = self._collocated
        lengths = self.lengths[steps]
        weights = integrate_basis((times - self.starts[steps]) / lengths) * lengths[:, None]
        return begun[steps] + np.einsum("ns,nskp->nkp", weights, stages[steps])

    @cached_property
    def _collocated(self) -> tuple[Array, Array]:
        """Derivatives at the beginnings of steps (s, 2k, p), and their rates at the nodes of each
        (s, STAGES, 2k, p).
        """
        size, count = 2 * self.dynamics.size, len(self.steps)
        times = (self.starts[:, None] + self.lengths[:, None] * NODES).ravel()
        states = self.states(times, np.repeat(np.arange(count), STAGES))
        signs = np.repeat(self.signs, STAGES, axis=1)
        parts = self.motions.slopes_kernel(t=times, x=states, signs=signs, d=self.d)
        a = parts["a"].T.reshape(count, STAGES, size, size).transpose(0, 1, 3, 2)
        by_values = parts["f"].T.reshape(count, STAGES, len(self.d), size)
        f = by_values[:, :, self.moved].transpose(0, 1, 3, 2)
        self._check(times[::STAGES], states[:, ::STAGES], parts["x_dot"][:, ::STAGES])
        begun, stages = [], []
        slopes = self._find_start_slopes()
        for step, a_nodes, f_nodes, length in zip(self.steps, a, f, self.lengths, strict=True):
            begun.append(slopes)
            system = np.eye(STAGES * size)
            blocks = length * INTEGRALS[:, :, None, None] * a_nodes
            system -= blocks.transpose(0, 2, 1, 3).reshape(STAGES * size, STAGES * size)
            inside = np.tile(slopes, (STAGES, 1, 1)) + length * np.einsum(
                "ij,jkp->ikp", INTEGRALS, f_nodes
            )
            solved = np.linalg.solve(system, inside.reshape(STAGES * size, -1))
            rates = a_nodes @ solved.reshape(STAGES, size, -1) + f_nodes
            stages.append(rates)
            slopes = slopes + length * np.einsum("j,jkp->kp", WEIGHTS, rates)
            slopes = self._jump(step, slopes)
            slopes = self._project(step, slopes)
        return np.array(begun), np.array(stages)

    def _check(self, times: Array, states: Array, rates: Array) -> None:
        """Raise ComputationError where rates (2k, n) of the model are not those of the motion."""
        size = self.dynamics.size
        for time, state, modelled in zip(times, states.T, rates[size:].T, strict=True):
            moved = self.dynamics.accelerations(time, state)[0]
            if np.abs(moved - modelled).max() > AGREEMENT * (1.0 + np.abs(moved).max()):
                raise ComputationError(
                    f"{self.dynamics.file.name}: at {time:.6g} s the constraints change their rank, "
                    f"or normal forces of friction their signs twice at once: there is no derivative"
                )

    def _find_start_slopes(self) -> Array:
        """Return the derivatives (2k, p) of the start."""
        dynamics = self.dynamics
        if not dynamics.constraints and "start_gaps" not in dynamics.formulas.sidecar["functions"]:
            slopes: Array = np.array(self.motions.start_slopes(self.d))[:, self.moved]
            return slopes
        columns = []
        for index in self.moved:
            step = START_STEP * (abs(self.d[index]) or 1.0)

            def move(share: float, index: int = index, step: float = step) -> Array:
                d = self.d.copy()
                d[index] += share * step
                return self.motions.dynamics.with_data(d).find_start()

            single, double = (move(share) - move(-share) for share in (1.0, 2.0))
            columns.append((8 * single - double) / (12 * step))
        return np.array(columns).reshape(len(columns), -1).T

    def _jump(self, step: MotionStep, slopes: Array) -> Array:
        """Return the derivatives (2k, p) after the events at the end of a step."""
        dynamics, names = self.dynamics, self.dynamics.event_names
        for passage in step.crossed:
            if passage.event not in names:  # a sign of a normal force: rates do not jump
                continue
            is_impact = passage.event in dynamics.impacts
            margin = 4 * abs(step.end - passage.time) + 1e-12 * self.motions.span
            times = passage.time + np.array([-margin, 0.0 if is_impact else margin])
            before, after = step.states(times).T
            reset = np.eye(len(before), 1 + len(before) + len(self.d), 1)
            if is_impact:
                after, reset = self._reset(passage, after)
            rates = [
                np.concatenate([state[dynamics.size :], dynamics.accelerations(time, state)[0]])
                for time, state in zip(times, (before, after), strict=True)
            ]
            by_all = np.array(self.motions.events_slopes(passage.time, before, self.d))
            row = by_all[names.index(passage.event)]
            by_time, by_state, by_values = self._split(row)
            rise = by_time + by_state @ rates[0]
            size = self._event_sizes[names.index(passage.event)]
            if abs(rise) * self.motions.span <= TANGENT * size:
                raise ComputationError(
                    f"{dynamics.file.name}: {passage.event} is only touched at {passage.time:.6g} s: "
                    f"there is no derivative"
                )
            moved = -(by_state @ slopes + by_values) / rise
            by_time, by_state, by_values = self._split(reset)
            change = by_state @ rates[0] + by_time - rates[1]
            slopes = by_state @ slopes + by_values + np.outer(change, moved)
        return slopes

    @cached_property
    def _event_sizes(self) -> Array:
        """Largest sizes (e,) of the events' values at the beginnings of steps."""
        states = self.states(self.starts, np.arange(len(self.steps)))
        data = self.dynamics.data_at(self.starts)
        values = self.dynamics.formulas("events", time=self.starts, data=data, state=states)
        return np.abs(list(values.values())).max(axis=1)

    def _split(self, slopes: Array) -> tuple[Array, Array, Array]:
        """Return the parts by time, by state and by moved values of slopes (..., 1 + 2k + v)."""
        count = 2 * self.dynamics.size
        by_values = slopes[..., 1 + count :][..., self.moved]
        return slopes[..., 0], slopes[..., 1 : 1 + count], by_values

    def _reset(self, passage: Passage, state: Array) -> tuple[Array, Array]:
        """Return the state (2k,) after an impact, and its derivatives (2k, 1 + 2k + v) by time,
        state before it, and values, by the implicit function theorem on the balance of impulses.
        """
        size, reset = len(state) // 2, np.eye(len(state), 1 + len(state) + len(self.d), 1)
        jump, impulses = self.dynamics.find_impulses(passage.time, state, passage.event)
        arguments = passage.time, state, self.d, jump, impulses
        by_unknowns, by_all = map(np.array, self.motions.impulse_slopes(*arguments))
        chosen = np.concatenate([np.arange(size), size + np.flatnonzero(impulses)])
        solved = np.linalg.solve(by_unknowns[np.ix_(chosen, chosen)], by_all[chosen])
        reset[size:] -= solved[:size]
        return np.concatenate([state[:size], state[size:] + jump]), reset

    def _project(self, step: MotionStep, slopes: Array) -> Array:
        """Return the derivatives (2k, p) on the constraints at the end of a step."""
        if not self.dynamics.constraints:
            return slopes
        state = step.states(np.array([step.end]))[:, 0]
        by_all = np.array(self.motions.constraint_slopes(step.end, state, self.d))
        by_state, by_values = by_all[:, : len(state)], by_all[:, len(state) :][:, self.moved]
        off = by_state @ slopes + by_values
        return np.asarray(slopes - np.linalg.lstsq(by_state, off, rcond=None)[0])


def _build_basis() -> tuple[Array, Array, Array]:
    """Return nodes (s,) and weights (s,) of Gauss-Legendre in [0, 1], and the coefficients (s, s) of
    the Lagrange polynomials by powers.
    """
    nodes, weights = np.polynomial.legendre.leggauss(STAGES)
    nodes = (nodes + 1) / 2
    powers = np.asarray(np.linalg.inv(np.vander(nodes, increasing=True)), dtype=np.float64)
    return nodes, weights / 2, powers


NODES, WEIGHTS, _POWERS = _build_basis()


def integrate_basis(shares: Array) -> Array:
    """Return the integrals (n, s) of the Lagrange polynomials of the nodes from 0 to shares (n,)."""
    orders = np.arange(1, STAGES + 1)
    integrals: Array = (shares[:, None] ** orders / orders) @ _POWERS
    return integrals


INTEGRALS = integrate_basis(NODES)


class _Sampled(NamedTuple):
    """States (2k, n) of a motion at times (n,) [s] in its steps (n,)."""

    motion: SensitiveMotion
    times: Array
    steps: Integers
    states: Array


class MotionResponse(MachineResponse):
    """Quantities of a machine that moves freely, at angles phi (n,) of which a turn is its span of
    time.
    """

    @cached_property
    def motions(self) -> Motions:
        """The motions, which all responses of a machine share."""
        assert self.machine.motion is not None
        motions: Motions = self.machine.motion.motions
        return motions

    @property
    def _pace(self) -> float:
        """Time [s] for each radian."""
        return self.motions.span / self.machine.turn

    def values(self, point: DesignPoint, phi: Array) -> Array:
        """Return the quantities (m, n). Raises ComputationError as the motion does."""
        return self._evaluate_at(self.values_kernel, point, phi)[0]["rows"]

    def slopes(self, point: DesignPoint, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the quantities (m, n) and their Jacobian (m, n, 1 + p) in (phi, x)."""
        return self._slopes(point, phi, is_loose=is_loose)

    def derivatives(
        self, point: DesignPoint, phi: Array, is_loose: bool = False
    ) -> tuple[Array, Array]:
        """Return the quantities and their derivatives in phi, (m, n) each."""
        rows, first, _, _, _ = self._differentiate(point, phi, is_loose)
        return rows, first

    def rates(self, point: DesignPoint, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        """Return the first two derivatives of the quantities in phi, (m, n) each."""
        step = DIFFERENCE
        phi = np.clip(phi, step, self.machine.turn - step)
        first = self.derivatives(point, phi, is_loose)[1]
        before, after = (self.derivatives(point, phi + s, is_loose)[1] for s in (-step, step))
        return first, (after - before) / (2 * step)

    def curvatures(self, point: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the sum over quantities of weights (m, n) times Hessians in (phi, x), (n, 1 + p, 1
        + p), by differences of exact slopes.
        """
        machine, size = self.machine, 1 + len(self.machine.moved)
        base = self._slopes(point, phi)[1]
        arcs = self._arcs(point, phi)
        hessians = np.zeros((len(phi), size, size))
        inner = np.clip(phi, DIFFERENCE, machine.turn - DIFFERENCE)
        before, after = (self._slopes(point, inner + s, arcs)[1] for s in (-DIFFERENCE, DIFFERENCE))
        hessians[:, 0] = np.einsum("mn,mnp->np", weights, after - before) / (2 * DIFFERENCE)
        widths = np.nan_to_num(machine.upper - machine.lower, nan=0.0)
        for column, index in enumerate(machine.moved):
            step = DIFFERENCE * (widths[column] or abs(point.d[index]) or 1.0)
            d = point.d.copy()
            d[index] += step
            change = self._slopes(self.at_data(d), phi, arcs)[1] - base
            hessians[:, 1 + column] = np.einsum("mn,mnp->np", weights, change) / step
        hessians[:, 1:, 0] = hessians[:, 0, 1:]
        symmetric: Array = (hessians + hessians.transpose(0, 2, 1)) / 2
        return symmetric

    def curvature(self, point: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the sum of these over the angles, (1 + p, 1 + p)."""
        return np.asarray(self.curvatures(point, phi, weights).sum(axis=0))

    def curvature_along(
        self, point: DesignPoint, phi: Array, weights: Array, angle_slopes: Array
    ) -> Array:
        """Return that sum in the design alone, (p, p), of angles with slopes (n, p)."""
        hessians = self.curvatures(point, phi, weights)
        return add_moving_angles(hessians[:, 1:, 1:].sum(axis=0), hessians, angle_slopes)

    def list_pieces(self, point: DesignPoint, first: float, last: float) -> list[Array]:
        """Return the samples (n,) of each arc between events, from the first to the last angle."""
        motion = self.motions.find(point.d, self.machine.moved)
        ends = np.array([first, last]) * self._pace
        shares = np.linspace(0.0, 1.0, EVENT_SAMPLES, endpoint=False)
        times = motion.starts[:, None] + motion.lengths[:, None] * shares
        pieces = []
        for arc, (start, end) in enumerate(motion.spans):
            low, high = max(start, ends[0]), min(end, ends[1])
            inner = times[motion.arcs == arc].ravel()
            inner = inner[(inner > low) & (inner < high)]
            if low < high:
                pieces.append(np.concatenate([[low], inner, [high]]) / self._pace)
        return pieces

    def list_passages(self, point: DesignPoint) -> list[tuple[str, float]]:
        """Return the names of events with their angles, which lie in the arcs before them."""
        motion = self.motions.find(point.d, self.machine.moved)
        margin = MARGIN * self.motions.span
        return [
            (passage.event, (passage.time - margin) / self._pace)
            for step in motion.steps
            for passage in step.crossed
            if passage.event in motion.dynamics.event_names
        ]

    def compile(self) -> None:
        """Compile the values and their slopes."""
        for kernel in (self.values_kernel, self.state_slopes_kernel, self.motions.slopes_kernel):
            kernel.compile()

    def _arcs(self, point: DesignPoint, phi: Array) -> Integers:
        motion = self.motions.find(point.d, self.machine.moved)
        return motion.arcs[motion.place(self._times(phi))]

    def _times(self, phi: Array) -> Array:
        return np.clip(np.asarray(phi, dtype=float) * self._pace, 0.0, self.motions.span)

    def _slopes(
        self, point: DesignPoint, phi: Array, arcs: Integers | None = None, is_loose: bool = False
    ) -> tuple[Array, Array]:
        rows, first, by_state, by_design, at = self._differentiate(point, phi, is_loose, arcs)
        state_slopes = at.motion.slopes(at.times, at.steps)
        design_slopes = by_design + np.einsum("mkn,nkp->mpn", by_state, state_slopes)
        return rows, np.concatenate([first[:, :, None], design_slopes.transpose(0, 2, 1)], axis=2)

    def _differentiate(
        self, point: DesignPoint, phi: Array, is_loose: bool, arcs: Integers | None = None
    ) -> tuple[Array, Array, Array, Array, _Sampled]:
        """Return the quantities (m, n), their derivatives in phi (m, n), their partial derivatives
        by states (m, 2k, n) and moved values (m, p, n), and where that is.
        """
        result, at = self._evaluate_at(self.state_slopes_kernel, point, phi, is_loose, arcs)
        states, symbols = len(at.states), self.machine.states
        shape = len(self.quantities), 1 + symbols + len(self.machine.moved), len(at.times)
        slopes = result["slopes"].reshape(shape)
        by_phi, by_state, _, by_design = np.split(slopes, [1, 1 + states, 1 + symbols], axis=1)
        signs = at.motion.signs[:, at.steps]
        now = self.motions.rates_kernel(t=at.times, x=at.states, signs=signs, d=point.d)
        rates = now["x_dot"]
        first = by_phi[:, 0] + np.einsum("mkn,kn->mn", by_state, rates * self._pace)
        return result["rows"], first, by_state, by_design, at

    def _evaluate_at(
        self,
        kernel: Kernel,
        point: DesignPoint,
        phi: Array,
        is_loose: bool = False,
        arcs: Integers | None = None,
    ) -> tuple[dict[str, Array], _Sampled]:
        motion = self.motions.find(point.d, self.machine.moved)
        times = self._times(phi)
        steps = motion.place(times, arcs)
        call: Callable[..., Any] = (
            (lambda **inputs: kernel.masked(**inputs)[0]) if is_loose else kernel
        )
        states = motion.states(times, steps)
        q = np.vstack([states, motion.signs[:, steps]])
        result = call(phi=times / self._pace, d=point.d, h=point.h, q=q)
        return result, _Sampled(motion, times, steps, states)

    @cached_property
    def values_kernel(self) -> Kernel:
        """(phi, d, h, q) -> rows (m,)."""
        return Kernel(self.values_function, ["phi", "q"])

    @cached_property
    def state_slopes_kernel(self) -> Kernel:
        """(phi, d, h, q) -> rows (m,) and their slopes (m (1 + 2k + p),) by phi, q and moved values,
        quantity by quantity.
        """
        phi, d, h, q = self.machine.symbols
        jacobian = ca.jacobian(self._graph, ca.vertcat(phi, q, d))
        first = 1 + q.numel()
        columns = [*range(first), *(first + index for index in self.machine.moved)]
        slopes = ca.densify(ca.vec(jacobian[:, columns].T))
        function = ca.Function(
            "state_slopes",
            [phi, d, h, q],
            ca.cse([self._graph, slopes]),
            ["phi", "d", "h", "q"],
            ["rows", "slopes"],
        )
        return Kernel(function, ["phi", "q"])
