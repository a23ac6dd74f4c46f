"""Steps of a chain made executable on arrays, in floating point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from sympy import Expr

from ..model import Let, LinearSolve, Step
from .laws import Array, Values


@dataclass(frozen=True)
class Formula:
    """An expression made executable on arrays; no number, or none that is finite, where it has none."""

    expr: Expr

    @cached_property
    def symbols(self) -> list[sp.Symbol]:
        return sorted(self.expr.free_symbols, key=str)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        return sp.lambdify(self.symbols, self.expr, modules="numpy", cse=True)

    def __call__(self, values: Mapping[sp.Symbol, Array]) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(self._function(*(values[s] for s in self.symbols)), dtype=float)


@dataclass(frozen=True)
class Programme:
    """Steps that give some unknowns, one after another or together."""

    steps: tuple[Step, ...]
    unknowns: tuple[sp.Symbol, ...]

    @cached_property
    def symbols(self) -> list[sp.Symbol]:
        """What must be known before."""
        own = {symbol for step in self.steps for symbol in step.defines}
        return sorted(set().union(*(step.needs for step in self.steps)) - own, key=str)

    @cached_property
    def _parts(self) -> list[tuple[Step, list[Formula]]]:
        return [(s, [Formula(e) for e in (s.entries if isinstance(s, LinearSolve) else _expr(s))]) for s in self.steps]

    def __call__(self, values: Mapping[sp.Symbol, Array]) -> Values:
        """The unknowns; no number where the equations determine none."""
        known = dict(values)
        for step, formulas in self._parts:
            found = [formula(known) for formula in formulas]
            known |= zip(step.defines, _solved(found) if isinstance(step, LinearSolve) else found, strict=False)
        return {symbol: known[symbol] for symbol in self.unknowns}


def _expr(step: Step) -> list[Expr]:
    assert isinstance(step, Let)
    return [step.expr]


def _solved(entries: Sequence[Array]) -> list[Array]:
    """Unknowns of simultaneous equations from the rows of their matrix and their right-hand sides."""
    count = int(np.sqrt(len(entries)))
    whole = np.stack(np.broadcast_arrays(*entries), axis=-1)
    matrix = whole[..., : count * count].reshape(*whole.shape[:-1], count, count)
    try:
        found = np.linalg.solve(matrix, whole[..., count * count :, None])[..., 0]
    except np.linalg.LinAlgError:
        found = np.full((*whole.shape[:-1], count), np.nan)
    return list(np.moveaxis(found, -1, 0))
