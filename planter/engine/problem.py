"""Problems over the design of a machine: a sum of measures under limits, within its bounds.

A weighted range and variance, or standard deviation, of one quantity over the cycle is searched by its true extremes
and integrals, or over samples with its kinks taken exactly. Any other sum is the smooth programme of `goal`.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Self

import numpy as np

from planter.engine.goal import CYCLE, Goal, GoalConstraints
from planter.engine.loops import TURN
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.response import DesignPoint, MachineResponse
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.constraints import Constraints, DesignBox, join_constraints
from planter.optimise.continuous_cycle import ContinuousCycle
from planter.optimise.expressions import SmoothObjective
from planter.optimise.problem import Problem
from planter.optimise.range_variance import RangeVarianceObjective, Sampling, find_insensitive
from planter.optimise.response import BreakpointEvent, CompiledResponse
from planter.optimise.variance import Weights

REACH = 1e3
"""Variables for extremes lie within so many spreads of where they start."""
PASSED = 1e-9
"""Share of a quantity's spread by which a true extreme may pass the nodes."""
CLOSED = 1e-6
"""Share of its range by which a quantity may differ after a turn: loops are closed to less."""


class DesignConstraints(Constraints):
    """Constraints on the design, which is the first `size` of a point's coordinates, as constraints on the point."""

    def __init__(self, constraints: Constraints, size: int) -> None:
        self.constraints, self.size = constraints, size
        self.kinds, self.owner = constraints.kinds, constraints.owner
        self.lower, self.upper = constraints.lower, constraints.upper

    def values(self, x: Array) -> Array:
        """Return the rows (k,) at a point (p,). Raises ComputationError without a cycle."""
        return self.constraints.values(x[: self.size])

    def slopes(self, x: Array) -> Array:
        """Return their gradients (k, p)."""
        return np.pad(self.constraints.slopes(x[: self.size]), ((0, 0), (0, len(x) - self.size)))

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (k,)."""
        return np.pad(self.constraints.curvature(x[: self.size], weights), (0, len(x) - self.size))


class DesignProblem(Problem, ABC):
    """A problem over the design of a machine under the limits of a goal, and perhaps over further variables.

    `sampling` says whether extremes are the true ones ("refined") or those of samples, `further` are additional
    constraints on the design. A point u (p,) stands for the machine's design x and the variables.
    """

    goal: Goal
    sampling: Sampling
    further: Sequence[Constraints]

    @property
    def machine(self) -> Machine:
        """The machine whose design is searched for."""
        return self.goal.machine

    def find_point(self, x: Array) -> Array:
        """Return the point of a machine's design. Raises ComputationError if its loops do not close."""
        return self.box.point(x)

    def find_design(self, u: Array) -> Array:
        """Return the machine's design at a point."""
        return self.design(u)[: self.goal.size]

    def count_samples(self, x: Array) -> int:
        """Return how many angles of the cycle stand for all of it at a machine's design."""
        return len(self.goal.nodes[CYCLE](x).weights) if CYCLE in self.goal.nodes else self.machine.samples

    def refine(self, u: Array) -> Self | None:
        """Return the problem with nodes where a quantity passes all nodes at a point; None if none does."""
        goal = self.goal.refine(self.find_design(u), PASSED) if self.sampling == "refined" else None
        return None if goal is None else self._with_goal(goal)

    @abstractmethod
    def _with_goal(self, goal: Goal) -> Self: ...


class GoalProblem(DesignProblem):
    """A goal as a problem: searched in shares of the bounds, and in spreads of the measures from where they start.

    Starts and individuals choose the design; the variables of its extremes are as tight as they can be.
    """

    most_iterations = 300

    def __init__(self, goal: Goal, sampling: Sampling, further: Sequence[Constraints] = ()) -> None:
        self.goal, self.sampling, self.further, machine = goal, sampling, further, goal.machine
        start = goal.start(machine.design)
        variables = start[goal.size :]
        names = (*machine.design_names, *(f"{'most' if side > 0 else 'least'} {m}" for m, side in goal.variables))
        box = DesignBox(
            names,
            np.concatenate([machine.lower, variables - REACH * goal.unit]),
            np.concatenate([machine.upper, variables + REACH * goal.unit]),
            start,
            np.concatenate([machine.lower, variables]),
            np.concatenate([machine.upper - machine.lower, goal.unit]),
        )
        constraints = [DesignConstraints(part, goal.size) for part in further]
        limits = [GoalConstraints(goal)] if goal.variables or goal.limits else []
        scale = max(abs(goal.value(start)), float(goal.unit.sum()), np.finfo(float).tiny)
        super().__init__(SmoothObjective(goal, len(start), scale), box, join_constraints([*limits, *constraints]))
        _ = self.reference  # before any design of a search, on which its last digits would depend

    def restart(self) -> None:
        """Forget all designs so far."""
        self.goal.restart()

    @property
    def independent(self) -> Integers:
        return np.arange(self.goal.size)

    def complete(self, u: Array) -> Array:
        """Return a point with tight variables; without a cycle they mean nothing, and stay as they are."""
        try:
            return self.find_point(self.find_design(u))
        except ComputationError:
            return u

    def find_point(self, x: Array) -> Array:
        """Return the point of a machine's design with tight variables. Raises ComputationError without a cycle."""
        return self.box.point(self.goal.start(x))

    def flat(self, u: Array) -> Array:
        """Return orthonormal directions (k, p) in which no quantity of the sum or limits changes, to first order."""
        x, width = self.find_design(u), self.machine.upper - self.machine.lower
        columns = np.vstack([nodes(x).slopes.reshape(-1, len(x)) * width for nodes in self.goal.nodes.values()])
        directions = find_insensitive(self.machine.design_names, columns).space
        return np.pad(directions, ((0, 0), (0, len(u) - len(x))))

    def _with_goal(self, goal: Goal) -> GoalProblem:
        return GoalProblem(goal, self.sampling, self.further)


class CurveProblem(DesignProblem):
    """Range and spread of a curve of a machine, searched in shares of its bounds.

    The limits of the goal and further constraints (k,) on the design are satisfied.
    """

    objective: RangeVarianceObjective

    def __init__(
        self, curve: QuantityCurve, weights: Weights, sampling: Sampling, goal: Goal | None = None,
        further: Sequence[Constraints] = (),
    ) -> None:  # fmt: skip
        """Without a goal the further constraints are all there are."""
        self.goal = Goal(curve.machine, (), ()) if goal is None else goal
        self.sampling, self.curve, self.weights, self.further = sampling, curve, weights, further
        limits = [GoalConstraints(self.goal)] if self.goal.limits else []
        box = DesignBox.shares(curve.names, curve.lower, curve.upper, curve.design)
        super().__init__(RangeVarianceObjective(curve, weights, sampling), box, join_constraints([*limits, *further]))
        if curve.machine.loops is not None:
            self.restart()
            _ = self.reference, self.free  # before any design of a search, on which their last digits would depend

    def restart(self) -> None:
        """Forget all designs so far, on which only closed loops depend."""
        if self.machine.loops is not None:
            self.curve.restart()
            self.objective.restart()
            self.goal.restart()

    def count_samples(self, x: Array) -> int:
        """Return the number of samples, or of nodes of the true integrals at a machine's design."""
        turn = self.objective.turn
        return len(turn.panels(x).nodes) if isinstance(turn, ContinuousCycle) else len(turn.angles)

    def _with_goal(self, goal: Goal) -> CurveProblem:
        return CurveProblem(self.curve, self.weights, self.sampling, goal, self.further)


def build_problem(
    machine: Machine, terms: Sequence[Measure], limits: Sequence[Limit], sampling: Sampling
) -> DesignProblem:  # fmt: skip
    """Return the problem of a sum of measures under limits, which are as `goal.resolve_measure` gives them.

    The requirements of the machine's file are satisfied, too. Raises InputError for a machine without bounds.
    """
    if not machine.moved:
        raise InputError(f"{machine.source}: it has no [bounds], so there is nothing to search in")
    further = [] if machine.requirements is None else [machine.requirements()]

    def build_goal(measures: Sequence[Measure]) -> Goal:
        count = None if sampling == "refined" else sampling
        return Goal(machine, measures, limits, count, with_events=count is None)

    curve = find_curve(machine, terms)
    if curve is not None and not (goal := build_goal(())).variables:
        return CurveProblem(curve, find_weights(curve, terms), sampling, goal, further)
    return GoalProblem(build_goal(terms), sampling, further)


def find_curve(machine: Machine, terms: Sequence[Measure]) -> QuantityCurve | None:
    """Return the quantity whose weighted range and spread over a turn a sum is; None if it is another sum.

    None, too, for a quantity that may jump, that differs at the end of a turn, which gives no closed curve, or that has
    no derivative at an angle, as a norm where it vanishes.
    """
    kinds, names = [measure.kind for measure in terms], {measure.name for measure in terms}
    spreads = sum(kind in ("variance", "std") for kind in kinds)
    is_weighted = kinds.count("range") <= 1 and spreads <= 1 and len(kinds) == kinds.count("range") + spreads
    is_plain = all(not (m.size or m.where or m.during) and m.weight >= 0 for m in terms)
    if not (is_weighted and is_plain and len(names) == 1) or machine.turn != TURN:
        return None
    curve = QuantityCurve(machine, names.pop())
    if any(event.order == 0 for event in curve.events):
        return None
    angles = np.linspace(0.0, TURN, 1 + machine.samples)
    (values,), slopes = curve.response.derivatives(curve.prologue(machine.design), angles, masked=True)
    is_closed = abs(values[-1] - values[0]) <= CLOSED * np.ptp(values)
    return curve if is_closed and np.isfinite(slopes).all() else None


def find_weights(curve: QuantityCurve, terms: Sequence[Measure]) -> Weights:
    """Return the weights of range and spread of a curve in SI, of a sum in the unit of the quantity's key."""
    factor = curve.quantity.factor
    weights = {measure.kind: measure.weight for measure in terms}
    if "std" in weights:
        return Weights(weights.get("range", 0.0) / factor, weights["std"] / factor, "newton")
    return Weights(weights.get("range", 0.0) / factor, weights.get("variance", 0.0) / factor**2, "paper")


class QuantityCurve:
    """A quantity F(phi, x) of a machine, in SI, with the machine's events as joints: an `optimise.response.Response`.

    The order of a joint is that of the machine's forces: a quantity may be smoother there. The curve of a side has
    joints of the first side alone, and repeats after a turn.
    """

    def __init__(self, machine: Machine, name: str) -> None:
        """Raises InputError if the machine has no quantity of that name."""
        self.machine, self.quantity = machine, machine.find_quantity(name)
        self.response, self.is_compiled = MachineResponse(machine, [name]), False
        self.events = tuple(
            BreakpointEvent(str(kind["name"]), int(kind["order"]), kind["period"]) for kind in machine.event_kinds
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the design x."""
        return self.machine.design_names

    @property
    def lower(self) -> Array:
        """Lower bounds (p,)."""
        return self.machine.lower

    @property
    def upper(self) -> Array:
        """Upper bounds (p,)."""
        return self.machine.upper

    @property
    def design(self) -> Array:
        """The machine's own design (p,)."""
        return self.machine.design

    @property
    def period(self) -> float:
        """The angle after which the curve repeats [rad]."""
        return self.machine.period if self.quantity.total else TURN

    @property
    def offsets(self) -> tuple[float, ...]:
        """Angles [rad] of the lanes that add up to the curve."""
        return self.response.offsets

    def with_machine(self, machine: Machine) -> QuantityCurve:
        """Return the curve of a machine that differs from this one's in numbers alone: all functions are shared."""
        curve = copy.copy(self)
        curve.machine = machine
        return curve

    def prologue(self, x: Array) -> DesignPoint:
        """Return the point of a design x (p,), for all angles."""
        return self.response.at_data(self.machine.build_data(x))

    def restart(self) -> None:
        """Forget all designs so far, as `Response.restart`."""
        self.response.restart()
        self._joints.restart()

    def value(self, at: DesignPoint, phi: Array) -> Array:
        """Return F, (n,). Raises ComputationError if loops do not close or a value is not finite, as all do."""
        return self.response.values(at, phi)[0]

    def rate(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return F and its derivative in phi, (n,) each."""
        values, first = self.response.derivatives(at, phi)
        return values[0], first[0]

    def rates(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of F in phi, (n,) each."""
        first, second = self.response.rates(at, phi)
        return first[0], second[0]

    def slopes(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return F, (n,), and its Jacobian in (phi, x), (n, 1 + p)."""
        values, slopes = self.response.slopes(at, phi)
        return values[0], slopes[0]

    def hessian(self, at: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the weighted sum over the angles of the Hessian of F in (phi, x), (1 + p, 1 + p)."""
        return self.response.curvature(at, phi, weights[None])

    def hessians(self, at: DesignPoint, phi: Array) -> Array:
        """Return the Hessian of F in (phi, x) at each angle, (n, 1 + p, 1 + p)."""
        return self.response.curvatures(at, phi, np.ones((1, len(phi))))

    @cached_property
    def _joints(self) -> MachineResponse:
        joints = MachineResponse(self.machine, (), with_events=True)
        joints.is_compiled = self.is_compiled
        return joints

    def event_values(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return g of every event and its derivative in phi, (k, n) each."""
        return self._joints.derivatives(at, phi)

    def event_slopes(self, at: DesignPoint, phi: Array) -> Array:
        """Return the Jacobian of g in (phi, x), (k, n, 1 + p)."""
        return self._joints.slopes(at, phi)[1]

    def event_hessian(self, at: DesignPoint, phi: float, event: int) -> Array:
        """Return the Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""
        weights = np.eye(len(self.events))[:, event : event + 1]
        return self._joints.curvature(at, np.array([phi]), weights)

    def compile(self, refined: bool = False) -> None:
        """Compile what a search calls again and again, over samples or, `refined`, over true extremes and integrals.

        The Hessian takes longest: it is compiled in the background, and not for the few times that a search over true
        extremes needs it. What joints need is compiled at its first use.
        """
        response = self.response
        if not refined:
            response.hessian_kernel.compile(wait=False)
            response.prologue_hessian_kernel.compile()
        response.compile()
        if refined:
            response.derivatives_kernel.compile()
            response.rates_kernel.compile()
        self.is_compiled = True
        vars(self).pop("_joints", None)

    def compiled(self, angles: int) -> CompiledResponse | None:
        """Return prologue and lanes in machine code; None if one is not compiled, or if loops must be closed."""
        response = self.response
        if self.machine.loops is not None:
            return None
        response.hessian_kernel.settle()
        prologue, curvature = response.prologue_kernel.compiled, response.prologue_hessian_kernel.compiled
        kernels = (response.values_kernel, response.slopes_kernel, response.hessian_kernel)
        value, slopes, bending = (kernel.interface(angles * len(self.offsets)) for kernel in kernels)
        if prologue is None or curvature is None or value is None or slopes is None or bending is None:
            return None
        machine = self.machine
        return CompiledResponse(machine.data, machine.moved, self.offsets, prologue, curvature, value, slopes, bending)
