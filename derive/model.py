"""What derivation hands to the emitters: named steps, stages and systems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import sympy as sp
from sympy import Expr

from .quantity import OpenVector, Quantity, Vector


@dataclass(frozen=True)
class Let:
    """``symbol = expr``."""

    symbol: Quantity
    expr: Expr
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return (self.symbol,)

    @property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset(self.expr.free_symbols)


@dataclass(frozen=True)
class Call:
    """``outputs = function(argument, *vectors)``: a function composed at run time; None for an output nobody needs."""

    outputs: tuple[Quantity | None, ...]
    function: str
    argument: Expr
    vectors: tuple[OpenVector, ...]
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return tuple(o for o in self.outputs if o is not None)

    @property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset(self.argument.free_symbols)


@dataclass(frozen=True)
class SineSeries:
    """``symbol = argument + sum over k of b_k sin(k argument) / k``; b_k is entry k of ``coefficients``."""

    symbol: Quantity
    argument: Quantity
    coefficients: OpenVector
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return (self.symbol,)

    @property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset({self.argument})


Step = Let | Call | SineSeries


@dataclass(frozen=True)
class Event:
    """A joint in a lane: where ``argument - target`` is a whole multiple of ``period`` (or zero, without one).

    ``order`` is the order of the first derivative in the carrier angle that jumps there in the forces.
    """

    name: str
    argument: Expr
    target: Expr
    order: int
    period: Expr | None = None


Twin = Callable[[Quantity], Quantity]


@dataclass(frozen=True)
class System:
    """A model of a machine with equal sides: the steps of one side along ``angle``, and balances of what they share.

    ``lane`` gives ``side`` (the quantities of one side); ``frame`` gives ``totals`` from those of both sides, where
    ``twin`` names a quantity on side 2. ``callables`` are the functions that are composed at run time.
    """

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    angle: Quantity
    inputs: tuple[Vector | OpenVector, ...]
    callables: tuple[str, ...]
    lane: tuple[Step, ...]
    side: Vector
    frame: tuple[Let, ...]
    totals: Vector
    twin: Twin
    events: tuple[Event, ...]


@dataclass(frozen=True)
class Stage:
    """A function on its own: ``outputs`` from packed or single inputs by named steps."""

    name: str
    inputs: tuple[Vector | Quantity, ...]
    steps: tuple[Let, ...]
    outputs: Vector

    def __post_init__(self) -> None:
        known: set[sp.Symbol] = {s for given in self.inputs for s in (given if isinstance(given, Vector) else (given,))}
        for step in self.steps:
            if not step.needs <= known:
                missing = ", ".join(sorted(map(str, step.needs - known)))
                raise ValueError(f"stage {self.name}: {step.symbol} needs {missing}, which nothing gives")
            known.add(step.symbol)


@dataclass(frozen=True)
class Formulas:
    """A model of a machine as functions in closed form, each on its own."""

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    stages: tuple[Stage, ...]

    @property
    def callables(self) -> tuple[str, ...]:
        """Nothing is composed at run time."""
        return ()

    @property
    def inputs(self) -> tuple[Vector | Quantity, ...]:
        """What the stages take, each once, in the order in which it is first taken."""
        return tuple(dict.fromkeys(given for stage in self.stages for given in stage.inputs))


S = TypeVar("S", bound=Step)


def needed(steps: Sequence[S], wanted: frozenset[sp.Symbol]) -> tuple[S, ...]:
    """The steps that ``wanted`` depends on, in their order."""
    kept: list[S] = []
    for step in reversed(steps):
        if wanted & set(step.defines):
            kept.append(step)
            wanted = wanted | step.needs
    return tuple(reversed(kept))
