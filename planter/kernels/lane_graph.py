"""A CasADi function as single assignments, each marked as the same in all lanes or different in
every lane.

The instructions of an SXFunction use numbered work elements again and again; here every value has
its own name, and values that occur twice are computed once. `OPERATIONS` has the scalar operations
as C text; truth values are 1.0 and 0.0, as in CasADi. A select prints as `c != 0.0 ? a : 0.0`,
never as `c * a`: 0 times an infinity would be NaN. Logic is arithmetic of ones and zeros, because
compilers turn chains of selects between truth values into masks that they cannot vectorise.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class ScalarOperation:
    """A C expression with its arguments, names or constants, as {0}, {1}.

    `truth`: its value is 1.0 or 0.0; `logical`: so must its arguments be.
    """

    text: str
    arguments: int
    truth: bool = False
    logical: bool = False


def _call_operation(name: str, arguments: int = 1) -> ScalarOperation:
    return ScalarOperation(f"{name}({', '.join(f'{{{i}}}' for i in range(arguments))})", arguments)


def _compare_operation(sign: str) -> ScalarOperation:
    return ScalarOperation(f"{{0}} {sign} {{1}} ? 1.0 : 0.0", 2, truth=True)


def _logical_operation(text: str, arguments: int) -> ScalarOperation:
    return ScalarOperation(text, arguments, truth=True, logical=True)


OPERATIONS: dict[int, ScalarOperation] = {
    ca.OP_ADD: ScalarOperation("{0} + {1}", 2),
    ca.OP_SUB: ScalarOperation("{0} - {1}", 2),
    ca.OP_MUL: ScalarOperation("{0} * {1}", 2),
    ca.OP_DIV: ScalarOperation("{0} / {1}", 2),
    ca.OP_NEG: ScalarOperation("-{0}", 1),
    ca.OP_INV: ScalarOperation("1.0 / {0}", 1),
    ca.OP_SQ: ScalarOperation("{0} * {0}", 1),
    ca.OP_TWICE: ScalarOperation("2.0 * {0}", 1),
    ca.OP_SIGN: ScalarOperation("({0} > 0.0 ? 1.0 : 0.0) - ({0} < 0.0 ? 1.0 : 0.0)", 1),
    ca.OP_LT: _compare_operation("<"),
    ca.OP_LE: _compare_operation("<="),
    ca.OP_EQ: _compare_operation("=="),
    ca.OP_NE: _compare_operation("!="),
    ca.OP_NOT: _logical_operation("1.0 - {0}", 1),
    ca.OP_AND: _logical_operation("{0} * {1}", 2),
    ca.OP_OR: _logical_operation("{0} + {1} - {0} * {1}", 2),
    ca.OP_IF_ELSE_ZERO: ScalarOperation("{0} != 0.0 ? {1} : 0.0", 2),
    ca.OP_SIN: _call_operation("turned_sin"),
    ca.OP_COS: _call_operation("turned_cos"),
    ca.OP_SQRT: _call_operation("sqrt"),
    ca.OP_FABS: _call_operation("fabs"),
    ca.OP_FLOOR: _call_operation("whole_floor"),
    ca.OP_CEIL: _call_operation("ceil"),
    ca.OP_FMIN: _call_operation("fmin", 2),
    ca.OP_FMAX: _call_operation("fmax", 2),
    ca.OP_COPYSIGN: _call_operation("copysign", 2),
    ca.OP_EXP: _call_operation("exp"),
    ca.OP_LOG: _call_operation("log"),
    ca.OP_POW: _call_operation("pow", 2),
    ca.OP_CONSTPOW: _call_operation("pow", 2),
    ca.OP_TAN: _call_operation("tan"),
    ca.OP_ASIN: _call_operation("asin"),
    ca.OP_ACOS: _call_operation("acos"),
    ca.OP_ATAN: _call_operation("atan"),
    ca.OP_ATAN2: _call_operation("atan2", 2),
    ca.OP_SINH: _call_operation("sinh"),
    ca.OP_COSH: _call_operation("cosh"),
    ca.OP_TANH: _call_operation("tanh"),
    ca.OP_ASINH: _call_operation("asinh"),
    ca.OP_ACOSH: _call_operation("acosh"),
    ca.OP_ATANH: _call_operation("atanh"),
    ca.OP_LOG1P: _call_operation("log1p"),
    ca.OP_EXPM1: _call_operation("expm1"),
    ca.OP_HYPOT: _call_operation("hypot", 2),
    ca.OP_ERF: _call_operation("erf"),
    ca.OP_FMOD: _call_operation("fmod", 2),
}
"""What can be printed, by CasADi's number of the operation."""


RESERVED = re.compile(r"[st]\d+|a\d+|i|lanes")
"""Names that the emitted loop uses itself."""


class NotPrintableError(ValueError):
    """A function that cannot be a lane kernel; the message says why."""


@dataclass(frozen=True)
class ArrayElement:
    """An element of an input or output."""

    name: str
    index: int
    scalar: bool


@dataclass(frozen=True)
class Assignment:
    """A named value: an element of an input, or an operation on other values (names or constants as
    text).
    """

    name: str
    varies: bool
    source: ArrayElement | ScalarOperation
    arguments: tuple[str, ...] = ()


@dataclass(frozen=True)
class OutputStore:
    """A value, or a constant as text, that an output's element takes."""

    place: ArrayElement
    value: str


@dataclass(frozen=True)
class LaneGraph:
    """A function in single assignments: `lanes` are the inputs that have a column for each lane."""

    function: ca.Function
    lanes: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    stores: tuple[OutputStore, ...]

    @classmethod
    def from_function(
        cls, function: ca.Function, lanes: Sequence[str], limit: int | None = None
    ) -> LaneGraph:
        """The graph of a function; an MXFunction is expanded first.

        Raises NotPrintableError for a function that has no such form: a sparse input or output, a
        solver inside, a reserved name, more than `limit` instructions.
        """
        _check_printable(function, lanes)
        return _GraphBuilder(_expand_function(function, limit), lanes).graph()

    @property
    def invariant(self) -> list[Assignment]:
        return [a for a in self.assignments if not a.varies]

    @property
    def varying(self) -> list[Assignment]:
        return [a for a in self.assignments if a.varies]


def _check_printable(function: ca.Function, lanes: Sequence[str]) -> None:
    inputs, outputs = function.name_in(), function.name_out()
    for name in lanes:
        if name not in inputs:
            raise NotPrintableError(
                f"{function.name()} has no input {name}, which is to vary over the lanes"
            )
        if function.size2_in(name) != 1:
            raise NotPrintableError(
                f"{function.name()}: {name} varies over the lanes and must be a column"
            )
    for name in (*inputs, *outputs):
        if RESERVED.fullmatch(name):
            raise NotPrintableError(
                f"{function.name()}: the name {name} is used by the loop itself"
            )
    sparse = [n for i, n in enumerate(inputs) if not function.sparsity_in(i).is_dense()]
    sparse += [n for i, n in enumerate(outputs) if not function.sparsity_out(i).is_dense()]
    if sparse:
        raise NotPrintableError(f"{function.name()}: {', '.join(sparse)} must be dense")


def _expand_function(function: ca.Function, limit: int | None) -> ca.Function:
    """Return a function as at most `limit` scalar operations, with equal subexpressions computed
    once.
    """
    try:
        flat = function if function.is_a("SXFunction") else function.expand()
    except RuntimeError as error:
        raise NotPrintableError(f"{function.name()} has no scalar form") from error
    if limit is not None and flat.n_instructions() > limit:
        raise NotPrintableError(
            f"{function.name()} has {flat.n_instructions()} instructions, more than {limit}"
        )
    inputs = flat.sx_in()
    outputs = flat.call(inputs)
    return ca.Function(flat.name(), inputs, ca.cse(outputs), flat.name_in(), flat.name_out())


def _print_constant(value: float) -> str:
    if not math.isfinite(value):
        raise NotPrintableError(f"the constant {value} is not finite")
    return repr(value) if value >= 0 else f"({value!r})"


class _GraphBuilder:
    """One pass over the instructions: `self.places` holds the name of the value in each numbered
    place.
    """

    def __init__(self, function: ca.Function, lanes: Sequence[str]) -> None:
        self.function, self.lanes = function, tuple(lanes)
        self.inputs, self.outputs = function.name_in(), function.name_out()
        self.places: dict[int, str] = {}
        self.varies: dict[str, bool] = {}
        self.truths: set[str] = set()
        self.names: dict[tuple[object, tuple[str, ...]], str] = {}
        self.assignments: list[Assignment] = []
        self.stores: list[OutputStore] = []

    def graph(self) -> LaneGraph:
        for number in range(self.function.n_instructions()):
            self._instruction(number)
        return LaneGraph(self.function, self.lanes, tuple(self.assignments), tuple(self.stores))

    def _instruction(self, number: int) -> None:
        f = self.function
        code, taken, results = (
            f.instruction_id(number),
            f.instruction_input(number),
            f.instruction_output(number),
        )
        if code == ca.OP_CONST:
            self.places[results[0]] = _print_constant(f.instruction_constant(number))
        elif code == ca.OP_INPUT:
            name = self.inputs[taken[0]]
            place = ArrayElement(name, taken[1], f.numel_in(taken[0]) == 1)
            self.places[results[0]] = self._value(place, (), name in self.lanes)
        elif code == ca.OP_OUTPUT:
            place = ArrayElement(self.outputs[results[0]], results[1], f.numel_out(results[0]) == 1)
            self.stores.append(OutputStore(place, self.places[taken[0]]))
        elif code in OPERATIONS:
            operation = OPERATIONS[code]
            arguments = tuple(self.places[place] for place in taken[: operation.arguments])
            self.places[results[0]] = self._operation(operation, arguments)
        else:
            raise NotPrintableError(
                f"{f.name()}: instruction {number} (operation {code}) has no form in C"
            )

    def _operation(self, operation: ScalarOperation, arguments: tuple[str, ...]) -> str:
        if operation.logical:
            arguments = tuple(map(self._truth, arguments))
        return self._value(
            operation, arguments, any(self.varies.get(name, False) for name in arguments)
        )

    def _truth(self, name: str) -> str:
        return name if name in self.truths else self._operation(OPERATIONS[ca.OP_NE], (name, "0.0"))

    def _value(
        self, source: ArrayElement | ScalarOperation, arguments: tuple[str, ...], varies: bool
    ) -> str:
        if (source, arguments) not in self.names:
            name = f"{'t' if varies else 's'}{len(self.assignments)}"
            self.names[source, arguments] = name
            self.varies[name] = varies
            if isinstance(source, ScalarOperation) and source.truth:
                self.truths.add(name)
            self.assignments.append(Assignment(name, varies, source, arguments))
        return self.names[source, arguments]
