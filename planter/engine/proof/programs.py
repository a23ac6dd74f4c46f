"""Straight-line programs: generated array code recorded once, and run on jets in C, or by NumPy
without a compiler.

A recorded condition is asked once, however often the code repeats it. A program is data, which a
file can hold.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partialmethod
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from planter.engine.proof import intervals
from planter.engine.proof.check_proof import append_jacobian
from planter.engine.proof.intervals import PI, Ball, Branches, Unbounded
from planter.engine.proof.jets import ANYWHERE, Jet, Space, packed_size
from planter.engine.proof.roots import solve_linear_jets
from planter.kernels import Array, Flags, Integers, toolchain
from planter.kernels.compiler import CompilerError

CODES = (
    *("constant", "pi", "add", "negate", "multiply", "power", "inverse", "sqrt", "sin", "cos"),
    *("arctan", "exp", "log", "polynomial", "select", "arctan2", "floor", "below"),
    *("or", "and", "not", "input"),
)
"""Names of operations, in the order of their numbers in C, which has none for simultaneous
equations, "solve".
"""
CONDITIONS = ("below", "or", "and", "not")
LEAVES = ("constant", "pi", "input")
MOST_PARAMETERS, MOST_TERMS = 64, 64
"""Largest numbers of parameters of a jet and of terms of a polynomial in C."""


class UnrecordedError(Exception):
    """Code is not a straight line of operations."""


class RecordedStep(NamedTuple):
    """A step of a program: `arguments` are indices of earlier steps, `numbers` constants.

    Numbers are the constant, the exponent, the coefficients with the highest power first, the index
    of an input, or, of "below", whether zero is not below zero, and whether the result may jump
    where the answer changes. Arguments of "solve" are the rows of a square matrix and the right
    side; its numbers are the size, and the index of the unknown.
    """

    name: str
    arguments: tuple[int, ...] = ()
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class RecordedProgram:
    """Operations in order; `outputs` are the indices of the results.

    As a stage of a response it takes values of that response, by index, as `inputs`. Its values
    are its results or, where `limits` (k,) are given, roots of k unknowns, whose sizes are at most
    these. It then takes the unknowns first, and returns k residuals; `solver` also returns their
    Jacobian by rows, which is derived from the operations.
    """

    operations: tuple[RecordedStep, ...]
    outputs: tuple[int, ...]
    inputs: tuple[int, ...] = ()
    limits: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """The number of values that a stage adds."""
        return len(self.limits or self.outputs)

    @cached_property
    def solver(self) -> RecordedProgram:
        """The program with the Jacobian of its results in its first inputs, one for each limit."""
        steps, outputs = append_jacobian(self.operations, self.outputs, len(self.limits))
        return RecordedProgram(tuple(RecordedStep(*step) for step in steps), tuple(outputs))

    def to_document(self) -> dict[str, Any]:
        """Return the operations that outputs need as lists of name, arguments and numbers, these in
        hexadecimal.
        """
        places = {n: place for place, n in enumerate(self.order)}
        operations = []
        for name, arguments, numbers in (self.operations[n] for n in self.order):
            digits = [float(number).hex() for number in numbers]
            operations.append([name, [places[a] for a in arguments], digits])
        return {
            "operations": operations,
            "outputs": [places[n] for n in self.outputs],
            "inputs": self.inputs,
            "limits": [x.hex() for x in self.limits],
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> RecordedProgram:
        """Return the program of a document whose form was checked."""
        operations = tuple(
            RecordedStep(name, tuple(arguments), tuple(map(float.fromhex, numbers)))
            for name, arguments, numbers in document["operations"]
        )
        limits = tuple(map(float.fromhex, document["limits"]))
        return cls(operations, tuple(document["outputs"]), tuple(document["inputs"]), limits)

    @cached_property
    def order(self) -> tuple[int, ...]:
        """The operations that outputs need, each leaf just before its first use."""
        needed = set(self.outputs)
        for n in reversed(range(len(self.operations))):
            if n in needed:
                needed.update(self.operations[n].arguments)
        order: dict[int, None] = {}
        for n, step in enumerate(self.operations):
            if n in needed and step.name not in LEAVES:
                leaves = (a for a in step.arguments if self.operations[a].name in LEAVES)
                order.update(dict.fromkeys(leaves))
                order[n] = None
        return tuple({**order, **dict.fromkeys(self.outputs)})

    @cached_property
    def jumps(self) -> tuple[bool, ...]:
        """Whether the results may jump where the answer to each question changes, in the order of
        questions.
        """
        steps = [self.operations[n] for n in self.order]
        return tuple(
            step.name == "floor" or bool(step.numbers[1])
            for step in steps
            if step.name in ("floor", "below")
        )

    @cached_property
    def is_compiled(self) -> bool:
        """Whether C runs the program: there is a compiler, and an operation for each step."""
        if any(step.name == "solve" or len(step.numbers) > MOST_TERMS for step in self.operations):
            return False
        try:
            _load()
        except CompilerError:
            return False
        return True

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, list[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked; `script`
        has answers.
        """
        bounds = np.zeros((3, len(self.jumps), len(lanes)))
        if self.is_compiled:
            jets = self._run_in_c(space, inputs, lanes, script, bounds)
        else:
            part = space.taken(lanes)
            taken = [(jet if jet.lanes == 1 else jet.taken(lanes)).moved(part) for jet in inputs]
            jets = [jet.moved(space) for jet in _run_in_numpy(self, part, taken, script, bounds)]
        largest, smallest, answers = bounds
        return Branches(largest, smallest, answers, script, self.jumps), jets

    def enclose_smooth(self, space: Space, inputs: Sequence[Jet]) -> list[Jet]:
        """Return the results in all lanes.

        Raises Unbounded if a condition has several answers over the box.
        """
        count = max((jet.lanes for jet in inputs), default=1)
        branches, jets = self.enclose(space, inputs, np.arange(count), np.empty((0, count)))
        if branches.alternatives:
            raise Unbounded("a condition has several answers over a box")
        return jets

    def _run_in_c(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array, bounds: Array
    ) -> list[Jet]:
        size, count = len(space.half), len(lanes)
        key = (size, *(jet.support for jet in inputs))
        if key not in self._plans:
            self._plans[key] = _plan(self, [jet.support for jet in inputs], size)
        supports, program, _ = self._plans[key]
        half = space.half if space.half.shape[1] == 1 else space.half[:, lanes]
        sides = [jet.rows.mid for jet in inputs], [jet.rows.rad for jet in inputs]
        mids, rads = ([_take_lanes(side, lanes) for side in part] for part in sides)
        rows = [_count_rows(len(support)) for support in supports]
        results = [Ball(np.empty((row, count)), np.empty((row, count))) for row in rows]
        arrays = [
            np.ascontiguousarray(half),
            np.ascontiguousarray(script),
            *map(_point, (mids, rads, [b.mid for b in results], [b.rad for b in results])),
            *bounds,
            np.array([mid.shape[1] > 1 for mid in (*mids, half)], dtype=np.intp),
        ]
        numbers = count, len(script), space.is_cutting
        call = np.array([*(a.ctypes.data for a in arrays), *numbers], dtype=np.intp)
        rounding = np.array(
            [getattr(intervals, name) for name in ("U", "SLACK", "GROWTH", "TINY", "LIBM")]
            + [np.pi]
        )
        if _load()(program.ctypes.data, call.ctypes.data, rounding.ctypes.data):
            raise MemoryError
        return [Jet(space, *pair) for pair in zip(supports, results, strict=True)]

    @cached_property
    def _plans(self) -> dict[Any, tuple[Any, ...]]:
        return {}


class Recorder:
    """Array namespace `xp` of generated code that collects its operations; equal ones are one."""

    def __init__(self) -> None:
        self.operations: list[RecordedStep] = []
        self._indices: dict[RecordedStep, int] = {}

    def record(self, name: str, *values: Any, numbers: Sequence[float] = ()) -> RecordedValue:
        """Return the node of an operation, the earlier one if there is an equal one."""
        arguments = tuple(self.lift(value).index for value in values)
        step = RecordedStep(name, arguments, tuple(numbers))
        if step not in self._indices:
            self._indices[step] = len(self.operations)
            self.operations.append(step)
        return RecordedValue(self, self._indices[step])

    def lift(self, value: Any) -> RecordedValue:
        """Return a number as a node; a node is returned unchanged.

        Raises UnrecordedError for anything else.
        """
        if isinstance(value, RecordedValue):
            return value
        if np.ndim(value):
            raise UnrecordedError("an array is no single number")
        return self.record("constant", numbers=[float(value)])

    @property
    def pi(self) -> RecordedValue:
        return self.record("pi")

    sin = partialmethod(record, "sin")
    cos = partialmethod(record, "cos")
    sqrt = partialmethod(record, "sqrt")
    exp = partialmethod(record, "exp")
    log = partialmethod(record, "log")
    arctan = partialmethod(record, "arctan")
    arctan2 = partialmethod(record, "arctan2")
    floor = partialmethod(record, "floor")
    logical_or = partialmethod(record, "or")
    logical_and = partialmethod(record, "and")
    logical_not = partialmethod(record, "not")

    def where(self, condition: Any, yes: Any, no: Any) -> RecordedValue:
        """Return a selection by a condition."""
        if not isinstance(condition, RecordedValue):
            return self.lift(yes if condition else no)
        return self.record("select", yes, no, condition)

    def absolute(self, x: Any) -> RecordedValue:
        """Return the absolute value."""
        return self.where(self.lift(x).reaches(0), x, -x)

    def maximum(self, a: Any, b: Any) -> RecordedValue:
        """Return the larger of two quantities."""
        return self.where(self.lift(a).reaches(b), a, b)

    def minimum(self, a: Any, b: Any) -> RecordedValue:
        """Return the smaller of two quantities."""
        return self.where(self.lift(b).reaches(a), a, b)

    def sign(self, x: Any) -> RecordedValue:
        """Return the sign."""
        return self.where(x > 0, 1, self.where(x < 0, -1, 0))

    def divide(self, a: Any, b: Any) -> RecordedValue:
        """Return the quotient."""
        return self.lift(a) / b

    def tan(self, x: Any) -> RecordedValue:
        """Return the tangent."""
        return self.sin(x) / self.cos(x)

    def arcsin(self, x: Any) -> RecordedValue:
        """Return the arc sine."""
        return self.arctan(x / self.sqrt(1 - x**2))

    def arccos(self, x: Any) -> RecordedValue:
        """Return the arc cosine."""
        return self.arctan2(self.sqrt(1 - x**2), x)

    def polyval(self, coefficients: Sequence[float], x: Any) -> RecordedValue:
        """Return the sum of a_k x^k, with the highest power first."""
        return self.record("polynomial", x, numbers=[float(a) for a in coefficients])

    def solve(self, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[RecordedValue]:
        """Return the unknowns (k,) of simultaneous equations."""
        entries = [entry for row in (*matrix, right) for entry in row]
        size = len(right)
        return [self.record("solve", *entries, numbers=[size, k]) for k in range(size)]


@dataclass(frozen=True, eq=False)
class RecordedValue:
    """A quantity or a condition of recorded code, with the operations of `Jet`."""

    xp: Recorder
    index: int

    def __add__(self, other: Any) -> RecordedValue:
        return self.xp.record("add", self, other)

    def __neg__(self) -> RecordedValue:
        return self.xp.record("negate", self)

    def __sub__(self, other: Any) -> RecordedValue:
        return self + -self.xp.lift(other)

    def __rsub__(self, other: Any) -> RecordedValue:
        return -self + other

    def __mul__(self, other: Any) -> RecordedValue:
        return self.xp.record("multiply", self, other)

    def __truediv__(self, other: Any) -> RecordedValue:
        return self * self.xp.record("inverse", other)

    def __rtruediv__(self, other: Any) -> RecordedValue:
        return self.xp.record("inverse", self) * other

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, exponent: Any) -> RecordedValue:
        """Return a power: of a positive base alone if the exponent is no whole number."""
        if isinstance(exponent, RecordedValue) or exponent != int(exponent):
            return self.xp.exp(self.xp.log(self) * exponent)
        if exponent < 0:
            return (1 / self) ** -exponent
        return self.xp.record("power", self, numbers=[exponent]) if exponent else self.xp.lift(1.0)

    def __rpow__(self, base: Any) -> RecordedValue:
        return self.xp.lift(base) ** self

    def reaches(self, other: Any) -> RecordedValue:
        """Return whether this is at least another, for a choice that is continuous where they are
        equal.
        """
        return (other - self).ask(strictly=False, jumps=False)

    def ask(self, strictly: bool, jumps: bool = True) -> RecordedValue:
        """Return whether this is below zero, or at zero unless `strictly`."""
        return self.xp.record("below", self, numbers=[strictly, jumps])

    def __lt__(self, other: Any) -> RecordedValue:
        return (self - other).ask(strictly=True)

    def __le__(self, other: Any) -> RecordedValue:
        return (self - other).ask(strictly=False)

    def __gt__(self, other: Any) -> RecordedValue:
        return (-self + other).ask(strictly=True)

    def __ge__(self, other: Any) -> RecordedValue:
        return (-self + other).ask(strictly=False)


Code = Callable[[Any, Sequence[Any]], Sequence[Any]]
"""(xp, inputs) -> results, in the array namespace `xp`."""


def record_program(
    code: Code, count: int, inputs: Sequence[int] = (), limits: Sequence[float] = ()
) -> RecordedProgram:
    """Return the operations of code of `count` arguments, as a stage with inputs and limits.

    Raises UnrecordedError if they are no straight line.
    """
    recorder = Recorder()
    arguments = [recorder.record("input", numbers=[k]) for k in range(count)]
    results = list(code(recorder, arguments))[: len(limits) or None]
    outputs = tuple(recorder.lift(result).index for result in results)
    return RecordedProgram(tuple(recorder.operations), outputs, tuple(inputs), tuple(limits))


def _run_in_numpy(
    program: RecordedProgram, space: Space, inputs: Sequence[Jet], script: Array, bounds: Array
) -> list[Jet]:
    """Return the results of a program; `bounds` (3, q, lanes) becomes the largest and the smallest
    answer to each condition that its lanes allow, and the one that is taken.
    """
    values: dict[int, Any] = {}
    solutions: dict[tuple[int, ...], list[Jet]] = {}
    question = 0

    def answer(largest: Array, smallest: Array, usual: Array) -> Array:
        nonlocal question
        taken = np.where(largest != smallest, usual, smallest)
        if question < len(script):
            taken = np.where(np.isnan(script[question]), taken, script[question])
        for row, side in zip(bounds, (largest, smallest, taken), strict=True):
            row[question] = side
        question += 1
        return taken

    def below(x: Ball, strictly: float) -> Flags:
        # a ball without bounds leaves nothing open
        low, high = (x.low < 0, x.high < 0) if strictly else (x.low <= 0, x.high <= 0)
        ends = [np.where(side, 1.0, 0.0) for side in (low, high, x.mid < 0)]
        return np.asarray(answer(*ends) > 0)

    for n in program.order:
        name, places, numbers = program.operations[n]
        arguments = [values[a] for a in places]
        match name:
            case "constant":
                values[n] = space.lift(numbers[0])
            case "pi":
                values[n] = space.constant(PI)
            case "input":
                values[n] = inputs[int(numbers[0])]
            case "add":
                values[n] = arguments[0] + arguments[1]
            case "negate":
                values[n] = -arguments[0]
            case "multiply":
                values[n] = arguments[0] * arguments[1]
            case "power":
                values[n] = arguments[0] ** int(numbers[0])
            case "polynomial":
                values[n] = arguments[0].polynomial(numbers)
            case "select":
                values[n] = arguments[0].where(arguments[2], arguments[1])
            case "arctan2":
                values[n] = arguments[0].angle(arguments[1])
            case "floor":
                x = arguments[0].value[ANYWHERE]
                ends: Array = np.nan_to_num(np.floor([x.high, x.low, x.mid]))
                values[n] = space.lift(answer(*ends))
            case "below":
                values[n] = below(arguments[0].value[ANYWHERE], numbers[0])
            case "or" | "and" | "not":
                values[n] = getattr(np, f"logical_{name}")(*arguments)
            case "solve":
                size, k = map(int, numbers)
                if places not in solutions:
                    rows = [arguments[i : i + size] for i in range(0, len(arguments), size)]
                    solutions[places] = solve_linear_jets(space, rows[:-1], rows[-1])
                values[n] = solutions[places][k]
            case _:
                values[n] = arguments[0].call(name)
    return [values[n] for n in program.outputs]


FLAGS = ("-O3", "-ffp-contract=off")
"""A product and a sum must not become one operation with one rounding."""


@cache
def _load() -> Any:
    """Return the C function. Raises CompilerError."""
    text = resources.files(__package__).joinpath("programs.c").read_text(encoding="utf-8")
    (run,) = toolchain.load_functions(toolchain.build_library("programs", text, FLAGS), "run")
    run.restype, run.argtypes = ctypes.c_ssize_t, (ctypes.c_void_p,) * 3
    return run


def _point(arrays: Sequence[Array]) -> Integers:
    """Return the addresses of arrays."""
    return np.array([array.ctypes.data for array in arrays], dtype=np.intp)


def _take_lanes(side: Array, lanes: Integers) -> Array:
    """Return some lanes of midpoints or radii (rows, lanes), or the only one."""
    return np.ascontiguousarray(side if side.shape[1] == 1 else np.take(side, lanes, axis=1))


def _plan(
    program: RecordedProgram, supports: Sequence[tuple[int, ...]], parameters: int
) -> tuple[tuple[tuple[int, ...], ...], Integers, tuple[Any, ...]]:
    """Return a program for inputs of known parameters, with as few registers as can be: the
    parameters of its outputs, its structure in C, and the arrays to which that points.
    """
    steps, order = program.operations, program.order
    support: dict[int, tuple[int, ...]] = {}
    for n in order:
        support[n] = _find_support(steps[n], [support[a] for a in steps[n].arguments], supports)
    last = {a: place for place, n in enumerate(order) for a in steps[n].arguments}
    last.update(dict.fromkeys(program.outputs, len(order)))
    registers: dict[int, int] = {}
    free: tuple[list[int], list[int]] = ([], [])
    used = [0, 0]
    code: list[list[int]] = []
    tables: list[int] = []
    numbers = [0.0]
    for place, n in enumerate(order):
        step = steps[n]
        kind = step.name in CONDITIONS
        registers[n] = free[kind].pop() if free[kind] else used[kind]
        used[kind] = max(used[kind], registers[n] + 1)
        for a in {a for a in step.arguments if last[a] == place}:
            free[steps[a].name in CONDITIONS].append(registers[a])
        arguments = [registers[a] for a in step.arguments]
        argument_supports = [support[a] for a in step.arguments if steps[a].name not in CONDITIONS]
        more = arguments[2] if step.name == "select" else _find_more(step)
        pair = [*arguments, 0, 0][:2]
        code.append([CODES.index(step.name), registers[n], *pair, more, len(tables), len(numbers)])
        tables += _tabulate(support[n], argument_supports)
        numbers += step.numbers
    results = [[registers[n], len(support[n])] for n in program.outputs]
    arrays = (
        *(np.array(part, dtype=np.intp) for part in (code, tables, results)),
        np.array(numbers),
    )
    size = max(len(part) for part in support.values())
    if max(size, parameters) > MOST_PARAMETERS:
        raise Unbounded("a mechanism has many parameters")
    sizes = len(order), len(supports), len(results), *used, _count_rows(max(1, size)), parameters
    structure = np.array([*sizes, *_point(arrays)], dtype=np.intp)
    return tuple(support[n] for n in program.outputs), structure, arrays


def _count_rows(parameters: int) -> int:
    """Return the number of rows of a jet."""
    return 2 + 2 * parameters + packed_size(parameters)


def _find_support(
    step: RecordedStep,
    argument_supports: Sequence[tuple[int, ...]],
    supports: Sequence[tuple[int, ...]],
) -> tuple[int, ...]:
    """Return the parameters on which the result of an operation depends."""
    if step.name == "input":
        return supports[int(step.numbers[0])]
    if step.name in ("floor", *CONDITIONS):
        return ()
    return tuple(sorted({k for part in argument_supports for k in part}))


def _find_more(step: RecordedStep) -> int:
    if step.name == "polynomial":
        return len(step.numbers)
    return int(step.numbers[0]) if step.name in ("power", "below", "input") else 0


def _tabulate(support: tuple[int, ...], argument_supports: Sequence[tuple[int, ...]]) -> list[int]:
    """Return the parameters of a result and of two arguments, and where those of the result are in
    the arguments.
    """
    first, second = (*argument_supports, (), ())[:2]
    places = [[part.index(k) if k in part else -1 for k in support] for part in (first, second)]
    return [
        len(support),
        len(first),
        len(second),
        *support,
        *places[0],
        *places[1],
        *range(len(support)),
    ]
