"""Models that derivation passes to the emitters: named steps, systems of them, and gears that
mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import sympy as sp
from sympy import Expr

from .kinks import CornerSearch
from .kinks import Event as Event
from .quantity import Datum, OpenVector, Quantity, Vector, refuse_name, word

Input = Vector | OpenVector | Quantity


@dataclass(frozen=True)
class RuntimeFunction:
    """A function that is composed at run time: the names of what it takes and gives.

    ``kind`` says in the plural what it is one of: "contact functions of pitch curves". What it
    gives is by its meaning ``positive`` or may have any sign.
    """

    name: str
    kind: str
    takes: tuple[str, ...]
    gives: tuple[str, ...]
    positive: tuple[str, ...] = ()


@dataclass(frozen=True)
class Let:
    """``symbol = expr``."""

    symbol: Quantity
    expr: Expr
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return (self.symbol,)

    @cached_property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset(self.expr.free_symbols)


COMMON = "common subexpression"
"""Source of a step that needs no note in a text: of what others share, or of what continues the step
before.
"""


def let(symbol: Quantity, expr: Expr, reason: str = "") -> Let:
    """A derived step; the reason is what its symbol means unless told."""
    return Let(symbol, sp.sympify(expr), f"derived: {reason or symbol.meaning}")


def let_all(
    symbols: Iterable[Quantity], exprs: Iterable[Expr], reason: str = ""
) -> tuple[Let, ...]:
    """Return the derived steps that name expressions, one symbol each."""
    return tuple(let(symbol, expr, reason) for symbol, expr in zip(symbols, exprs, strict=True))


@dataclass(frozen=True)
class Call:
    """``outputs = function(argument, *vectors)``: a function composed at run time; None for an
    output nobody needs.
    """

    outputs: tuple[Quantity | None, ...]
    function: RuntimeFunction
    argument: Expr
    vectors: tuple[OpenVector, ...]
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return tuple(o for o in self.outputs if o is not None)

    @property
    def positive(self) -> tuple[Quantity, ...]:
        """List the outputs that are positive by their meaning."""
        named = zip(self.function.gives, self.outputs, strict=True)
        return tuple(o for name, o in named if o is not None and name in self.function.positive)

    @cached_property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset(self.argument.free_symbols)


@dataclass(frozen=True)
class SineSeries:
    """``symbol = sum over k of b_k sin(k argument) / k``; b_k is entry k of ``coefficients``."""

    symbol: Quantity
    argument: Quantity
    coefficients: OpenVector
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return (self.symbol,)

    @cached_property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset({self.argument})


@dataclass(frozen=True)
class LinearSolve:
    """``matrix symbols = right``: simultaneous equations, solved where the function runs.

    ``pivot`` is the least pivot over the largest entry of its column: zero where the equations
    determine nothing.
    """

    symbols: tuple[Quantity, ...]
    pivot: Quantity
    matrix: tuple[tuple[Expr, ...], ...]
    right: tuple[Expr, ...]
    source: str

    @property
    def defines(self) -> tuple[Quantity, ...]:
        return (*self.symbols, self.pivot)

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Rows of the matrix one after the other, then the right-hand side."""
        return (*(entry for row in self.matrix for entry in row), *self.right)

    @cached_property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset().union(*(entry.free_symbols for entry in self.entries))

    def filled(self, entries: Sequence[Expr]) -> LinearSolve:
        """Return a copy with other entries."""
        n = len(self.symbols)
        rows = tuple(tuple(entries[n * i : n * (i + 1)]) for i in range(n))
        return replace(self, matrix=rows, right=tuple(entries[n * n :]))


Step = Let | Call | SineSeries | LinearSolve


def list_expressions(step: Step) -> tuple[Expr, ...]:
    """Return the expressions that a step evaluates."""
    if isinstance(step, LinearSolve):
        return step.entries
    return (step.expr if isinstance(step, Let) else step.argument,)


Twin = Callable[[Quantity], Quantity]


@dataclass(frozen=True)
class Shared:
    """Part that equal sides share: ``totals`` from the outputs of both, where ``twin`` names a
    quantity on side 2.
    """

    twin: Twin
    steps: tuple[Let, ...]
    totals: Vector


@dataclass(frozen=True)
class Lane:
    """``outputs`` along ``angle`` from packed inputs by named steps; those of one side, if the
    machine has equal ones.

    ``along`` are packed inputs that change with the angle, ``speed`` is that of the angle if it is
    constant. After the ``events`` that are stated stand those of all steps (`kinks`). Raises
    ValueError where a step needs what nothing gives, or what both sides add up to is not smooth.
    """

    angle: Quantity
    inputs: tuple[Vector | OpenVector, ...]
    steps: tuple[Step, ...]
    outputs: Vector
    events: tuple[Event, ...] = ()
    shared: Shared | None = None
    along: tuple[Vector, ...] = ()
    speed: Quantity | None = None

    def __post_init__(self) -> None:
        given_symbols = _entries((self.angle, *self.inputs, *self.along))
        available = _followed("lane", self.steps, given_symbols)
        _refuse_missing("lane: its outputs need", frozenset(self.outputs) - available)
        moving = frozenset({self.angle}.union(*self.along))
        object.__setattr__(self, "events", list_kinks(self.steps, moving, self.events))
        for event in self.events:
            _refuse_missing(f"lane: {event.name} needs", event.argument.free_symbols - available)
        if self.shared:
            twins = frozenset(map(self.shared.twin, self.outputs))
            if kinks := list_kinks(self.shared.steps, frozenset(self.outputs) | twins):
                raise ValueError(
                    f"frame: {kinks[0].name}, of both sides together, has no event; name it on a "
                    f"side"
                )
            available = _followed(
                "frame", self.shared.steps, given_symbols.union(self.outputs, twins)
            )
            _refuse_missing("frame: its totals need", frozenset(self.shared.totals) - available)

    @property
    def functions(self) -> tuple[RuntimeFunction, ...]:
        """List the functions that are composed at run time, in the order of the first call."""
        return tuple(dict.fromkeys(step.function for step in self.steps if isinstance(step, Call)))

    @property
    def vectors(self) -> tuple[Vector | OpenVector, ...]:
        """Return the packed inputs and outputs."""
        return (
            *self.inputs,
            *self.along,
            self.outputs,
            *((self.shared.totals,) if self.shared else ()),
        )


@dataclass(frozen=True)
class ClosedForm:
    """A function on its own: ``outputs`` from packed or single inputs by named steps.

    Raises ValueError where a step needs what nothing gives.
    """

    name: str
    inputs: tuple[Vector | Quantity, ...]
    steps: tuple[Step, ...]
    outputs: Vector

    def __post_init__(self) -> None:
        refuse_name("function", self.name)
        available = _followed(self.name, self.steps, _entries(self.inputs))
        _refuse_missing(f"{self.name}: its outputs need", frozenset(self.outputs) - available)


@dataclass(frozen=True)
class Effects:
    """Proven lack of effect on a lane's output: inputs ``without`` any; of composed functions,
    outputs ``felt``.
    """

    without: tuple[str, ...]
    felt: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class System:
    """A model of a machine: a lane along its angle, functions in closed form, or both.

    ``data`` are the values that its statement gives of quantities, by name; ``pushing`` are names
    of forces of contacts that cannot pull; ``axes`` name the frames by which components of joints'
    actions are given, if not the world's; ``meshes`` are names of gears that mesh, by the tag of
    their mesh; ``supports`` those of the forces of the ground on bodies, by body and axis.
    ``loads`` are texts of the loads on bodies, in the order of the function ``loads``.
    ``elements`` are kinds and bodies of what is drawn between these, by name. ``open_inputs`` are quantities
    of the data that change while free motion goes on, with their bounds. ``begun`` are coordinates
    and rates that the statement starts free motion with, ``held_entries`` those of them that hold,
    None if it does not say so. ``added_inertia`` names actions that depend on accelerations.
    """

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    lane: Lane | None = None
    closed_forms: tuple[ClosedForm, ...] = ()
    data: Mapping[str, Datum] = field(default_factory=dict)
    effects: Effects | None = None
    pushing: tuple[str, ...] = ()
    axes: Mapping[str, str] = field(default_factory=dict)
    meshes: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    supports: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    loads: tuple[Mapping[str, str | bool], ...] = ()
    elements: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    open_inputs: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)
    begun: tuple[str, ...] = ()
    held_entries: tuple[str, ...] | None = None
    added_inertia: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        refuse_name("system", self.name)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """List the inputs of the functions, each once, in the order of first use."""
        lane: tuple[Input, ...] = (
            (self.lane.angle, *self.lane.inputs, *self.lane.along) if self.lane else ()
        )
        return tuple(
            dict.fromkeys(
                (*lane, *(input_ for form in self.closed_forms for input_ in form.inputs))
            )
        )

    @property
    def functions(self) -> tuple[RuntimeFunction, ...]:
        """List the functions that are composed at run time, in the order of the first call."""
        return self.lane.functions if self.lane else ()

    @property
    def vectors(self) -> tuple[Vector | OpenVector, ...]:
        """Packed inputs and outputs."""
        packed = (
            v
            for form in self.closed_forms
            for v in (*form.inputs, form.outputs)
            if isinstance(v, Vector)
        )
        return (*(self.lane.vectors if self.lane else ()), *packed)

    @property
    def steps(self) -> tuple[Step, ...]:
        """Every step: of the lane, of what its sides share, of the closed forms."""
        lane = self.lane.steps if self.lane else ()
        shared = self.lane.shared.steps if self.lane and self.lane.shared else ()
        return (*lane, *shared, *(step for form in self.closed_forms for step in form.steps))


def sorted_steps(steps: Iterable[Step]) -> tuple[Step, ...]:
    """Steps in an order in which each needs only what stands before it; they keep theirs where they
    can.

    Raises ValueError where steps need each other in a circle.
    """
    left = list(steps)
    ordered_steps: list[Step] = []
    while left:
        ahead = frozenset(symbol for step in left for symbol in step.defines)
        waiting: list[Step] = []
        for step in left:
            (ordered_steps if step.needs.isdisjoint(ahead) else waiting).append(step)
        if len(waiting) == len(left):
            raise ValueError(f"{', '.join(sorted(map(str, ahead)))} need each other")
        left = waiting
    return tuple(ordered_steps)


S = TypeVar("S", bound=Step)


def needed(steps: Sequence[S], symbols: frozenset[sp.Symbol]) -> tuple[S, ...]:
    """The steps that ``symbols`` depends on, in their order."""
    needed_steps: list[S] = []
    open_symbols = set(symbols)
    for step in reversed(steps):
        if not open_symbols.isdisjoint(step.defines):
            needed_steps.append(step)
            open_symbols |= step.needs
    return tuple(reversed(needed_steps))


def split_steps(
    steps: Sequence[Step], moving: frozenset[sp.Symbol]
) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Steps that do not depend on ``moving``, and those that do."""
    still: list[Step] = []
    lane: list[Step] = []
    for step in steps:
        if step.needs & moving:
            moving = moving | set(step.defines)
            lane.append(step)
        else:
            still.append(step)
    return tuple(still), tuple(lane)


def list_passing_events(
    steps: Sequence[Step], events: Iterable[Event], moving: frozenset[sp.Symbol]
) -> tuple[Event, ...]:
    """The events that can happen: those whose argument depends on ``moving``.

    Under constant load the teeth of round gears never change their flank.
    """
    symbols = moving.union(*(step.defines for step in split_steps(steps, moving)[1]))
    return tuple(event for event in events if event.argument.free_symbols & symbols)


def list_kinks(
    steps: Sequence[Step],
    moving: frozenset[sp.Symbol],
    stated: Iterable[Event] = (),
    further: Iterable[tuple[str, Iterable[Expr]]] = (),
) -> tuple[Event, ...]:
    """Return the events that are stated, then all others of the steps, and of ``further``
    expressions under a name.
    """
    changing = split_steps(steps, moving)[1]
    symbols = moving.union(*(step.defines for step in changing))
    definitions = {step.symbol: step.expr for step in steps if isinstance(step, Let)}
    positive = [symbol for step in steps if isinstance(step, Call) for symbol in step.positive]
    named = [
        (", ".join(symbol.name for symbol in step.defines), list_expressions(step))
        for step in changing
    ]
    return CornerSearch(symbols, definitions, positive).list_events([*named, *further], stated)


def join_entries(packed: Input) -> tuple[Quantity, ...]:
    """The quantities that an input is known to hold."""
    if isinstance(packed, Quantity):
        return (packed,)
    return tuple(packed.known.values()) if isinstance(packed, OpenVector) else packed.quantities


def _entries(inputs: Iterable[Input]) -> frozenset[sp.Symbol]:
    return frozenset(quantity for input_ in inputs for quantity in join_entries(input_))


def _followed(
    name: str, steps: Iterable[Step], available: frozenset[sp.Symbol]
) -> frozenset[sp.Symbol]:
    """Return the symbols that are known after the steps of a function."""
    for step in steps:
        _refuse_missing(
            f"{name}: {', '.join(map(str, step.defines))} needs", step.needs - available
        )
        available = available.union(step.defines)
    return available


def _refuse_missing(place: str, missing: frozenset[sp.Symbol]) -> None:
    if missing:
        raise ValueError(f"{place} {', '.join(sorted(map(str, missing)))}, which nothing gives")


ELEMENTS, MESHES, PLACES = "elements", "meshes", "places"
"""The functions of all meshes of a statement, and of where the points of its bodies are."""
Packed = Vector | Quantity


@dataclass(frozen=True)
class Mesh:
    """Two gears that touch on their line of centres.

    ``line`` [rad] is the direction from the inner gear's centre to the outer's, which is at
    ``centre`` [m]. ``polar`` [rad] are the directions of the pitch point in the frames of both
    gears, ``radii`` [m] its distances from their centres, inner gear first.
    """

    tag: str
    gears: tuple[str, str]
    line: Expr
    centre: tuple[Expr, Expr]
    polar: tuple[Expr, Expr]
    radii: tuple[Expr, Expr]

    def lets(self) -> list[Let]:
        """Return ``mesh_TAG_x``, ``_y``, ``_line``, and of each gear ``_polar_1`` and ``_r_1``."""
        outer = self.gears[1]
        entries_by_name = {
            "x": (self.centre[0], "m", f"centre of {outer}, x"),
            "y": (self.centre[1], "m", f"centre of {outer}, y"),
            "line": (
                self.line,
                "rad",
                f"direction from the centre of {self.gears[0]} to that of {outer}",
            ),
        }
        for number, gear, polar, radius in zip(
            (1, 2), self.gears, self.polar, self.radii, strict=True
        ):
            entries_by_name[f"polar_{number}"] = (
                polar,
                "rad",
                f"direction of the pitch point in the frame of {gear}",
            )
            entries_by_name[f"r_{number}"] = radius, "m", f"pitch radius of {gear}"
        return [
            let(Quantity(f"mesh_{self.tag}_{name}", unit, meaning, "own"), sp.sympify(expr))
            for name, (expr, unit, meaning) in entries_by_name.items()
        ]

    def places(self) -> list[Let]:
        """Return ``x_GEAR__POINT`` and its like [m] of both centres, of the pitch point, and of a
        mark on each gear.
        """
        direction = sp.cos(self.line), sp.sin(self.line)
        distance = self.radii[0] + self.radii[1]
        inner = tuple(c - distance * a for c, a in zip(self.centre, direction, strict=True))
        pitch = tuple(c + self.radii[0] * a for c, a in zip(inner, direction, strict=True))
        places: list[Let] = []
        turns = self.line - self.polar[0], self.line + sp.pi - self.polar[1]
        for gear, centre, turn, radius in zip(
            self.gears, (inner, self.centre), turns, self.radii, strict=True
        ):
            mark = centre[0] + radius * sp.cos(turn), centre[1] + radius * sp.sin(turn)
            for point, position in (("centre", centre), ("pitch_point", pitch), ("mark", mark)):
                for axis, coordinate in zip("xy", position, strict=True):
                    meaning = f"{point.replace('_', ' ')} of {gear}, {axis}"
                    places.append(
                        let(
                            Quantity(f"{axis}_{word(gear)}__{point}", "m", meaning, "own"),
                            sp.sympify(coordinate),
                        )
                    )
        return places


def build_function(
    name: str, lets: Iterable[Let], inputs: Sequence[Packed], before: Sequence[Step]
) -> tuple[ClosedForm, ...]:
    """Return the function of some steps from what a lane takes; nothing where there is none.

    ``before`` are steps that they may need.
    """
    steps = list(lets)
    if not steps:
        return ()
    outputs = Vector(name, tuple(step.symbol for step in steps))
    return (
        ClosedForm(
            name,
            tuple(inputs),
            sorted_steps(needed((*before, *steps), frozenset(outputs))),
            outputs,
        ),
    )
