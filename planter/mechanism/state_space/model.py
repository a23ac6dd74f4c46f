"""One model of a mechanism that moves freely: x' = f(t, x, u, p) and y = g(t, x, u, p).

With inertia M, forces h, slopes J and bends b of the constraints and their multipliers l

    M a = h + J^T l,    J a = b,

solved by M = L D L^T and by the same for J M^-1 J^T. Derivatives follow from the implicit function
theorem on these equations, with the same factors: no factorisation is differentiated. Constraints
that follow from others are left out; which these are is decided once, at the start. `pivot` says how
far a state is from where that choice fails: drivers have to watch it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.kernels.elimination import ConstrainedFactor, solve_system
from planter.kernels.kernel import VectorFunction
from planter.mechanism import file as mechanism_file
from planter.mechanism.dynamics import Dynamics, Reactions, find_independent_rows
from planter.mechanism.motion_equations import MotionEquations

ARGUMENTS = ["t", "x", "u", "p"]
PIVOT = "pivot"
"""Name of the output that tells how far constraints are from depending on each other, and friction
from leaving the motion undetermined; `pivot_` where the statement has this name.
"""
PIVOT_SHARE = 1e-4
"""Share of the pivot at the start below which exports warn: some four digits are lost there, and
the motion may leave the branch that it is on.
"""


@dataclass(frozen=True)
class DynamicsVariable:
    """A state, input, output or parameter; `unit` of SI or rad, `value` at the start.

    `low` and `high` are the bounds that the statement gives an input, infinite without any.
    """

    name: str
    unit: str
    meaning: str
    value: float
    low: float = -np.inf
    high: float = np.inf


def load_dynamics(
    file: str | Path, inputs: Sequence[str] = (), stabilise: float = 0.0
) -> DynamicsModel:
    """Return the model of a file of a mechanism that moves freely, in SI units and radians.

    `inputs` are names of values of the file that are inputs beside those of the statement;
    `stabilise` [1/s] is as for `DynamicsModel`. Raises InputError if the file cannot be read, if an angle
    drives the mechanism, or for an unknown name.
    """
    return DynamicsModel(Dynamics(mechanism_file.load(str(file))), inputs, stabilise)


class DynamicsModel:
    """Functions of time [s], state (2k,), inputs (m,) and parameters (q,); SI units and radians.

    A state holds coordinates, then their rates. `rates` returns x' (2k,), `linearised` its
    derivatives A, B and F by state, inputs and parameters, `outputs` y (r,), and
    `linearised_outputs` its derivatives C, D and G. `f`, `f_jacobian`, `y`, `y_jacobian` and
    `curvature` are the same as CasADi functions, whose matrices are sparse.

    With a rate `stabilise` [1/s] gaps g and slips s decay where a state does not meet them, as in
    g'' + 2 c g' + c^2 g = 0 and s' + c s = 0 (Baumgarte, Computer Methods in Applied Mechanics and
    Engineering 1, 1972): for integrators that do not project on the constraints.

    Signs of normal forces that friction follows from are those of the start: where the output
    `size_NAME` of such a force falls below zero, another model holds. With `open_signs` the
    functions have these `signs` (f,) as their last argument.
    """

    def __init__(
        self,
        dynamics: Dynamics,
        inputs: Sequence[str] = (),
        stabilise: float = 0.0,
        open_signs: bool = False,
    ) -> None:
        self.dynamics, self.name, self.stabilise = dynamics, dynamics.file.name, stabilise
        formulas = dynamics.formulas
        entries, sidecar = formulas.sidecar["vectors"]["data"], formulas.sidecar
        stated = {entry["name"]: entry for entry in sidecar.get("inputs", ())}
        chosen = {*stated, *(self._find_entry(name, entries) for name in inputs)}
        values = dict(zip((entry["name"] for entry in entries), dynamics.data, strict=True))
        self.inputs = [
            _describe(entry, values[entry["name"]], stated.get(entry["name"], {}))
            for entry in entries
            if entry["name"] in chosen
        ]
        self.parameters = [
            _describe(entry, values[entry["name"]])
            for entry in entries
            if entry["name"] not in chosen
        ]
        self.start = dynamics.find_start()
        self.states = [
            _describe(entry, value)
            for entry, value in zip(sidecar["vectors"]["start_state"], self.start, strict=True)
        ]
        self.u = np.array([variable.value for variable in self.inputs])
        self.p = np.array([variable.value for variable in self.parameters])
        self._u, self._p = ca.SX.sym("u", len(self.inputs)), ca.SX.sym("p", len(self.parameters))
        names = [variable.name for variable in (*self.inputs, *self.parameters)]
        packed = dict(zip(names, ca.vertsplit(ca.vertcat(self._u, self._p)), strict=True))
        data = ca.vertcat(*(packed[entry["name"]] for entry in entries))
        self.equations = MotionEquations(formulas, data)
        self._choice = _Choice(dynamics, self.equations, self.start)
        self._calls: dict[str, VectorFunction] = {}
        pressing = [self.equations.actions.index(name) for name in self.equations.pressing]
        self.start_signs = self._choice.signs[pressing]
        self._signs = ca.SX.sym("signs", len(pressing)) if open_signs else ca.SX(self.start_signs)
        self._opened = [self._signs] if open_signs else []

    def _find_entry(self, name: str, entries: Sequence[dict[str, Any]]) -> str:
        for entry in entries:
            path = entry["shown"]
            if name in (entry["name"], path, path.rpartition(".")[2]):
                return str(entry["name"])
        names = ", ".join(entry["shown"].rpartition(".")[2] for entry in entries)
        raise InputError(
            f"{self.dynamics.file.source}: input {name}: no value has this name; values are {names}"
        )

    @property
    def constraints(self) -> list[str]:
        """Names of the constraints that are kept: gaps, then slips."""
        return [self.equations.constraints[row] for row in self._choice.rows]

    @property
    def left_out(self) -> list[str]:
        """Names of the constraints that follow from others at the start."""
        return [name for name in self.equations.constraints if name not in self.constraints]

    @cached_property
    def outputs(self) -> list[DynamicsVariable]:
        """Reports, reactions that the balances determine, energies, sizes of forces whose signs are
        those of the start, the pivot if it changes, and values of events.
        """
        vectors = self.equations.formulas.sidecar["vectors"]
        sizes = [
            entry | {"meaning": f"{entry['meaning']}, negative where its sign is not the start's"}
            for entry in vectors.get("sizes", ())
            if entry["name"].removeprefix("size_") not in self._choice.undetermined
        ]
        entries = [*vectors["outputs"], *sizes]
        determined = [entry for entry in entries if entry["name"] not in self._choice.undetermined]
        names = {variable.name for variable in (*self.states, *self.inputs, *self.parameters)}
        names |= {entry["name"] for entry in determined}
        if self.has_pivot:
            determined.append(_PIVOT_ENTRY | {"name": PIVOT + "_" * (PIVOT in names)})
        determined += vectors.get("events_outputs", ())
        values = self._call("y", 0.0, self.start, None, None)[0]
        return [
            _describe(entry, float(value))
            for entry, value in zip(determined, np.array(values)[:, 0], strict=True)
        ]

    @property
    def events(self) -> int:
        """Number of events, whose values are the last outputs: where one changes its sign, another
        law holds.
        """
        return len(self.equations.outputs("events"))

    # --- values ----------------------------------------------------------------------------------

    def rates(self, t: float, x: Array, u: Array | None = None, p: Array | None = None) -> Array:
        """Return x' (2k,) [SI]: rates, then accelerations."""
        return self._call("f", t, x, u, p)[0][:, 0]

    def pivot(self, t: float, x: Array, u: Array | None = None, p: Array | None = None) -> float:
        """Return the least pivot of the constraints over the largest: 1 without constraints, 0 where
        those that are kept depend on each other.
        """
        return float(self._call("f", t, x, u, p)[1][0, 0])

    def linearised(
        self, t: float, x: Array, u: Array | None = None, p: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return A (2k, 2k), B (2k, m) and F (2k, q): derivatives of x' by state, inputs,
        parameters.
        """
        a, b, f = self._call("f_jacobian", t, x, u, p)
        return a, b, f

    def outputs_at(
        self, t: float, x: Array, u: Array | None = None, p: Array | None = None
    ) -> Array:
        """Return y (r,) [SI], in the order of `outputs`."""
        return self._call("y", t, x, u, p)[0][:, 0]

    def linearised_outputs(
        self, t: float, x: Array, u: Array | None = None, p: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return C (r, 2k), D (r, m) and G (r, q): derivatives of y by state, inputs, parameters."""
        c, d, g = self._call("y_jacobian", t, x, u, p)
        return c, d, g

    def constraint_slopes(
        self, t: float, x: Array, u: Array | None = None, p: Array | None = None
    ) -> Array:
        """Return the derivatives (c, 2k) by state of gaps and speeds that the constraints keep zero."""
        return self._call("_constraint_jacobian", t, x, u, p)[0]

    def _call(
        self, function: str, t: float, x: Array, u: Array | None, p: Array | None
    ) -> list[Array]:
        if function not in self._calls:
            self._calls[function] = VectorFunction(getattr(self, function))
        signs = [self.start_signs] if self._opened else []
        values = self.u if u is None else u, self.p if p is None else p
        return self._calls[function](t, x, *values, *signs)

    @cached_property
    def least_pivot(self) -> float:
        """The pivot below which exports warn; 0 where there is none to watch."""
        return PIVOT_SHARE * self.pivot(0.0, self.start) if self.has_pivot else 0.0

    @property
    def has_pivot(self) -> bool:
        """Whether the pivot changes: with constraints, or friction of forces of joints."""
        return bool(self.constraints) or self._motion.is_coupled

    # --- functions -------------------------------------------------------------------------------

    @cached_property
    def f(self) -> ca.Function:
        """(t, x, u, p) -> x' (2k,) and the least pivot of the constraints over the largest."""
        rates = ca.vertcat(self.equations.state[self.equations.size :], self._motion.values["a"])
        return self._build("f", {"xdot": rates, "pivot": self._motion.pivot})

    @cached_property
    def f_jacobian(self) -> ca.Function:
        """(t, x, u, p) -> A, B, F."""
        k = self.equations.size
        upper = ca.jacobian(self.equations.state[k:], self._symbols)
        slopes = ca.vertcat(upper, self._slopes["a"])
        return self._build("f_jacobian", dict(zip("ABF", self._split(slopes), strict=True)))

    @cached_property
    def y(self) -> ca.Function:
        """(t, x, u, p) -> y (r,)."""
        return self._build("y", {"y": self._motion.substitute(self._output_graph)})

    @cached_property
    def y_jacobian(self) -> ca.Function:
        """(t, x, u, p) -> C, D, G."""
        graph = self._output_graph
        slopes = ca.jacobian(graph, self._symbols)
        for name, symbol in self._motion.symbols.items():
            slopes += ca.jacobian(graph, symbol) @ self._slopes[name]
        parts = self._split(self._motion.substitute(slopes))
        return self._build("y_jacobian", dict(zip("CDG", parts, strict=True)))

    @cached_property
    def curvature(self) -> ca.Function:
        """(t, x, u, p, weights (2k,), direction (2k + m + q,)) -> derivative along the direction of
        the gradient of weights^T x' by state, inputs and parameters.
        """
        k = self.equations.size
        weights = ca.SX.sym("weights", 2 * k)
        direction = ca.SX.sym("direction", self._symbols.numel())
        upper = ca.jacobian(self.equations.state[k:], self._symbols)
        slopes = ca.densify(ca.vertcat(upper, self._slopes["a"]))
        gradient = slopes.T @ weights
        change = ca.jtimes(gradient, self._symbols, direction)
        symbols = [*self._arguments[:4], weights, direction, *self._opened]
        names = [*ARGUMENTS, "weights", "direction", *(["signs"] if self._opened else [])]
        return ca.Function("curvature", symbols, [ca.cse(change)], names, ["curvature"])

    @cached_property
    def constraint_values(self) -> ca.Function:
        """(t, x, u, p) -> gaps, then speeds, that the constraints keep zero."""
        values = ca.densify(ca.vertcat(self.equations.gap_values, self.equations.speeds))
        return self._build("constraint_values", {"values": values})

    @cached_property
    def _constraint_jacobian(self) -> ca.Function:
        values = self.constraint_values(*self._arguments)
        slopes = ca.densify(ca.jacobian(values, self.equations.state))
        return self._build("constraint_jacobian", {"slopes": slopes})

    @property
    def _arguments(self) -> list[ca.SX]:
        return [self.equations.time, self.equations.state, self._u, self._p, *self._opened]

    @property
    def _symbols(self) -> ca.SX:
        """State, inputs and parameters: what derivatives are by."""
        return ca.vertcat(self.equations.state, self._u, self._p)

    def _build(self, name: str, outputs: dict[str, ca.SX]) -> ca.Function:
        graphs = ca.cse(list(outputs.values()))
        names = [*ARGUMENTS, *(["signs"] if self._opened else [])]
        return ca.Function(name, self._arguments, graphs, names, list(outputs))

    def _split(self, slopes: ca.SX) -> list[ca.SX]:
        ends = np.cumsum([0, self.equations.state.numel(), self._u.numel(), self._p.numel()])
        parts: list[ca.SX] = ca.horzsplit(slopes, ends.tolist())
        return parts

    @cached_property
    def _motion(self) -> _Motion:
        return _Motion(self.equations, self._choice, self._signs, self.stabilise)

    @cached_property
    def _slopes(self) -> dict[str, ca.SX]:
        """Derivatives of the unknowns by the symbols."""
        return self._motion.differentiate(self._symbols)

    @cached_property
    def _output_graph(self) -> ca.SX:
        """Outputs in the symbols of the unknowns."""
        equations, motion = self.equations, self._motion
        values = equations.evaluate(
            "lane",
            accelerations=motion.symbols["a"],
            actions=motion.actions,
            sizes=motion.sizes,
        )
        names = equations.outputs("lane")
        rows = [k for k, name in enumerate(names) if name not in self._choice.undetermined]
        events = equations.evaluate("events") if equations.outputs("events") else ca.SX(0, 1)
        sizes = [k for k, n in enumerate(equations.pressing) if n not in self._choice.undetermined]
        pivot = motion.pivot if self.has_pivot else ca.SX(0, 1)
        return ca.vertcat(values[rows], motion.sizes[sizes], pivot, events)


_PIVOT_ENTRY = {
    "name": PIVOT,
    "unit": "1",
    "meaning": "least pivot over the largest: near 0 constraints or friction determine no motion",
}


def _describe(
    entry: dict[str, Any], value: float, bounds: dict[str, Any] | None = None
) -> DynamicsVariable:
    ends = {key: bounds[key] for key in ("low", "high") if key in (bounds or {})} if bounds else {}
    return DynamicsVariable(entry["name"], entry["unit"], entry["meaning"], float(value), **ends)


class _Choice:
    """What is decided once, at the start: `rows` of constraints and of balances that do not follow
    from others, the actions that these determine, and the signs of all actions.
    """

    def __init__(self, dynamics: Dynamics, equations: MotionEquations, start: Array) -> None:
        self.rows, self.weight = np.empty(0, dtype=np.intp), 0.0
        if equations.constraints:
            now = dynamics.equations(0.0, start)
            self.rows = find_independent_rows(now.slopes)
            self.weight = _find_weight(now.inertia, now.slopes[self.rows])
        self.balances = self.actions = np.empty(0, dtype=np.intp)
        self.undetermined: tuple[str, ...] = ()
        self.signs = np.empty(0)
        if equations.actions:
            self._choose_balances(dynamics, equations, start)

    def _choose_balances(
        self, dynamics: Dynamics, equations: MotionEquations, start: Array
    ) -> None:
        inputs = {
            "time": 0.0,
            "data": dynamics.data,
            "state": start,
            "accelerations": dynamics.accelerations(0.0, start)[0],
        }
        if equations.pressing:
            inputs["sizes"] = dynamics.find_sizes(0.0, start)
        reactions = Reactions(dynamics.formulas)
        actions, self.undetermined = reactions.solve(inputs)
        self.signs = np.where(actions[:, 0] < 0, -1.0, 1.0)
        matrix = reactions.build_rows(inputs)[0][0]
        self.balances = find_independent_rows(matrix)
        self.actions = find_independent_rows(matrix[self.balances].T)


SINGULAR = 1e-9
"""Share of the largest eigenvalue below which an inertia does not resist some motion."""


def _find_weight(inertia: Array, slopes: Array) -> float:
    """Return the weight of constraints (`ConstrainedFactor`): zero for an inertia that is regular."""
    eigenvalues = np.linalg.eigvalsh((inertia + inertia.T) / 2)
    if not len(slopes) or eigenvalues[0] > SINGULAR * eigenvalues[-1]:
        return 0.0
    return float(np.trace(inertia) / np.sum(slopes**2))


def _stabilise(graphs: MotionEquations, rate: float) -> ca.SX:
    """Return bends with which gaps and slips decay."""
    if rate == 0:
        return graphs.bends
    count = graphs.gap_values.numel()
    factors = ca.DM([2 * rate] * count + [rate] * (graphs.speeds.numel() - count))
    slips = ca.SX(graphs.speeds.numel() - count, 1)
    return graphs.bends - factors * graphs.speeds - rate**2 * ca.vertcat(graphs.gap_values, slips)


class _Motion:
    """Accelerations a, multipliers l and actions r, which the equations of motion determine.

    `symbols` stand for them, `values` are graphs of time, state and data.
    """

    def __init__(
        self, equations: MotionEquations, choice: _Choice, signs: ca.SX, stabilise: float = 0.0
    ) -> None:
        rows = choice.rows.tolist()
        bends = _stabilise(equations, stabilise)[rows, :]
        slopes = equations.slopes[rows, :]
        a, multipliers = ca.SX.sym("a", equations.size), ca.SX.sym("l", len(rows))
        r = ca.SX.sym("r", len(choice.actions))
        self.symbols = {"a": a, "l": multipliers, "r": r}
        self.actions = ca.SX.zeros(len(equations.actions))
        self.actions[choice.actions.tolist()] = r
        pressing = [equations.actions.index(name) for name in equations.pressing]
        self.sizes = signs * self.actions[pressing]
        residual = equations.evaluate("residual", accelerations=a, sizes=self.sizes)
        self._residuals = [residual - slopes.T @ multipliers, slopes @ a - bends]
        if equations.actions:
            matrix, loads = equations.balances(a)
            balances = (matrix @ self.actions + loads)[choice.balances.tolist()]
            self._residuals.append(ca.substitute(balances, equations.sizes, self.sizes))
        self._slopes, self._equations, self._weight = slopes, equations, choice.weight
        self.is_coupled = bool(r.numel()) and ca.depends_on(residual, r)
        self.values = {name: ca.SX.zeros(symbol.numel()) for name, symbol in self.symbols.items()}
        right = [-self.substitute(part) for part in self._residuals]
        self.values = self._solve(right, None if self.is_coupled else equations.accelerations)

    def differentiate(self, symbols: ca.SX) -> dict[str, ca.SX]:
        """Return derivatives (n, s) of what is unknown by symbols (s,)."""
        slopes = [ca.jacobian(part, symbols) for part in self._residuals]
        return self._solve([-self.substitute(part) for part in slopes])

    def substitute(self, graph: ca.SX) -> ca.SX:
        """Return a graph with the values of what is unknown for its symbols."""
        symbols, values = ca.vertcat(*self.symbols.values()), ca.vertcat(*self.values.values())
        return ca.substitute(graph, symbols, values)

    @cached_property
    def pivot(self) -> ca.SX:
        """The least pivot over the largest."""
        if self.is_coupled:
            return solve_system(self._matrix, ca.SX(self._matrix.size1(), 1)).pivot
        return self._factor.pivot if self._slopes.size1() else ca.SX(1)

    @cached_property
    def _factor(self) -> ConstrainedFactor:
        return ConstrainedFactor(self._equations.inertia, self._slopes, self._weight)

    @cached_property
    def _matrix(self) -> ca.SX:
        """Slopes of all residuals, where friction makes the motion depend on the actions."""
        return ca.jacobian(ca.vertcat(*self._residuals), ca.vertcat(*self.symbols.values()))

    def _solve(self, right: list[ca.SX], accelerations: ca.SX | None = None) -> dict[str, ca.SX]:
        """Return what the slopes of the residuals times unknowns equal: motion first, unless its
        accelerations are known, actions from it.
        """
        if self.is_coupled:
            ends = np.cumsum([0, *(symbol.numel() for symbol in self.symbols.values())]).tolist()
            solution = solve_system(self._matrix, ca.vertcat(*right)).solution
            return dict(zip(self.symbols, ca.vertsplit(solution, ends), strict=True))
        multipliers = right[1]
        if accelerations is None:
            accelerations, multipliers = self._factor.solve(right[0], right[1])
        actions = ca.SX(0, right[0].size2())
        for part, rest in zip(self._residuals[2:], right[2:], strict=True):
            change = ca.jacobian(part, self.symbols["a"]) @ accelerations
            slope = ca.jacobian(part, self.symbols["r"])
            actions = solve_system(slope, rest - change).solution
        return {"a": accelerations, "l": multipliers, "r": actions}
