"""Generated array code over all angles: in NumPy with forward differences, in JAX, and as SymPy's
`lambdify`.

For SymPy the steps of the array code that the force needs are read as one expression each;
derivatives run backwards over them, a step at a time. JAX and SymPy are optional: they are imported
where they are used.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import statistics
import textwrap
import time
from collections.abc import Callable, Sequence
from functools import cached_property
from graphlib import TopologicalSorter
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from planter.bench.case import (
    EXACT,
    Absent,
    ArrayCode,
    BenchmarkCase,
    Call,
    Contender,
    load_array_module,
)
from planter.kernels import Array

STEP = 1e-6
"""Step of a difference, as a share of the box."""
DIFFERENCES = 1e-4
"""What a gradient by differences is allowed to be off, relative to its largest entry."""
DESIGNS_PER_ARRAY = 16
"""Designs in one array: what the caches hold."""
BUILT = "generated array code, one array over the angles"


def build_numpy_contender(case: BenchmarkCase, work: str) -> Contender:
    """Return array code in NumPy. Raises Absent for a Hessian."""
    if work == "cycle":
        return Contender(Plain(case).value, BUILT)
    if work == "cycle+gradient":
        return Contender(
            Plain(case).gradient, f"{BUILT}; forward differences", (EXACT, DIFFERENCES)
        )
    if work == "batch":
        return Contender(
            Plain(case).values,
            f"generated array code, arrays over the angles of {DESIGNS_PER_ARRAY} designs",
        )
    raise Absent("second differences agree with nothing to 1e-10")


def build_stacked_contender(case: BenchmarkCase, work: str) -> Contender:
    """All designs of a difference in one array: fewer calls of NumPy, larger arrays."""
    if work != "cycle+gradient":
        raise Absent("only a gradient has differences")
    built = "generated array code, one array over angles and steps; forward differences"
    return Contender(Plain(case).stacked_gradient, built, (EXACT, DIFFERENCES))


class Plain:
    """Objective and its differences in plain NumPy."""

    def __init__(self, case: BenchmarkCase) -> None:
        self.case, self.code = case, ArrayCode(case.device)
        self.steps = STEP * (case.device.upper - case.device.lower)

    def value(self, x: Array) -> float:
        """Return the objective of a design x (p,)."""
        h = self.case.invariants(x)
        share = self.code.share(np, self.case.lanes, x, h, self.case.constants)
        return self.case.build_objective(self.case.add_sides(share)).value

    def gradient(self, x: Array) -> tuple[float, Array]:
        """Return the objective of a design x (p,) and its gradient (p,)."""
        value = self.value(x)
        moved = [self.value(x + step) for step in np.diag(self.steps)]
        return value, (np.array(moved) - value) / self.steps

    def stacked_gradient(self, x: Array) -> tuple[float, Array]:
        """Return objective and gradient (p,), with all steps of the differences in one array."""
        value, *moved = self._values(np.vstack([x, x + np.diag(self.steps)]))
        return float(value), (np.array(moved) - value) / self.steps

    def values(self, designs: Array) -> Array:
        """Objectives of designs (m, p)."""
        return np.concatenate(
            [
                self._values(designs[i : i + DESIGNS_PER_ARRAY])
                for i in range(0, len(designs), DESIGNS_PER_ARRAY)
            ]
        )

    def _values(self, designs: Array) -> Array:
        x, h = designs.T[:, :, None], self.case.prologues(designs)[:, :, None]
        share = self.code.share(np, self.case.lanes[None, :], x, h, self.case.constants)
        return np.array(
            [self.case.build_objective(force).value for force in self.case.add_sides(share)]
        )


DESIGNS_PER_CALL = 500
"""Designs of a batch in one call."""
TRIALS = 15


def build_jax_contender(case: BenchmarkCase, work: str, thorough: bool = True) -> Contender:
    """The fastest of the forms that there are for a work, or, not `thorough`, the one that mostly
    is.
    """
    try:
        jax = importlib.import_module("jax")
    except ModuleNotFoundError:
        raise Absent("jax is not installed") from None
    jax.config.update("jax_enable_x64", True)
    forms = Forms(case, jax).build_calls(work)
    form = _fastest(case, work, forms if thorough else dict(list(forms.items())[:1]))
    return Contender(forms[form], f"jit, float64, prologue hoisted; {form}")


def _fastest(case: BenchmarkCase, work: str, forms: dict[str, Call]) -> str:
    if len(forms) == 1 or work == "batch":
        return next(iter(forms))
    designs = [x for x, _ in zip(case.designs(seed=1), range(TRIALS), strict=False)]
    return min(forms, key=lambda form: _seconds(forms[form], designs))


def _seconds(call: Call, designs: list[Array]) -> float:
    call(designs[0])
    taken = []
    for x in designs:
        begun = time.perf_counter()
        call(x)
        taken.append(time.perf_counter() - begun)
    return statistics.median(taken)


class Forms:
    """Forms of one calculation, which suit a compiler of arrays differently."""

    def __init__(self, case: BenchmarkCase, jax: ModuleType) -> None:
        self.case, self.code, self.jax, self.np = case, ArrayCode(case.device), jax, jax.numpy
        self.lanes, self.constants = self.np.asarray(case.lanes), self.np.asarray(case.constants)

    def build_calls(self, work: str) -> dict[str, Call]:
        """Return the calls of a work by their form; the first is mostly the fastest."""
        if work == "cycle":
            return {f"{name}": self._value(force) for name, force in self._forces().items()}
        if work == "cycle+gradient":
            share = self.share
            forward = {
                f"tangents along the design, {name}": self._tangents(f)
                for name, f in self._forces(True).items()
            }
            return {**forward, "reverse, share of a side at each lane": self._reverse(share)}
        if work == "hessian":
            return {"forward over reverse, share of a side at each lane": self._hessian()}
        return {f"vmap over {DESIGNS_PER_CALL} designs": self._batch()}

    def _forces(self, share_first: bool = False) -> dict[str, Callable[..., Any]]:
        forms = {
            "both sides at half the lanes": self.both,
            "share of a side at each lane": self.share,
        }
        return dict(sorted(forms.items(), reverse=True)) if share_first else forms

    def share(self, x: Any, h: Any) -> Any:
        """Return the force from the share of one side at each lane."""
        return self.case.add_sides(self.code.share(self.np, self.lanes, x, h, self.constants))

    def both(self, x: Any, h: Any) -> Any:
        """Return the force from both sides at half the lanes."""
        half = tuple(self.lanes.reshape(2, -1))
        return self.code.force(self.np, half, x, h, self.constants)

    def objective(self, force: Any) -> Any:
        """Return the objective of a force."""
        settings = self.case.objective
        spread = settings.weighted(force.var(), self.np.sqrt)
        return settings.weight_range * (force.max() - force.min()) + spread

    def _value(self, force: Callable[..., Any]) -> Call:
        run = self.jax.jit(lambda x, h: self.objective(force(x, h)))
        return lambda x: float(run(x, self.case.invariants(x)))

    def _with_gradient(self, function: Callable[..., Any]) -> Call:
        run = self.jax.jit(function)

        def call(x: Array) -> tuple[float, Array]:
            value, gradient = run(x, *self.case.prologue(x))
            return float(value), np.asarray(gradient)

        return call

    def _tangents(self, force: Callable[..., Any]) -> Call:
        size = self.case.device.size

        def both(x: Any, h: Any, dh: Any) -> Any:
            def differentiate(step: Any) -> Any:
                return self.jax.jvp(
                    lambda s: force(x + s, h + dh @ s), (self.np.zeros(size),), (step,)
                )

            response, rows = self.jax.vmap(differentiate, out_axes=(None, 0))(self.np.eye(size))
            value, weights = self.jax.value_and_grad(self.objective)(response)
            return value, rows @ weights

        return self._with_gradient(both)

    def _reverse(self, force: Callable[..., Any]) -> Call:
        def both(x: Any, h: Any, dh: Any) -> Any:
            slopes = self.jax.value_and_grad(lambda x, h: self.objective(force(x, h)), (0, 1))
            value, (along_x, along_h) = slopes(x, h)
            return value, along_x + dh.T @ along_h

        return self._with_gradient(both)

    def _hessian(self) -> Call:
        def slopes(x: Any, h: Any) -> Any:
            return self.jax.grad(lambda x, h: self.objective(self.share(x, h)), (0, 1))(x, h)

        def bent(x: Any, h: Any, dh: Any) -> Any:
            def differentiate(step: Any) -> Any:
                along_x, along_h = slopes(x + step, h + dh @ step)
                return along_x + dh.T @ along_h, along_h

            rows, (_, along_h) = self.jax.jacfwd(
                lambda s: (differentiate(s)[0], differentiate(s)), has_aux=True
            )(self.np.zeros(x.size))
            return rows, along_h

        run = self.jax.jit(bent)

        def call(x: Array) -> Array:
            rows, along_h = run(x, *self.case.prologue(x))
            hessian: Array = np.asarray(rows) + self.case.prologue_hessian(x, np.asarray(along_h))
            return hessian

        return call

    def _batch(self) -> Call:
        run = self.jax.jit(
            self.jax.vmap(lambda x, h: self.objective(self.both(x, h)), in_axes=(0, 1))
        )

        def call(designs: Array) -> Array:
            h = self.case.prologues(designs)
            parts = [
                run(designs[i : i + DESIGNS_PER_CALL], h[:, i : i + DESIGNS_PER_CALL])
                for i in range(0, len(designs), DESIGNS_PER_CALL)
            ]
            return np.concatenate([np.asarray(part) for part in parts])

        return call


Step = tuple[Any, Any]
BUILT = "lambdify with cse over the needed steps, one array over the angles"


def build_sympy_contender(case: BenchmarkCase, work: str) -> Contender:
    """Return SymPy's `lambdify`. Raises Absent if it is not installed or cannot do the task."""
    try:
        sympy = importlib.import_module("sympy")
    except ModuleNotFoundError:
        raise Absent("sympy is not installed") from None
    if work == "cycle":
        return Contender(Symbolic(case, sympy).value, BUILT)
    if work == "cycle+gradient":
        return Contender(
            Symbolic(case, sympy).gradient,
            f"{BUILT}; reverse derivatives by SymPy, prologue's by CasADi",
        )
    raise Absent("written for one design and its gradient only")


class _Named(ast.NodeTransformer):
    """Lets `step` see every value that is given a name."""

    def visit_Assign(self, node: ast.Assign) -> ast.Assign:
        target, value = node.targets[0], node.value
        if isinstance(target, ast.Name):
            node.value = self._seen(target, value)
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            value.elts = [self._seen(t, v) for t, v in zip(target.elts, value.elts, strict=True)]
        return node

    @staticmethod
    def _seen(target: ast.expr, value: ast.expr) -> ast.expr:
        return ast.Call(
            ast.Name("step", ast.Load()), [ast.Constant(ast.unparse(target)), value], []
        )


def _watched(function: Callable[..., Any], step: Callable[[str, Any], Any]) -> Callable[..., Any]:
    """A generated function that hands every named value to `step` and goes on with what that
    returns.
    """
    tree = ast.fix_missing_locations(
        _Named().visit(ast.parse(textwrap.dedent(inspect.getsource(function))))
    )
    names: dict[str, Any] = {**function.__globals__, "step": step}
    exec(compile(tree, inspect.getsourcefile(function) or "generated", "exec"), names)
    watched: Callable[..., Any] = names[function.__name__]
    return watched


class Symbolic:
    """Objective and gradient from NumPy code that SymPy prints."""

    def __init__(self, case: BenchmarkCase, sympy: ModuleType) -> None:
        self.case, self.sympy = case, sympy
        self.steps: list[Step] = []
        sizes = case.device.size, case.device.functions.h.numel(), len(case.constants)
        self.x, self.h, self.c = (
            list(sympy.symbols(f"{name}:{size}", real=True))
            for name, size in zip("xhc", sizes, strict=True)
        )
        self.phi = sympy.Symbol("phi", real=True)
        self.xp = _functions(sympy)
        self.share = self._traced()

    def value(self, x: Array) -> float:
        """Return the objective of a design x (p,)."""
        h = self.case.invariants(x)
        (share,) = self._value(self.case.lanes, x, h, self.case.constants)
        return self.case.build_objective(self.case.add_sides(share)).value

    def gradient(self, x: Array) -> tuple[float, Array]:
        """Return the objective of a design x (p,) and its gradient (p,)."""
        h, dh = self.case.prologue(x)
        share, *slopes = self._slopes(self.case.lanes, x, h, self.case.constants)
        turn = self.case.build_objective(self.case.add_sides(share))
        weights = np.tile(turn.slope, self.case.sides)
        total = np.array([np.broadcast_to(row, weights.shape) for row in slopes]) @ weights
        size = len(x)
        return turn.value, total[:size] + dh.T @ total[size:]

    @cached_property
    def _value(self) -> Callable[..., Any]:
        return self._printed([self.share], self.steps)

    @cached_property
    def _slopes(self) -> Callable[..., Any]:
        bars, more = self._backwards()
        slopes = [bars.get(symbol, self.sympy.Integer(0)) for symbol in (*self.x, *self.h)]
        return self._printed([self.share, *slopes], [*self.steps, *more])

    def _traced(self) -> Any:
        """The share in symbols; its steps are noted on the way."""
        code = ArrayCode(self.case.device)
        watched = [_watched(contact, self._step) for contact in code.contacts]
        source = load_array_module(f"planting_{self.case.device.model}")
        module: Any = SimpleNamespace(
            lane=_watched(source.lane, self._step), frame=_watched(source.frame, self._step)
        )
        code = ArrayCode(self.case.device, module, watched)
        return self._step("share", code.share(self.xp, self.phi, self.x, self.h, self.c))

    def _step(self, name: str, value: Any) -> Any:
        if not isinstance(value, self.sympy.Basic) or not value.args:
            return value
        symbol = self.sympy.Symbol(f"{name}_{len(self.steps)}", real=True)
        self.steps.append((symbol, value))
        return symbol

    def _backwards(self) -> tuple[dict[Any, Any], list[Step]]:
        """Derivatives of the share in every symbol, and the steps that lead to them, in order."""
        bars: dict[Any, Any] = {self.share: self.sympy.Integer(1)}
        more: list[Step] = []
        for symbol, value in reversed(self.steps):
            bar = bars.pop(symbol, None)
            if bar is None or value.is_Relational:
                continue
            adjoint = self.sympy.Symbol(f"bar_{symbol}", real=True)
            more.append((adjoint, bar))
            for other in sorted(value.free_symbols, key=str):
                slope = value.diff(other)
                if slope != 0:
                    bars[other] = bars.get(other, 0) + adjoint * slope
        return bars, more

    def _printed(self, outputs: Sequence[Any], steps: Sequence[Step]) -> Callable[..., Any]:
        """Compiled by `lambdify`: equal subexpressions once, steps that no output needs left
        out.
        """
        symbols, values = zip(*steps, strict=True)
        fresh = self.sympy.numbered_symbols("q", real=True)
        common, reduced = self.sympy.cse([*values, *outputs], symbols=fresh, order="none")
        meanings = dict([*common, *zip(symbols, reduced, strict=False)])
        ordered = [
            (symbol, meanings[symbol]) for symbol in _needed(meanings, reduced[len(symbols) :])
        ]
        functions = {"where": np.where, "logical_or": np.logical_or, "whole": np.floor}
        arguments = [self.phi, self.x, self.h, self.c]
        modules = [functions, "numpy"]
        return self.sympy.lambdify(
            arguments, list(outputs), modules, cse=lambda _: (ordered, reduced[len(symbols) :])
        )


def _needed(meanings: dict[Any, Any], outputs: Sequence[Any]) -> list[Any]:
    """Symbols that the outputs need, each after those that it needs itself."""
    waiting = {s for output in outputs for s in output.free_symbols if s in meanings}
    graph: dict[Any, list[Any]] = {}
    while waiting:
        symbol = waiting.pop()
        graph[symbol] = sorted((s for s in meanings[symbol].free_symbols if s in meanings), key=str)
        waiting |= {s for s in graph[symbol] if s not in graph}
    return list(TopologicalSorter(graph).static_order())


def _functions(sympy: ModuleType) -> SimpleNamespace:
    """The elementary functions under NumPy's names, on SymPy's expressions."""

    class where(sympy.Function):  # type: ignore[name-defined]
        """A select, with the derivative of the case that holds."""

        def _eval_derivative(self, symbol: Any) -> Any:
            condition, then, other = self.args
            slopes = then.diff(symbol), other.diff(symbol)
            return sympy.Integer(0) if slopes == (0, 0) else where(condition, *slopes)

    class flat(sympy.Function):  # type: ignore[name-defined]
        """A function that is constant but for jumps."""

        def _eval_derivative(self, symbol: Any) -> Any:
            return sympy.Integer(0)

    class whole(flat):
        pass

    class logical_or(flat):
        pass

    return SimpleNamespace(
        pi=sympy.pi,
        sin=sympy.sin,
        cos=sympy.cos,
        tan=sympy.tan,
        sqrt=sympy.sqrt,
        arctan=sympy.atan,
        arctan2=sympy.atan2,
        where=where,
        logical_or=logical_or,
        floor=whole,
    )
