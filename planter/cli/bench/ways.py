"""Ways to evaluate the objective of a cycle and its derivatives, all from the same graph.

F(phi) = S(phi) + S(phi - pi), with the share S of one side: every way evaluates S once over all
lanes, and takes the prologue h and its tangent dh as numbers. CasADi differentiates the whole cycle
itself, with the angles in a loop; NumPy and SymPy's `lambdify` run the graph of the share and its
slopes operation by operation, JAX that of the share, which it differentiates.
"""

from __future__ import annotations

import importlib
import operator
import os
from collections.abc import Callable, Sequence
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.outputs import CycleObjective, evaluate_many
from planter.kernels import Array, toolchain
from planter.kernels.compiler import CompilerError
from planter.papers.planting import file
from planter.papers.planting.model import Device

MACHINE = "wang2017"
Call = Callable[[Array], Any]
"""From a design (p,) to its objective; to that and its gradient (p,); to its Hessian (p, p); from
designs (m, p) to their objectives (m,).
"""


class Absent(Exception):
    """Raised if a way is not installed or cannot do a task; the message is the reason."""


def list_operations(xp: Any) -> dict[int, Callable[..., Any]]:
    """Return CasADi's operations by a library with NumPy's names; truth is 1.0 and 0.0."""

    def compare(name: str) -> Callable[..., Any]:
        truth = getattr(xp, name)
        return lambda a, b: xp.where(truth(a, b), 1.0, 0.0)

    return {
        ca.OP_ADD: operator.add,
        ca.OP_SUB: operator.sub,
        ca.OP_MUL: operator.mul,
        ca.OP_DIV: operator.truediv,
        ca.OP_NEG: operator.neg,
        ca.OP_INV: lambda a: 1 / a,
        ca.OP_SQ: lambda a: a**2,
        ca.OP_TWICE: lambda a: 2 * a,
        ca.OP_SQRT: xp.sqrt,
        ca.OP_SIN: xp.sin,
        ca.OP_COS: xp.cos,
        ca.OP_ATAN: xp.arctan,
        ca.OP_ATAN2: xp.arctan2,
        ca.OP_FLOOR: xp.floor,
        ca.OP_LT: compare("less"),
        ca.OP_LE: compare("less_equal"),
        ca.OP_NOT: lambda a: 1 - a,
        ca.OP_OR: xp.maximum,
        # Not a product: zero times infinity would not be zero.
        ca.OP_IF_ELSE_ZERO: lambda chosen, then: xp.where(chosen, then, 0.0),
    }


def run_graph(
    function: ca.Function, operations: dict[int, Callable[..., Any]], inputs: Sequence[Any]
) -> list[Any]:
    """Return the entries of all outputs of a scalar function for inputs of indexable entries."""
    work: dict[int, Any] = {}
    starts = np.cumsum([0, *(function.numel_out(i) for i in range(function.n_out()))])
    outputs: list[Any] = [0.0] * int(starts[-1])
    for step in range(function.n_instructions()):
        operation = function.instruction_id(step)
        source, target = function.instruction_input(step), function.instruction_output(step)
        if operation == ca.OP_CONST:
            work[target[0]] = function.instruction_constant(step)
        elif operation == ca.OP_INPUT:
            work[target[0]] = inputs[source[0]][source[1]]
        elif operation == ca.OP_OUTPUT:
            outputs[starts[target[0]] + target[1]] = work[source[0]]
        else:
            terms = [work[place] for place in source]
            work[target[0]] = operations[operation](*terms)
    return outputs


class TimedCycle:
    """The objective of the built-in machine over the samples of its file."""

    def __init__(self, name: str = MACHINE) -> None:
        self.device = Device(file.load(name))
        self.turns = CycleObjective(self.device)
        self.response = self.device.force.response
        self.lanes: Array = np.add.outer(self.device.force.offsets, self.turns.angles).ravel()

    def draw_designs(self, rng: np.random.Generator, count: int) -> Array:
        """Return random designs (count, p) within the bounds."""
        lower, upper = self.device.lower, self.device.upper
        designs: Array = lower + rng.random((count, len(lower))) * (upper - lower)
        return designs

    def objective(self, force: Any, xp: Any) -> Any:
        """Return the objective of a force (n,), as arrays of a library `xp` have it."""
        weights = self.device.machine.objective
        spread = weights.weighted(xp.var(force), xp.sqrt)
        return weights.weight_range * (xp.max(force) - xp.min(force)) + spread

    def add_sides(self, lanes: Any) -> Any:
        """Return rows (..., sides n) of lanes added up over the sides, (..., n)."""
        return lanes.reshape(*lanes.shape[:-1], len(self.device.force.offsets), -1).sum(-2)

    @cached_property
    def slope(self) -> ca.Function:
        """(force) -> the objective, and its slope in the force at each angle."""
        force = ca.MX.sym("force", len(self.turns.angles))
        value = self.objective(force, GRAPHS)
        return ca.Function("slope", [force], [value, ca.gradient(value, force)])

    def add_slopes(self, share: Array, slopes: Sequence[Any]) -> tuple[float, Array]:
        """Return objective and gradient (p,) from the share and its slopes in (phi, x) by lanes."""
        value, weights = self.slope(self.add_sides(share))
        rows = np.array([np.broadcast_to(row, self.lanes.shape) for row in slopes[1:]])
        return float(value), self.add_sides(rows) @ np.array(weights)[:, 0]


Builder = Callable[[TimedCycle, str], Call]

GRAPHS = SimpleNamespace(
    max=ca.mmax,
    min=ca.mmin,
    sqrt=ca.sqrt,
    var=lambda f: ca.sumsqr(f - ca.sum1(f) / f.numel()) / f.numel(),
)
"""CasADi under the names of NumPy that an objective needs."""


def build_casadi(cycle: TimedCycle, work: str) -> ca.Function:
    """Return the function from a design to the results of a task, the lanes as a loop."""
    response, size = cycle.response, cycle.device.size
    x, lanes = ca.MX.sym("x", size), ca.DM(cycle.lanes).T
    d = ca.vertcat(x, ca.DM(cycle.device.constants))

    def loop(function: ca.Function) -> ca.Function:
        shared = list(range(1, function.n_in()))
        return function.map(f"{function.name()}_cycle", "serial", lanes.numel(), shared, [])

    def fold(rows: ca.MX) -> ca.MX:
        return ca.sum1(ca.reshape(rows, len(cycle.turns.angles), -1).T).T

    if work == "cycle+gradient":
        # One pass with the tangents takes less than CasADi's reverse mode through the loop.
        h, jacobian = response.tangent(d)
        slopes = loop(response.slopes_kernel.function)
        rows, tangents = slopes(lanes, d, h, ca.vec(jacobian.nz[:]))
        value, weights = cycle.slope(fold(rows))
        gradient = tangents[1:, :] @ ca.repmat(weights, len(cycle.device.force.offsets), 1)
        return ca.Function("gradient", [x], [value, gradient])
    rows = loop(response.values_kernel.function)(lanes, d, response.machine.prologue(d))
    value = cycle.objective(fold(rows), GRAPHS)
    if work == "hessian":
        hessian = ca.jtimes(ca.gradient(value, x), x, ca.DM.eye(size))
        return ca.Function("hessian", [x], [hessian])
    return ca.Function("value", [x], [value])


def call_casadi(function: ca.Function, work: str) -> Call:
    """Return the call of a function by `build_casadi`; many designs go to threads."""
    if work == "batch":
        threads = os.cpu_count() or 1
        return lambda designs: np.array(
            function.map(len(designs), "thread", min(threads, len(designs)))(designs.T)
        )[0]
    if work == "cycle":
        return lambda x: float(function(x))
    if work == "hessian":
        return lambda x: np.array(function(x))

    def both(x: Array) -> tuple[float, Array]:
        value, gradient = function(x)
        return float(value), np.array(gradient)[:, 0]

    return both


def build_virtual_machine(cycle: TimedCycle, work: str) -> Call:
    """Return CasADi's virtual machine."""
    return call_casadi(build_casadi(cycle, work), work)


def build_c(cycle: TimedCycle, work: str) -> Call:
    """Return CasADi's own C. Raises Absent if it cannot be compiled."""
    function = build_casadi(cycle, work)
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    try:
        path = toolchain.build_library(function.name(), generator.dump(), toolchain.OPTIMISED)
        toolchain.load_library(path)
    except CompilerError as reason:
        raise Absent(str(reason)) from None
    return call_casadi(ca.external(function.name(), str(path)), work)


def build_lanes(cycle: TimedCycle, work: str) -> Call:
    """Return the kernels of planter. Raises Absent if they are evaluated otherwise here."""
    if cycle.turns.way != "lanes":
        raise Absent(f"this machine evaluates cycles by {cycle.turns.way}")
    if work == "batch":
        return lambda designs: evaluate_many(cycle.device, designs, cycle.turns.samples).objective
    cycle.response.hessian_kernel.compile()
    calls: dict[str, Call] = {
        "cycle": cycle.turns.value,
        "cycle+gradient": cycle.turns.gradient,
        "hessian": cycle.turns.hessian,
    }
    return calls[work]


Run = Callable[[Sequence[Any]], Sequence[Any]]
"""From inputs of indexable entries to the entries of all outputs, one after another."""


def compile_numpy(function: ca.Function) -> Run:
    """Return the graph in NumPy."""
    operations = list_operations(np)
    return lambda inputs: run_graph(function, operations, inputs)


def compile_jax(function: ca.Function) -> Run:
    """Return the graph by JAX's `jit`."""
    jax = import_optional("jax")
    jax.config.update("jax_enable_x64", True)
    operations = list_operations(jax.numpy)
    run: Run = jax.jit(lambda inputs: run_graph(function, operations, inputs))
    return run


def compile_sympy(function: ca.Function) -> Run:
    """Return the graph as SymPy's `lambdify` prints it, a step for each operation."""
    sympy = import_optional("sympy")
    steps: list[tuple[Any, Any]] = []

    def note(compute: Callable[..., Any]) -> Callable[..., Any]:
        def run(*terms: Any) -> Any:
            steps.append((sympy.Symbol(f"step{len(steps)}"), compute(*terms)))
            return steps[-1][0]

        return run

    undefined = ("where", "less", "less_equal", "maximum", "floor")
    names = {name: sympy.Function(name) for name in undefined}
    names |= {name: getattr(sympy, name) for name in ("sqrt", "sin", "cos")}
    xp = SimpleNamespace(**names, arctan=sympy.atan, arctan2=sympy.atan2)
    operations = {code: note(compute) for code, compute in list_operations(xp).items()}
    sizes = [(function.name_in(i), function.numel_in(i)) for i in range(function.n_in())]
    inputs = [list(sympy.symbols(f"{name}:{size}")) for name, size in sizes]
    outputs = run_graph(function, operations, inputs)
    run = sympy.lambdify(inputs, outputs, "numpy", cse=lambda _: (steps, outputs))
    return lambda values: run(*values)


def import_optional(name: str) -> Any:
    """Return a module. Raises Absent if it is not installed."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        raise Absent(f"{name} is not installed") from None


def build_arrays(compile_graph: Callable[[ca.Function], Run]) -> Builder:
    """Return the builder of a way that runs the graph of the share on arrays over the lanes."""

    def build(cycle: TimedCycle, work: str) -> Call:
        response = cycle.response
        if work == "hessian":
            raise Absent("arrays have the objective and its gradient alone")
        if work == "cycle+gradient":
            slopes = compile_graph(response.slopes_kernel.function)

            def both(x: Array) -> tuple[float, Array]:
                point = response.at(x)
                share, *rows = slopes([cycle.lanes[None], point.d, point.h, point.dh])
                return cycle.add_slopes(np.asarray(share), rows)

            return both
        values = compile_graph(response.values_kernel.function)

        def value(x: Array) -> float:
            point = response.at(x)
            (share,) = values([cycle.lanes[None], point.d, point.h])
            return float(cycle.objective(cycle.add_sides(np.asarray(share)), np))

        if work == "batch":
            return lambda designs: np.array([value(x) for x in designs])
        return value

    return build


BUILDERS: dict[str, Builder] = {
    "casadi-vm": build_virtual_machine,
    "numpy": build_arrays(compile_numpy),
    "lambdify": build_arrays(compile_sympy),
    "jax": build_arrays(compile_jax),
    "casadi-c": build_c,
    "lanes": build_lanes,
}
"""Ways by their names; the first is what the others must agree with."""
