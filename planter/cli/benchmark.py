"""The same task by each way to evaluate a cycle: all must agree, then they take turns in one process.

F(phi) = S(phi) + S(phi - pi), with the share S of one side: every way evaluates S once over all
lanes, and takes the prologue h and its tangent dh as numbers. CasADi differentiates the whole cycle
itself, with the angles in a loop; NumPy, JAX and SymPy's `lambdify` run the graph of the share and
of its slopes, operation by operation.
"""

from __future__ import annotations

import gc
import importlib
import operator
import os
import platform
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from importlib import metadata
from importlib.util import find_spec
from itertools import count, repeat
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from planter import workers
from planter.cli.results import WORKS, Benchmark, TaskTimes, WayTimes
from planter.engine.outputs import CycleObjective, evaluate_many
from planter.errors import ComputationError
from planter.kernels import Array, toolchain
from planter.kernels.compiler import CompilerError, find_compiler
from planter.papers.planting import file, optimisation
from planter.papers.planting.model import Device
from planter.progress import Listener, ProgressPhase
from planter.version import __version__

MACHINE = "wang2017"
EXACT = 1e-10
"""Ways must agree to this, relative to the largest entry of what they find."""
CHECKED, DESIGNS = 5, 1000
"""Designs at which the ways must agree; designs of a batch."""
ROUNDS, FEW_ROUNDS = 12, 3
"""Repetitions of a cycle's task, and of those that take seconds."""
SLOT_S, MOST_CALLS = 0.03, 200
"""Duration of a way's part of a round, and the number of its calls at most."""
PACKAGES = ("casadi", "numpy", "jax", "sympy")
UNITS = {
    "cycle": "us per cycle: objective",
    "cycle+gradient": "us per cycle: objective and gradient",
    "hessian": "us per cycle: Hessian of the objective",
    "batch": f"us per {DESIGNS} designs: their objectives",
    "optimise": "us per optimisation of the printed model",
    "derive": "us per derivation, all of generated/",
    "cold start": "us per new process: objective and gradient of a cycle",
}
GRADIENT = f"""\
from planter import Device, Turns, load_machine
turns = Turns(Device(load_machine({MACHINE!r})))
turns.gradient(turns.machine.design)
"""
"""What a new process does."""
DERIVED = ("derive", "generated", "planter")
"""What the derivation reads and writes, in a checkout."""
WAYS = ("casadi-vm", "numpy", "lambdify", "jax", "casadi-c", "lanes")
"""Ways to evaluate a cycle; the first is what the others must agree with."""
Call = Callable[[Any], Any]
"""From a design (p,) to its objective; to that and its gradient (p,); to its Hessian (p, p); from
designs (m, p) to their objectives (m,).
"""
Run = Callable[[Sequence[Any]], Sequence[Any]]
"""From inputs of indexable entries to the entries of all outputs, one after another."""


class AbsentError(Exception):
    """Raised if a way is not installed or cannot do a task; the message is the reason."""


def list_operations(xp: Any) -> dict[int, Callable[..., Any]]:
    """Return CasADi's operations by a library with NumPy's names; truth is 1.0 and 0.0."""

    def compare(name: str) -> Callable[..., Any]:
        return lambda a, b: xp.where(getattr(xp, name)(a, b), 1.0, 0.0)

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
    function: ca.Function, operations: Mapping[int, Callable[..., Any]], inputs: Sequence[Any]
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
            work[target[0]] = operations[operation](*(work[place] for place in source))
    return outputs


def compile_graph(function: ca.Function, way: str) -> Run:
    """Return a graph in NumPy, by JAX's `jit`, or as SymPy's `lambdify` prints it, step by step."""
    if way == "lambdify":
        return _print_graph(function)
    library = import_optional("jax") if way == "jax" else None
    if library is None:
        operations = list_operations(np)
        return lambda inputs: run_graph(function, operations, inputs)
    library.config.update("jax_enable_x64", True)
    operations = list_operations(library.numpy)
    run: Run = library.jit(lambda inputs: run_graph(function, operations, inputs))
    return run


def _print_graph(function: ca.Function) -> Run:
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
    """Return a module. Raises AbsentError if it is not installed."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        raise AbsentError(f"{name} is not installed") from None


class TimedCycle:
    """The objective of the built-in machine over the samples of its file."""

    def __init__(self) -> None:
        self.device = Device(file.load(MACHINE))
        self.turns = CycleObjective(self.device)
        self.response = self.device.force.response
        self.lanes: Array = np.add.outer(self.device.force.offsets, self.turns.angles).ravel()

    def draw_designs(self, rng: np.random.Generator, number: int) -> Array:
        """Return random designs (number, p) within the bounds."""
        return rng.uniform(self.device.lower, self.device.upper, (number, self.device.size))

    @cached_property
    def slope(self) -> ca.Function:
        """(force) -> the objective, and its slope in the force at each angle."""
        force, weights = ca.MX.sym("force", len(self.turns.angles)), self.device.machine.objective
        variance = ca.sumsqr(force - ca.sum1(force) / force.numel()) / force.numel()
        spread = weights.weighted(variance, ca.sqrt)
        value = weights.weight_range * (ca.mmax(force) - ca.mmin(force)) + spread
        return ca.Function("slope", [force], [value, ca.gradient(value, force)])

    def add_sides(self, lanes: Array) -> Array:
        """Return rows (..., sides n) of lanes added up over the sides, (..., n)."""
        total: Array = lanes.reshape(*lanes.shape[:-1], len(self.device.force.offsets), -1).sum(-2)
        return total

    def call(self, way: str, work: str) -> Call:
        """Return the call of a task by a way. Raises AbsentError if the way cannot do it here."""
        if way == "lanes":
            return self._call_lanes(work)
        if way.startswith("casadi"):
            return self._call_casadi(work, is_compiled=way == "casadi-c")
        return self._call_graph(way, work)

    def _call_lanes(self, work: str) -> Call:
        """Return the kernels of planter."""
        if self.turns.way != "lanes":
            raise AbsentError(f"this machine evaluates cycles by {self.turns.way}")
        self.response.hessian_kernel.compile()
        calls: dict[str, Call] = {
            "cycle": self.turns.value,
            "cycle+gradient": self.turns.gradient,
            "hessian": self.turns.hessian,
            "batch": lambda x: evaluate_many(self.device, x, self.turns.samples).objective,
        }
        return calls[work]

    def _call_casadi(self, work: str, is_compiled: bool) -> Call:
        """Return CasADi's virtual machine, or its own C; many designs go to threads."""
        function = self._build_casadi(work)
        if is_compiled:
            generator = ca.CodeGenerator(f"{function.name()}.c")
            generator.add(function)
            try:
                text = generator.dump()
                path = toolchain.build_library(function.name(), text, toolchain.OPTIMISED)
                toolchain.load_library(path)
            except CompilerError as reason:
                raise AbsentError(str(reason)) from None
            function = ca.external(function.name(), str(path))
        if work == "batch":
            threads = os.cpu_count() or 1
            return lambda designs: function.map(len(designs), "thread", min(threads, len(designs)))(
                designs.T
            ).full()[0]
        if work == "cycle+gradient":
            return lambda x: tuple(np.squeeze(part) for part in function(x))
        return lambda x: np.squeeze(function(x))

    def _build_casadi(self, work: str) -> ca.Function:
        """Return the function from a design to the results of a task, the lanes as a loop."""
        response, size = self.response, self.device.size
        x, lanes = ca.MX.sym("x", size), ca.DM(self.lanes).T
        d = ca.vertcat(x, ca.DM(self.device.constants))

        def loop(function: ca.Function) -> ca.Function:
            shared = list(range(1, function.n_in()))
            return function.map(f"{function.name()}_cycle", "serial", lanes.numel(), shared, [])

        def fold(rows: ca.MX) -> ca.MX:
            return ca.sum1(ca.reshape(rows, len(self.turns.angles), -1).T).T

        if work == "cycle+gradient":
            # One pass with the tangents takes less than CasADi's reverse mode through the loop.
            h, jacobian = response.tangent(d)
            slopes = loop(response.slopes_kernel.function)
            rows, tangents = slopes(lanes, d, h, ca.vec(jacobian.nz[:]))
            value, weights = self.slope(fold(rows))
            gradient = tangents[1:, :] @ ca.repmat(weights, len(self.device.force.offsets), 1)
            return ca.Function("gradient", [x], [value, gradient])
        rows = loop(response.values_kernel.function)(lanes, d, response.machine.prologue(d))
        value = self.slope(fold(rows))[0]
        if work == "hessian":
            value = ca.jtimes(ca.gradient(value, x), x, ca.DM.eye(size))
        return ca.Function("value", [x], [value])

    def _call_graph(self, way: str, work: str) -> Call:
        """Return a way that runs the graph of the share on arrays over the lanes."""
        response = self.response
        if work == "hessian":
            raise AbsentError("arrays have the objective and its gradient alone")
        if work == "cycle+gradient":
            slopes = compile_graph(response.slopes_kernel.function, way)

            def both(x: Array) -> tuple[float, Array]:
                point = response.at(x)
                share, *rows = slopes([self.lanes[None], point.d, point.h, point.dh])
                value, weights = self.slope(self.add_sides(np.asarray(share)))
                tangents = np.array([np.broadcast_to(row, self.lanes.shape) for row in rows[1:]])
                return float(value), self.add_sides(tangents) @ weights.full()[:, 0]

            return both
        values = compile_graph(response.values_kernel.function, way)

        def value(x: Array) -> float:
            point = response.at(x)
            (share,) = values([self.lanes[None], point.d, point.h])
            return float(self.slope(self.add_sides(np.asarray(share)))[0])

        return (lambda designs: np.array(list(map(value, designs)))) if work == "batch" else value


def run_benchmark(works: Sequence[str], progress: Listener | None = None) -> Benchmark:
    """Return the times of some tasks. Raises ComputationError if a way disagrees with the others."""
    cycle, phase = TimedCycle(), ProgressPhase("bench", "work", len(works), progress)
    skipped = {name: "not among the quick tasks" for name in WORKS if name not in works}
    results = []
    for name in works:
        try:
            results.append(run_task(name, cycle))
        except AbsentError as reason:
            skipped[name] = str(reason)
        phase.advance(name)
    machine = {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
    }
    versions = {"planter": __version__, "python": platform.python_version()}
    versions |= {name: metadata.version(name) for name in PACKAGES if find_spec(name)}
    with suppress(CompilerError):
        versions["compiler"] = find_compiler().version
    return Benchmark(results, machine, versions, skipped)


def run_task(name: str, cycle: TimedCycle) -> TaskTimes:
    """Return the times of a task. Raises AbsentError if it cannot be done here."""
    if name == "optimise":
        return time_task(name, list_searches(cycle), count(), "ipopt")
    if name == "derive":
        with prepare_derivation() as derive:
            return time_task(name, {"derive": derive}, count(), "derive")
    if name == "cold start":
        ways = ("lanes", "casadi-c", "casadi-vm")
        return time_task(name, {way: build_start(way) for way in ways}, count(), "lanes")
    calls, skipped = dict[str, Call](), dict[str, str]()
    for way in WAYS:
        try:
            calls[way] = cycle.call(way, name)
        except AbsentError as reason:
            skipped[way] = str(reason)
    rng, is_batch = np.random.default_rng(0), name == "batch"
    batches = (cycle.draw_designs(rng, each) for each in repeat(DESIGNS if is_batch else 1))
    designs = (batch if is_batch else batch[0] for batch in batches)
    check_agreement(name, calls, [next(designs) for _ in range(1 if is_batch else CHECKED)])
    return time_task(name, calls, designs, "lanes", skipped)


def check_agreement(work: str, calls: Mapping[str, Call], inputs: Sequence[Array]) -> None:
    """Raise ComputationError, naming task and way, if a way's results are not those of the first."""
    reference, *compared = calls
    for x in inputs:
        expected = _list_parts(calls[reference](x))
        for name in compared:
            for part, target in zip(_list_parts(calls[name](x)), expected, strict=True):
                off = float(np.abs(part - target).max() / np.abs(target).max())
                if not off <= EXACT:
                    raise ComputationError(
                        f"{work}: {name} is off {reference} by {off:.2g}; {EXACT:g} is allowed"
                    )


def _list_parts(result: Any) -> list[Array]:
    parts = result if isinstance(result, tuple) else (result,)
    return [np.atleast_1d(np.asarray(part, dtype=float)) for part in parts]


def time_task(
    name: str,
    calls: Mapping[str, Call],
    inputs: Iterator[Any],
    over: str,
    skipped: dict[str, str] | None = None,
) -> TaskTimes:
    """Return the times of each way on inputs that are new every time, with ratios to that of `over`.

    In a round every way has its slot, of as many calls as fill it; who begins changes from round to
    round. The first calls, which also fill caches, are not timed.
    """
    counts = {}
    for way, call in calls.items():
        call(next(inputs))
        counts[way] = max(1, min(MOST_CALLS, int(SLOT_S / time_call(call, next(inputs)))))
    rounds = ROUNDS if max(counts.values()) > 1 else FEW_ROUNDS
    seconds: dict[str, list[float]] = {way: [] for way in calls}
    order = list(calls)
    gc.disable()
    try:
        for _ in range(rounds):
            for way in order:
                slot = [next(inputs) for _ in range(counts[way])]
                seconds[way] += [time_call(calls[way], x) for x in slot]
            order.append(order.pop(0))
    finally:
        gc.enable()
    medians = {way: 1e6 * float(np.median(taken)) for way, taken in seconds.items()}
    reference = medians.get(over, next(iter(medians.values())))
    ways = [WayTimes(way, us, us / reference, len(seconds[way])) for way, us in medians.items()]
    return TaskTimes(name, UNITS[name], ways, skipped or {})


def time_call(call: Call, x: Any) -> float:
    """Return the duration of a call [s]."""
    begun = time.perf_counter()
    call(x)
    return time.perf_counter() - begun


def list_searches(cycle: TimedCycle) -> dict[str, Call]:
    """Return the searches for the optimum of the printed model by their seed: it has one basin."""
    device = Device(cycle.device.machine, "printed")
    device.compile()
    samples = device.machine.objective.samples

    def search(method: Any, starts: int | None = None) -> Call:
        return lambda seed: optimisation.search_optimum(device, method, samples, seed, starts)

    return {"ga": search("ga"), "ipopt": search("ipopt", 1), "hybrid": search("hybrid")}


def build_start(way: str) -> Call:
    """Return the start of a new process that evaluates kernels by a way, those in the cache."""
    command = workers.python_command(GRADIENT)
    return lambda _: run_process(command, PLANTER_KERNELS=way)


def run_process(command: Sequence[str], cwd: Path | None = None, **variables: str) -> None:
    """Run a process in a folder. Raises ComputationError if it fails."""
    done = workers.run_command(command, cwd, variables)
    if done.returncode:
        reason = " ".join(done.stderr.strip().splitlines()[-1:])
        raise ComputationError(f"a process of Python ended with {done.returncode}: {reason}")


@contextmanager
def prepare_derivation() -> Iterator[Call]:
    """Yield `python -m derive` in a copy of the checkout. Raises AbsentError outside one."""
    place = find_spec("derive")
    source = Path(place.origin).parents[1] if place and place.origin else Path()
    if find_spec("sympy") is None or not all((source / name).is_dir() for name in DERIVED):
        raise AbsentError("this is no checkout with SymPy")
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        copy = Path(folder)
        for name in DERIVED:
            shutil.copytree(source / name, copy / name)
        command = workers.program_command("derive", checkout=copy)
        yield lambda _: run_process(command, copy)


Table = tuple[Sequence[str], Sequence[Sequence[object]]]


def tabulate_benchmark(result: Benchmark) -> dict[str, Table]:
    """Return the tables of a benchmark by title: head and rows."""
    tables: dict[str, Table] = {}
    for task in result.work:
        rows = [(row.way, f"{row.median_us:.3g}", f"{row.ratio:.3g}") for row in task.ways]
        rows += [(way, "-", reason) for way, reason in task.skipped.items()]
        tables[f"{task.name} [{task.unit}]"] = ("way", "median / us", "ratio"), rows
    surroundings = {**result.machine, **result.versions}
    tables["Where it ran"] = ("name", "value"), list(surroundings.items())
    tables["Left out"] = ("task", "reason"), list(result.skipped.items())
    return tables


def format_markdown(tables: Mapping[str, Table]) -> str:
    """Return tables in Markdown."""
    lines = []
    for title, (head, rows) in tables.items():
        lines += [f"## {title}", ""]
        lines += [f"| {' | '.join(map(str, row))} |" for row in (head, ["---"] * len(head), *rows)]
        lines.append("")
    return "\n".join(lines)
