"""Lines of generated functions: unpacked inputs, steps, results."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass

import sympy as sp

from ..model import Call, SineSeries, Step
from ..quantity import OpenVector, Quantity, Vector
from .expression import ARRAY, Dialect, Printer
from .schedule import COMMON, operations_of

WIDTH = 114


@dataclass(frozen=True)
class Emitted:
    """A function ready to be written: what it takes and gives, and the steps between."""

    name: str
    inputs: tuple[Vector | OpenVector | Quantity, ...]
    steps: tuple[Step, ...]
    output: Vector
    results: tuple[sp.Expr, ...] = ()

    @property
    def operations(self) -> int:
        return operations_of(self.steps)

    @property
    def returned(self) -> tuple[sp.Expr, ...]:
        return self.results or self.output.quantities

    def body(self, dialect: Dialect) -> str:
        """Unpacked inputs and steps, indented."""
        used = frozenset().union(*(s.needs for s in self.steps), *(e.free_symbols for e in self.returned))
        lines = [line for vector in self.inputs for line in _unpacked(vector, used)]
        lines += [line for step in self.steps for line in _step(step, dialect)]
        return textwrap.indent("\n".join(lines), "    ")

    def names(self) -> str:
        return ", ".join(v.name for v in self.inputs)

    def packed(self, dialect: Dialect) -> str:
        """The results, a line each where there are many."""
        text = ", ".join(Printer(dialect)(e) for e in self.returned)
        lines = textwrap.wrap(text, WIDTH - 8, break_long_words=False)
        return textwrap.indent("\n".join(lines), "        ")


def _unpacked(vector: Vector | OpenVector | Quantity, used: frozenset[sp.Symbol]) -> list[str]:
    """Entries of a packed input that the steps use, each with its unit and meaning."""
    if isinstance(vector, Quantity):
        return []
    entries = vector.known.items() if isinstance(vector, OpenVector) else enumerate(vector)
    return [f"{q.name} = {vector.name}[{i}]" + _note(q) for i, q in entries if q in used]


def _note(quantity: sp.Symbol) -> str:
    return f"  # [{quantity.unit}] {quantity.meaning}" if isinstance(quantity, Quantity) else ""


def _step(step: Step, dialect: Dialect) -> list[str]:
    write = Printer(dialect)
    if isinstance(step, Call):
        names = ", ".join(o.name if o else "_" for o in step.outputs)
        first = ["xp"] if dialect is ARRAY else []
        arguments = ", ".join([*first, write(step.argument), *(v.name for v in step.vectors)])
        return [f"# {step.source}", *_wrapped(f"{names} = {step.function}({arguments})")]
    if isinstance(step, SineSeries):
        return _series(step, dialect)
    note = [] if step.source == COMMON else [f"# {step.source}"]
    return [*note, *_wrapped(f"{step.symbol.name} = {write(step.expr)}")]


def _series(step: SineSeries, dialect: Dialect) -> list[str]:
    """Clenshaw's recurrence."""
    u, b = step.argument.name, step.coefficients.name
    twice_cos, sin = f"2 * {dialect.call('cos', u)}", dialect.call("sin", u)
    return [
        f"# {step.source}: {u} + sum over k of {b}[k] sin(k {u}) / k, by Clenshaw's recurrence",
        f"twice_cos, last, before = {twice_cos}, 0, 0",
        f"for k in range({dialect.length.format(b)} - 1, 0, -1):",
        f"    last, before = {b}[k] / k + twice_cos * last - before, last",
        f"{step.symbol.name} = {u} + last * {sin}",
    ]


def _wrapped(text: str) -> list[str]:
    """A long assignment, broken inside brackets."""
    if len(text) <= WIDTH - 4:
        return [text]
    name, value = text.split(" = ", 1)
    inner = textwrap.wrap(value, WIDTH - 8, break_long_words=False, break_on_hyphens=False)
    return [f"{name} = (", *(f"    {line}" for line in inner), ")"]


def described(vectors: Iterable[Vector | OpenVector | Quantity]) -> str:
    """What packed inputs and outputs hold, for a docstring."""
    lines: list[str] = []
    for vector in vectors:
        if isinstance(vector, Vector):
            lines += [f"{vector.name} ({len(vector)})", *(f"    {_entry(q)}" for q in vector)]
        elif isinstance(vector, OpenVector):
            lines.append(f"{vector.name}: {vector.meaning}")
        else:
            lines.append(_entry(vector))
    return "\n".join(lines)


def _entry(symbol: sp.Symbol) -> str:
    return f"{symbol.name} [{symbol.unit}] {symbol.meaning}" if isinstance(symbol, Quantity) else symbol.name
