"""Straight-line programs: generated array code recorded once, and run on jets in C, or by NumPy
without a compiler.

A recorded condition is asked once, however often the code repeats it. A program is data, which a
file can hold.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import resources
from typing import Any

import numpy as np

from planter.engine.proof import intervals
from planter.engine.proof.intervals import PI, Ball, Branches, Unbounded
from planter.engine.proof.jets import ANYWHERE, Jet, Space, packed_size
from planter.engine.proof.roots import solve_linear_jets
from planter.kernels import Array, Integers, toolchain
from planter.kernels.compiler import CompilerError

CODES = (
    "constant",
    "pi",
    "add",
    "negate",
    "multiply",
    "power",
    "inverse",
    "sqrt",
    "sin",
    "cos",
    "arctan",
    "exp",
    "log",
    "polynomial",
    "select",
    "arctan2",
    "floor",
    "below",
    "or",
    "and",
    "not",
    "input",
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


@dataclass(frozen=True)
class RecordedStep:
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
    """Operations in order; `outputs` are the indices of the results."""

    operations: tuple[RecordedStep, ...]
    outputs: tuple[int, ...]

    def to_document(self) -> dict[str, Any]:
        """Return the operations that outputs need as lists of name, arguments and numbers, these in
        hexadecimal.
        """
        places = {n: place for place, n in enumerate(self.order)}
        steps = [self.operations[n] for n in self.order]
        return {
            "operations": [
                [
                    step.name,
                    [places[a] for a in step.arguments],
                    [float(number).hex() for number in step.numbers],
                ]
                for step in steps
            ],
            "outputs": [places[n] for n in self.outputs],
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> RecordedProgram:
        """Return the program of a document.

        Raises ValueError, KeyError, TypeError or IndexError if it is none.
        """
        operations = tuple(
            RecordedStep(name, tuple(arguments), tuple(float.fromhex(number) for number in numbers))
            for name, arguments, numbers in document["operations"]
        )
        if any(not 0 <= a < n for n, step in enumerate(operations) for a in step.arguments):
            raise ValueError("an operation takes the result of a later one")
        if unknown := sorted({step.name for step in operations} - {*CODES, "solve"}):
            raise ValueError(f"there is no operation {unknown[0]!r}")
        program = cls(operations, tuple(document["outputs"]))
        program.check_kinds()
        return program

    def check_kinds(self) -> None:
        """Raise ValueError if a number is taken where a condition must be, or the other way
        round.
        """
        are_conditions = [step.name in CONDITIONS for step in self.operations]
        if any(k < 0 for k in self.outputs) or any(are_conditions[k] for k in self.outputs):
            raise ValueError("a result is no number")
        for step in self.operations:
            kinds = [are_conditions[k] for k in step.arguments]
            is_logic = step.name in CONDITIONS and step.name != "below"
            if kinds != (
                [False, False, True] if step.name == "select" else [is_logic] * len(kinds)
            ):
                raise ValueError(
                    f"{step.name} takes a condition for a number, or a number for a condition"
                )

    @cached_property
    def jumps(self) -> tuple[bool, ...]:
        """Whether the results may jump where the answer to each question changes, in the order of
        questions.
        """
        questions = [
            step
            for step in map(self.operations.__getitem__, self.order)
            if step.name in ("floor", "below")
        ]
        return tuple(step.name == "floor" or bool(step.numbers[1]) for step in questions)

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
                order.update(
                    dict.fromkeys(a for a in step.arguments if self.operations[a].name in LEAVES)
                )
                order[n] = None
        return tuple({**order, **dict.fromkeys(self.outputs)})


class Recorder:
    """Collects the operations of code that runs on its nodes; equal operations are one."""

    def __init__(self) -> None:
        self.operations: list[RecordedStep] = []
        self._indices: dict[RecordedStep, int] = {}

    def record(
        self, name: str, *arguments: RecordedValue, numbers: Sequence[float] = ()
    ) -> RecordedValue:
        """Return the node of an operation, the earlier one if there is an equal one."""
        step = RecordedStep(name, tuple(node.index for node in arguments), tuple(numbers))
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


@dataclass(frozen=True, eq=False)
class RecordedValue:
    """A quantity or a condition of recorded code, with the operations of `Jet`."""

    space: Recorder
    index: int

    def __add__(self, other: Any) -> RecordedValue:
        return self.space.record("add", self, self.space.lift(other))

    def __neg__(self) -> RecordedValue:
        return self.space.record("negate", self)

    def __sub__(self, other: Any) -> RecordedValue:
        return self + -self.space.lift(other)

    def __rsub__(self, other: Any) -> RecordedValue:
        return -self + other

    def __mul__(self, other: Any) -> RecordedValue:
        return self.space.record("multiply", self, self.space.lift(other))

    def __truediv__(self, other: Any) -> RecordedValue:
        return self * self.space.lift(other).inverse()

    def __rtruediv__(self, other: Any) -> RecordedValue:
        return self.inverse() * other

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, exponent: Any) -> RecordedValue:
        """Return a power: of a positive base alone if the exponent is no whole number."""
        if isinstance(exponent, RecordedValue) or exponent != int(exponent):
            logarithm = self.space.record("log", self)
            return self.space.record("exp", logarithm * exponent)
        if exponent < 0:
            return self.inverse() ** -exponent
        return (
            self.space.record("power", self, numbers=[exponent])
            if exponent
            else self.space.lift(1.0)
        )

    def __rpow__(self, base: Any) -> RecordedValue:
        return self.space.lift(base) ** self

    def inverse(self) -> RecordedValue:
        """Return the reciprocal."""
        return self.space.record("inverse", self)

    def where(self, condition: Any, other: Any) -> RecordedValue:
        """Return this node where a condition holds, and the other where not."""
        if not isinstance(condition, RecordedValue):
            return self if condition else self.space.lift(other)
        return self.space.record("select", self, self.space.lift(other), condition)

    def reaches(self, other: Any) -> RecordedValue:
        """Return whether this is at least another, for a choice that is continuous where they are
        equal.
        """
        return (other - self).ask(strictly=False, jumps=False)

    def ask(self, strictly: bool, jumps: bool = True) -> RecordedValue:
        """Return whether this is below zero, or at zero unless `strictly`."""
        return self.space.record("below", self, numbers=[strictly, jumps])

    def __lt__(self, other: Any) -> RecordedValue:
        return (self - other).ask(strictly=True)

    def __le__(self, other: Any) -> RecordedValue:
        return (self - other).ask(strictly=False)

    def __gt__(self, other: Any) -> RecordedValue:
        return (-self + other).ask(strictly=True)

    def __ge__(self, other: Any) -> RecordedValue:
        return (-self + other).ask(strictly=False)


class RecordingNamespace:
    """Array namespace `xp` of generated code, for nodes."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder

    @cached_property
    def pi(self) -> RecordedValue:
        return self._recorder.record("pi")

    def lift(self, value: Any) -> RecordedValue:
        """Return a number as a node; a node is returned unchanged."""
        return self._recorder.lift(value)

    def where(self, condition: Any, yes: Any, no: Any) -> RecordedValue:
        """Return a selection by a condition."""
        return self.lift(yes).where(condition, no)

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

    def sin(self, x: Any) -> RecordedValue:
        """Return the sine."""
        return self._recorder.record("sin", self.lift(x))

    def cos(self, x: Any) -> RecordedValue:
        """Return the cosine."""
        return self._recorder.record("cos", self.lift(x))

    def tan(self, x: Any) -> RecordedValue:
        """Return the tangent."""
        return self.sin(x) / self.cos(x)

    def sqrt(self, x: Any) -> RecordedValue:
        """Return the square root."""
        return self._recorder.record("sqrt", self.lift(x))

    def exp(self, x: Any) -> RecordedValue:
        """Return the exponential."""
        return self._recorder.record("exp", self.lift(x))

    def log(self, x: Any) -> RecordedValue:
        """Return the natural logarithm."""
        return self._recorder.record("log", self.lift(x))

    def arctan(self, x: Any) -> RecordedValue:
        """Return the arc tangent."""
        return self._recorder.record("arctan", self.lift(x))

    def arcsin(self, x: Any) -> RecordedValue:
        """Return the arc sine."""
        return self.arctan(x / self.sqrt(1 - x**2))

    def arccos(self, x: Any) -> RecordedValue:
        """Return the arc cosine."""
        return self.arctan2(self.sqrt(1 - x**2), x)

    def arctan2(self, y: Any, x: Any) -> RecordedValue:
        """Return the angle of a point."""
        return self._recorder.record("arctan2", self.lift(y), self.lift(x))

    def polyval(self, coefficients: Sequence[float], x: Any) -> RecordedValue:
        """Return the sum of a_k x^k, with the highest power first."""
        return self._recorder.record(
            "polynomial", self.lift(x), numbers=[float(a) for a in coefficients]
        )

    def floor(self, x: Any) -> RecordedValue:
        """Return the largest integer below."""
        return self._recorder.record("floor", self.lift(x))

    def logical_or(self, a: Any, b: Any) -> RecordedValue:
        """Return whether one of two conditions holds."""
        return self._recorder.record("or", a, b)

    def logical_and(self, a: Any, b: Any) -> RecordedValue:
        """Return whether both of two conditions hold."""
        return self._recorder.record("and", a, b)

    def logical_not(self, a: Any) -> RecordedValue:
        """Return whether a condition does not hold."""
        return self._recorder.record("not", a)

    def solve(self, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[RecordedValue]:
        """Return the unknowns (k,) of simultaneous equations."""
        entries = [self.lift(entry) for row in (*matrix, right) for entry in row]
        size = len(right)
        return [self._recorder.record("solve", *entries, numbers=[size, k]) for k in range(size)]


Code = Callable[[Any, Sequence[Any]], Sequence[Any]]
"""(xp, inputs) -> results, in the array namespace `xp`."""


def record_program(code: Code, count: int) -> RecordedProgram:
    """Return the operations of code of a number of inputs.

    Raises UnrecordedError if they are no straight line.
    """
    recorder = Recorder()
    inputs = [recorder.record("input", numbers=[k]) for k in range(count)]
    outputs = tuple(
        recorder.lift(result).index for result in code(RecordingNamespace(recorder), inputs)
    )
    return RecordedProgram(tuple(recorder.operations), outputs)


class ProgramRunner:
    """Encloses the results of a program over boxes, in C if there is a compiler."""

    def __init__(self, program: RecordedProgram) -> None:
        self.program = program

    @cached_property
    def compiled(self) -> CompiledProgram | None:
        """The program in C, None without a compiler or where C has no operation for a step."""
        try:
            return CompiledProgram(self.program)
        except CompilerError:
            return None

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, Sequence[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked; `script`
        has answers.
        """
        if self.compiled is not None:
            return self.compiled.enclose(space, inputs, lanes, script)
        branches = Branches(len(lanes), script)
        part = space.asking(branches, lanes)
        taken = [replace(jet if jet.lanes == 1 else jet.taken(lanes), space=part) for jet in inputs]
        return branches, run_in_numpy(self.program, part, taken)

    def enclose_smooth(self, space: Space, inputs: Sequence[Jet]) -> list[Jet]:
        """Return the results in all lanes.

        Raises Unbounded if a condition has several answers over the box.
        """
        count = max((jet.lanes for jet in inputs), default=1)
        branches, jets = self.enclose(space, inputs, np.arange(count), np.empty((0, count)))
        if branches.alternatives:
            raise Unbounded("a condition has several answers over a box")
        return [replace(jet, space=space) for jet in jets]


def run_in_numpy(program: RecordedProgram, space: Space, inputs: Sequence[Jet]) -> list[Jet]:
    """Return the results of a program; conditions are answered by the branches of the space."""
    values: dict[int, Any] = {}
    solutions: dict[tuple[int, ...], list[Jet]] = {}
    for n in program.order:
        step = program.operations[n]
        arguments = [values[a] for a in step.arguments]
        match step.name:
            case "constant":
                values[n] = space.constant(Ball.exact([step.numbers[0]]))
            case "pi":
                values[n] = space.constant(PI)
            case "input":
                values[n] = inputs[int(step.numbers[0])]
            case "add":
                values[n] = arguments[0] + arguments[1]
            case "negate":
                values[n] = -arguments[0]
            case "multiply":
                values[n] = arguments[0] * arguments[1]
            case "power":
                values[n] = arguments[0] ** int(step.numbers[0])
            case "polynomial":
                values[n] = arguments[0].polynomial(step.numbers)
            case "select":
                values[n] = arguments[0].where(arguments[2], arguments[1])
            case "arctan2":
                values[n] = arguments[0].angle(arguments[1])
            case "below":
                strictly, jumps = map(bool, step.numbers)
                values[n] = space.branches.below(arguments[0].value[ANYWHERE], strictly, jumps)
            case "or" | "and" | "not":
                values[n] = getattr(np, f"logical_{step.name}")(*arguments)
            case "solve":
                size, k = map(int, step.numbers)
                if step.arguments not in solutions:
                    rows = [arguments[i : i + size] for i in range(0, len(arguments), size)]
                    solutions[step.arguments] = solve_linear_jets(space, rows[:-1], rows[-1])
                values[n] = solutions[step.arguments][k]
            case name:
                values[n] = getattr(arguments[0], name)()
    return [values[n] for n in program.outputs]


class _Program(ctypes.Structure):
    """`program` in programs.c."""

    _fields_ = (
        *(
            (name, ctypes.c_long)
            for name in (
                "operations",
                "inputs",
                "outputs",
                "registers",
                "conditions",
                "rows",
                "parameters",
            )
        ),
        *((name, ctypes.c_void_p) for name in ("code", "tables", "results", "numbers")),
    )


class _Call(ctypes.Structure):
    """`call` in programs.c."""

    _fields_ = (
        *(
            (name, ctypes.c_void_p)
            for name in (
                "half",
                "script",
                "input_mid",
                "input_rad",
                "output_mid",
                "output_rad",
                "largest",
                "smallest",
                "answers",
                "strides",
            )
        ),
        *((name, ctypes.c_long) for name in ("lanes", "script_rows", "cutting")),
    )


FLAGS = ("-O3", "-ffp-contract=off")
"""A product and a sum must not become one operation with one rounding."""


@cache
def _load() -> Any:
    """Return the C function. Raises CompilerError."""
    text = resources.files(__package__).joinpath("programs.c").read_text(encoding="utf-8")
    (run,) = toolchain.load_functions(toolchain.build_library("programs", text, FLAGS), "run")
    run.restype, run.argtypes = ctypes.c_long, (ctypes.c_void_p,) * 3
    return run


@dataclass(frozen=True)
class _Plan:
    """A program for inputs of known parameters: `support` of the outputs, and the numbers that C
    reads.
    """

    support: tuple[tuple[int, ...], ...]
    arrays: tuple[Any, ...]
    structure: _Program


class CompiledProgram:
    """A program that C runs.

    Raises CompilerError without a compiler, or if C has no operation for a step.
    """

    def __init__(self, program: RecordedProgram) -> None:
        if any(
            step.name == "solve" or len(step.numbers) > MOST_TERMS for step in program.operations
        ):
            raise CompilerError(
                "C solves no simultaneous equations and adds up no polynomials of many terms"
            )
        self.program, self._run = program, _load()
        self._plans: dict[Any, _Plan] = {}

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, list[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked."""
        size, count = len(space.half), len(lanes)
        key = (size, *(jet.support for jet in inputs))
        if key not in self._plans:
            self._plans[key] = _plan(self.program, [jet.support for jet in inputs], size)
        plan = self._plans[key]
        half = space.half if space.half.shape[1] == 1 else space.half[:, lanes]
        mids, rads = zip(*(_pack(jet, lanes) for jet in inputs), strict=True)
        strides = np.array([mid.shape[1] > 1 for mid in (*mids, half)], dtype=ctypes.c_long)
        rows = [2 + 2 * len(support) + packed_size(len(support)) for support in plan.support]
        results = [(np.empty((row, count)), np.empty((row, count))) for row in rows]
        answers = np.zeros((3, len(self.program.jumps), count))
        arrays = [np.ascontiguousarray(half), np.ascontiguousarray(script), strides, *answers]
        call = _Call(
            arrays[0].ctypes.data,
            arrays[1].ctypes.data,
            _point(mids),
            _point(rads),
            _point([m for m, _ in results]),
            _point([r for _, r in results]),
            *(part.ctypes.data for part in arrays[3:]),
            strides.ctypes.data,
            count,
            len(script),
            space.is_cutting,
        )
        constants = (
            intervals.U,
            intervals.SLACK,
            intervals.GROWTH,
            intervals.TINY,
            intervals.LIBM,
            np.pi,
        )
        rounding = (ctypes.c_double * len(constants))(*constants)
        if self._run(ctypes.byref(plan.structure), ctypes.byref(call), rounding):
            raise MemoryError
        branches = Branches(count, script)
        branches.replay(answers[0], answers[1], answers[2], self.program.jumps)
        return branches, [
            _unpack(space, support, *pair)
            for support, pair in zip(plan.support, results, strict=True)
        ]


def _point(arrays: Sequence[Array]) -> Any:
    """Return an array of the addresses of arrays."""
    return ctypes.cast(
        (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays)), ctypes.c_void_p
    )


def _pack(jet: Jet, lanes: Integers) -> tuple[Array, Array]:
    """Return midpoints and radii (rows, lanes), or (rows, 1) if all lanes are the same."""
    count = len(jet.support)
    width = 1 if jet.lanes == 1 else len(lanes)
    packed = np.empty((2, 2 + 2 * count + packed_size(count), width))
    for to, part in zip(packed, ("mid", "rad"), strict=True):
        for start, ball in ((0, jet.value), (2, jet.gradient), (2 + 2 * count, jet.hessian)):
            side = getattr(ball, part)
            side = side.reshape(-1, side.shape[-1])
            to[start : start + len(side)] = side if side.shape[-1] == 1 else side[:, lanes]
    return packed[0], packed[1]


def _unpack(space: Space, support: tuple[int, ...], mid: Array, rad: Array) -> Jet:
    count, lanes = len(support), mid.shape[1]
    ends = 2, 2 + 2 * count
    sides = [np.split(side, ends) for side in (mid, rad)]
    value, gradient, hessian = (Ball(a, b) for a, b in zip(*sides, strict=True))
    slopes = Ball(gradient.mid.reshape(2, count, lanes), gradient.rad.reshape(2, count, lanes))
    return Jet(space, support, value, slopes, hessian)


def _plan(program: RecordedProgram, supports: Sequence[tuple[int, ...]], parameters: int) -> _Plan:
    """Return a program as numbers for C, for inputs of known parameters, with as few registers as
    can be.
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
    results = np.array(
        [[registers[n], len(support[n])] for n in program.outputs], dtype=ctypes.c_long
    )
    arrays = (
        np.array(code, dtype=ctypes.c_long),
        np.array(tables, dtype=ctypes.c_long),
        results,
        np.array(numbers),
    )
    size = max(len(part) for part in support.values())
    if max(size, parameters) > MOST_PARAMETERS:
        raise Unbounded("a mechanism has many parameters")
    structure = _Program(
        len(order),
        len(supports),
        len(results),
        used[0],
        used[1],
        max(5, 2 + 2 * size + packed_size(size)),
        parameters,
        *(array.ctypes.data for array in arrays),
    )
    return _Plan(tuple(support[n] for n in program.outputs), arrays, structure)


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
