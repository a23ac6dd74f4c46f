"""SymPy: `lambdify` with the common subexpressions of the generator's steps, the gradient from SymPy's derivatives.

The steps are read from the generated array code, each as one SymPy expression, and only those that the force needs.
Derivatives run backwards over them, a step at a time. Optional: SymPy is imported where it is used.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import textwrap
from collections.abc import Callable, Sequence
from functools import cached_property
from graphlib import TopologicalSorter
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from planter.bench.case import Absent, ArrayCode, BenchmarkCase, Contender, load_array_module
from planter.kernels import Array

Step = tuple[Any, Any]
BUILT = "lambdify with cse over the needed steps, one array over the angles"


def build_sympy_contender(case: BenchmarkCase, work: str) -> Contender:
    try:
        sympy = importlib.import_module("sympy")
    except ModuleNotFoundError:
        raise Absent("sympy is not installed") from None
    if work == "cycle":
        return Contender(Symbolic(case, sympy).value, BUILT)
    if work == "cycle+gradient":
        return Contender(Symbolic(case, sympy).gradient, f"{BUILT}; reverse derivatives by SymPy, prologue's by CasADi")
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
        return ast.Call(ast.Name("step", ast.Load()), [ast.Constant(ast.unparse(target)), value], [])


def _watched(function: Callable[..., Any], step: Callable[[str, Any], Any]) -> Callable[..., Any]:
    """A generated function that hands every named value to `step` and goes on with what that returns."""
    tree = ast.fix_missing_locations(_Named().visit(ast.parse(textwrap.dedent(inspect.getsource(function)))))
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
            list(sympy.symbols(f"{name}:{size}", real=True)) for name, size in zip("xhc", sizes, strict=True)
        )
        self.phi = sympy.Symbol("phi", real=True)
        self.xp = _functions(sympy)
        self.share = self._traced()

    def value(self, x: Array) -> float:
        h = self.case.invariants(x)
        (share,) = self._value(self.case.lanes, x, h, self.case.constants)
        return self.case.build_objective(self.case.add_sides(share)).value

    def gradient(self, x: Array) -> tuple[float, Array]:
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
        module: Any = SimpleNamespace(lane=_watched(source.lane, self._step), frame=_watched(source.frame, self._step))
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
        """Compiled by `lambdify`: equal subexpressions once, steps that no output needs left out."""
        symbols, values = zip(*steps, strict=True)
        fresh = self.sympy.numbered_symbols("q", real=True)
        common, reduced = self.sympy.cse([*values, *outputs], symbols=fresh, order="none")
        meanings = dict([*common, *zip(symbols, reduced, strict=False)])
        ordered = [(symbol, meanings[symbol]) for symbol in _needed(meanings, reduced[len(symbols) :])]
        functions = {"where": np.where, "logical_or": np.logical_or, "whole": np.floor}
        arguments = [self.phi, self.x, self.h, self.c]
        modules = [functions, "numpy"]
        return self.sympy.lambdify(arguments, list(outputs), modules, cse=lambda _: (ordered, reduced[len(symbols) :]))


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
        pi=sympy.pi, sin=sympy.sin, cos=sympy.cos, tan=sympy.tan, sqrt=sympy.sqrt, arctan=sympy.atan,
        arctan2=sympy.atan2, where=where, logical_or=logical_or, floor=whole,
    )  # fmt: skip
