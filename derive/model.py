"""What derivation hands to the emitters: named steps, and systems of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import sympy as sp
from sympy import Expr

from .quantity import OpenVector, Quantity, Vector, refuse_name

Input = Vector | OpenVector | Quantity


@dataclass(frozen=True)
class RuntimeFunction:
    """A function that is composed at run time: the names of what it takes and gives.

    ``kind`` says in the plural what it is one of: "contact functions of pitch curves".
    """

    name: str
    kind: str
    takes: tuple[str, ...]
    gives: tuple[str, ...]


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
    function: RuntimeFunction
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

    ``order`` is the order of the first derivative in the lane's angle that jumps there in the forces.
    """

    name: str
    argument: Expr
    target: Expr
    order: int
    period: Expr | None = None


Twin = Callable[[Quantity], Quantity]


@dataclass(frozen=True)
class Shared:
    """What equal sides share: ``totals`` from the outputs of both, where ``twin`` names a quantity on side 2."""

    twin: Twin
    steps: tuple[Let, ...]
    totals: Vector


@dataclass(frozen=True)
class Lane:
    """``outputs`` along ``angle`` from packed inputs by named steps; those of one side, if the machine has equal ones.

    Raises ValueError where a step needs what nothing gives.
    """

    angle: Quantity
    inputs: tuple[Vector | OpenVector, ...]
    steps: tuple[Step, ...]
    outputs: Vector
    events: tuple[Event, ...] = ()
    shared: Shared | None = None

    def __post_init__(self) -> None:
        given = _entries((self.angle, *self.inputs))
        known = _followed("lane", self.steps, given)
        _refuse_missing("lane: its outputs need", frozenset(self.outputs) - known)
        for event in self.events:
            _refuse_missing(f"lane: {event.name} needs", event.argument.free_symbols - known)
        if self.shared:
            twins = frozenset(map(self.shared.twin, self.outputs))
            known = _followed("frame", self.shared.steps, given.union(self.outputs, twins))
            _refuse_missing("frame: its totals need", frozenset(self.shared.totals) - known)

    @property
    def functions(self) -> tuple[RuntimeFunction, ...]:
        """What is composed at run time, in the order of the first call."""
        return tuple(dict.fromkeys(step.function for step in self.steps if isinstance(step, Call)))

    @property
    def vectors(self) -> tuple[Vector | OpenVector, ...]:
        """What it takes and gives."""
        return (*self.inputs, self.outputs, *((self.shared.totals,) if self.shared else ()))


@dataclass(frozen=True)
class ClosedForm:
    """A function on its own: ``outputs`` from packed or single inputs by named steps.

    Raises ValueError where a step needs what nothing gives.
    """

    name: str
    inputs: tuple[Vector | Quantity, ...]
    steps: tuple[Let, ...]
    outputs: Vector

    def __post_init__(self) -> None:
        refuse_name("function", self.name)
        known = _followed(self.name, self.steps, _entries(self.inputs))
        _refuse_missing(f"{self.name}: its outputs need", frozenset(self.outputs) - known)


@dataclass(frozen=True)
class System:
    """A model of a machine: a lane along its angle, functions in closed form, or both."""

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    lane: Lane | None = None
    closed_forms: tuple[ClosedForm, ...] = ()

    def __post_init__(self) -> None:
        refuse_name("system", self.name)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """What its functions take, each once, in the order in which it is first taken."""
        lane: tuple[Input, ...] = (self.lane.angle, *self.lane.inputs) if self.lane else ()
        return tuple(dict.fromkeys((*lane, *(given for form in self.closed_forms for given in form.inputs))))

    @property
    def functions(self) -> tuple[RuntimeFunction, ...]:
        """What is composed at run time."""
        return self.lane.functions if self.lane else ()

    @property
    def vectors(self) -> tuple[Vector | OpenVector, ...]:
        """Packed inputs and outputs."""
        packed = (v for form in self.closed_forms for v in (*form.inputs, form.outputs) if isinstance(v, Vector))
        return (*(self.lane.vectors if self.lane else ()), *packed)

    @property
    def steps(self) -> tuple[Step, ...]:
        """Every step: of the lane, of what its sides share, of the closed forms."""
        lane = self.lane.steps if self.lane else ()
        shared = self.lane.shared.steps if self.lane and self.lane.shared else ()
        return (*lane, *shared, *(step for form in self.closed_forms for step in form.steps))


S = TypeVar("S", bound=Step)


def needed(steps: Sequence[S], wanted: frozenset[sp.Symbol]) -> tuple[S, ...]:
    """The steps that ``wanted`` depends on, in their order."""
    kept: list[S] = []
    for step in reversed(steps):
        if wanted & set(step.defines):
            kept.append(step)
            wanted = wanted | step.needs
    return tuple(reversed(kept))


def entries(given: Input) -> tuple[Quantity, ...]:
    """The quantities that an input is known to hold."""
    if isinstance(given, Quantity):
        return (given,)
    return tuple(given.known.values()) if isinstance(given, OpenVector) else given.quantities


def _entries(inputs: Iterable[Input]) -> frozenset[sp.Symbol]:
    return frozenset(quantity for given in inputs for quantity in entries(given))


def _followed(name: str, steps: Iterable[Step], known: frozenset[sp.Symbol]) -> frozenset[sp.Symbol]:
    """What is known after the steps of a function."""
    for step in steps:
        _refuse_missing(f"{name}: {', '.join(map(str, step.defines))} needs", step.needs - known)
        known = known.union(step.defines)
    return known


def _refuse_missing(what: str, missing: frozenset[sp.Symbol]) -> None:
    if missing:
        raise ValueError(f"{what} {', '.join(sorted(map(str, missing)))}, which nothing gives")
