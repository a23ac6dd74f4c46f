"""A CasADi function as single assignments, each marked as the same in all lanes or different in every lane.

The instructions of an SXFunction work on numbered places that are used again and again; here every value has its own
name. Values that occur twice are computed once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from planter.kernels.loops.operations import OPERATIONS, Operation

RESERVED = re.compile(r"[st]\d+|a\d+|i|lanes")
"""Names that the emitted loop uses itself."""


class NotPrintable(ValueError):
    """A function that cannot be a lane kernel; the message says why."""


@dataclass(frozen=True)
class Place:
    """An element of an input or output."""

    name: str
    index: int
    scalar: bool


@dataclass(frozen=True)
class Assignment:
    """A named value: an element of an input, or an operation on other values (names or constants as text)."""

    name: str
    varies: bool
    source: Place | Operation
    arguments: tuple[str, ...] = ()


@dataclass(frozen=True)
class Store:
    """A value, or a constant as text, that an output's element takes."""

    place: Place
    value: str


@dataclass(frozen=True)
class Graph:
    """A function in single assignments: `lanes` are the inputs that have a column for each lane."""

    function: ca.Function
    lanes: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    stores: tuple[Store, ...]

    @classmethod
    def of(cls, function: ca.Function, lanes: Sequence[str], most: int | None = None) -> Graph:
        """The graph of a function; an MXFunction is expanded first.

        Raises NotPrintable for a function that has no such form: a sparse input or output, a solver inside, a
        reserved name, more than `most` instructions.
        """
        _check(function, lanes)
        return _Walk(_expanded(function, most), lanes).graph()

    @property
    def invariant(self) -> list[Assignment]:
        return [a for a in self.assignments if not a.varies]

    @property
    def varying(self) -> list[Assignment]:
        return [a for a in self.assignments if a.varies]


def _check(function: ca.Function, lanes: Sequence[str]) -> None:
    inputs, outputs = function.name_in(), function.name_out()
    for name in lanes:
        if name not in inputs:
            raise NotPrintable(f"{function.name()} has no input {name}, which is to vary over the lanes")
        if function.size2_in(name) != 1:
            raise NotPrintable(f"{function.name()}: {name} varies over the lanes and must be a column")
    for name in (*inputs, *outputs):
        if RESERVED.fullmatch(name):
            raise NotPrintable(f"{function.name()}: the name {name} is used by the loop itself")
    sparse = [n for i, n in enumerate(inputs) if not function.sparsity_in(i).is_dense()]
    sparse += [n for i, n in enumerate(outputs) if not function.sparsity_out(i).is_dense()]
    if sparse:
        raise NotPrintable(f"{function.name()}: {', '.join(sparse)} must be dense")


def _expanded(function: ca.Function, most: int | None) -> ca.Function:
    """The function as scalar operations, at most so many, with equal subexpressions once."""
    try:
        flat = function if function.is_a("SXFunction") else function.expand()
    except RuntimeError as error:
        raise NotPrintable(f"{function.name()} has no scalar form") from error
    if most is not None and flat.n_instructions() > most:
        raise NotPrintable(f"{function.name()} has {flat.n_instructions()} instructions, more than {most}")
    inputs = flat.sx_in()
    outputs = flat.call(inputs)
    return ca.Function(flat.name(), inputs, ca.cse(outputs), flat.name_in(), flat.name_out())


def _constant(value: float) -> str:
    if not math.isfinite(value):
        raise NotPrintable(f"the constant {value} is not finite")
    return repr(value) if value >= 0 else f"({value!r})"


class _Walk:
    """One pass over the instructions: `self.places` holds the name of the value in each numbered place."""

    def __init__(self, function: ca.Function, lanes: Sequence[str]) -> None:
        self.function, self.lanes = function, tuple(lanes)
        self.inputs, self.outputs = function.name_in(), function.name_out()
        self.places: dict[int, str] = {}
        self.varies: dict[str, bool] = {}
        self.truths: set[str] = set()
        self.known: dict[tuple[object, tuple[str, ...]], str] = {}
        self.assignments: list[Assignment] = []
        self.stores: list[Store] = []

    def graph(self) -> Graph:
        for number in range(self.function.n_instructions()):
            self._instruction(number)
        return Graph(self.function, self.lanes, tuple(self.assignments), tuple(self.stores))

    def _instruction(self, number: int) -> None:
        f = self.function
        code, taken, given = f.instruction_id(number), f.instruction_input(number), f.instruction_output(number)
        if code == ca.OP_CONST:
            self.places[given[0]] = _constant(f.instruction_constant(number))
        elif code == ca.OP_INPUT:
            name = self.inputs[taken[0]]
            place = Place(name, taken[1], f.numel_in(taken[0]) == 1)
            self.places[given[0]] = self._value(place, (), name in self.lanes)
        elif code == ca.OP_OUTPUT:
            place = Place(self.outputs[given[0]], given[1], f.numel_out(given[0]) == 1)
            self.stores.append(Store(place, self.places[taken[0]]))
        elif code in OPERATIONS:
            operation = OPERATIONS[code]
            arguments = tuple(self.places[place] for place in taken[: operation.arguments])
            self.places[given[0]] = self._operation(operation, arguments)
        else:
            raise NotPrintable(f"{f.name()}: instruction {number} (operation {code}) has no form in C")

    def _operation(self, operation: Operation, arguments: tuple[str, ...]) -> str:
        if operation.logical:
            arguments = tuple(map(self._truth, arguments))
        return self._value(operation, arguments, any(self.varies.get(name, False) for name in arguments))

    def _truth(self, name: str) -> str:
        return name if name in self.truths else self._operation(OPERATIONS[ca.OP_NE], (name, "0.0"))

    def _value(self, source: Place | Operation, arguments: tuple[str, ...], varies: bool) -> str:
        if (source, arguments) not in self.known:
            name = f"{'t' if varies else 's'}{len(self.assignments)}"
            self.known[source, arguments] = name
            self.varies[name] = varies
            if isinstance(source, Operation) and source.truth:
                self.truths.add(name)
            self.assignments.append(Assignment(name, varies, source, arguments))
        return self.known[source, arguments]
