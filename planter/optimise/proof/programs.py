"""Straight-line programs: generated array code recorded once, and run on jets in C, or by NumPy without a compiler.

A recorded condition is asked once, however often the code repeats it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from typing import Any

import numpy as np

from planter.kernels import Array, toolchain
from planter.kernels.compiler import CompilerError
from planter.numerics.arrays import Integers
from planter.optimise.proof import intervals
from planter.optimise.proof.enclosures import JetNamespace
from planter.optimise.proof.intervals import Ball, Branches, Unbounded
from planter.optimise.proof.jets import Jet, Space, packed_size

CODES = (
    "constant", "pi", "add", "negate", "multiply", "power", "inverse", "sqrt", "sin", "cos", "arctan", "exp", "log",
    "polynomial", "select", "arctan2", "floor", "below", "or", "and", "not", "input",
)  # fmt: skip
"""Names of operations, in the order of their numbers in C."""
CONDITIONS = ("below", "or", "and", "not")
LEAVES = ("constant", "pi", "input")
MOST_PARAMETERS, MOST_TERMS = 64, 64
"""Largest numbers of parameters of a jet and of terms of a polynomial in C."""


class UnrecordedError(Exception):
    """Code is not a straight line of operations."""


@dataclass(frozen=True)
class RecordedStep:
    """A step of a program: `arguments` are indices of earlier steps, `numbers` constants.

    Numbers are the constant, the exponent, the coefficients with the highest power first, the index of an input, or, of
    "below", whether zero is not below zero, and whether the result may jump where the answer changes.
    """

    name: str
    arguments: tuple[int, ...] = ()
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class RecordedProgram:
    """Operations in order; `outputs` are the indices of the results."""

    operations: tuple[RecordedStep, ...]
    outputs: tuple[int, ...]

    @cached_property
    def jumps(self) -> tuple[bool, ...]:
        """Whether the results may jump where the answer to each question changes, in the order of questions."""
        questions = [step for step in map(self.operations.__getitem__, self.order) if step.name in ("floor", "below")]
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
                order.update(dict.fromkeys(a for a in step.arguments if self.operations[a].name in LEAVES))
                order[n] = None
        return tuple({**order, **dict.fromkeys(self.outputs)})


class Recorder:
    """Collects the operations of code that runs on its nodes; equal operations are one."""

    def __init__(self) -> None:
        self.operations: list[RecordedStep] = []
        self._indices: dict[RecordedStep, int] = {}

    def record(self, name: str, *arguments: RecordedValue, numbers: Sequence[float] = ()) -> RecordedValue:
        """Return the node of an operation, the earlier one if there is an equal one."""
        step = RecordedStep(name, tuple(node.index for node in arguments), tuple(numbers))
        if step not in self._indices:
            self._indices[step] = len(self.operations)
            self.operations.append(step)
        return RecordedValue(self, self._indices[step])

    def lift(self, value: Any) -> RecordedValue:
        """Return a number as a node; a node is returned unchanged. Raises UnrecordedError for anything else."""
        if isinstance(value, RecordedValue):
            return value
        if np.ndim(value) or isinstance(value, Jet):
            raise UnrecordedError("an array is no single number")
        return self.record("constant", numbers=[float(value)])

    def constant(self, value: Ball) -> RecordedValue:
        """Return a number as a node. Raises UnrecordedError for a ball with a radius."""
        if value.mid.size != 1 or value.rad.any():
            raise UnrecordedError("a ball is no single number")
        return self.lift(float(value.mid.ravel()[0]))

    def integer(self, number: int) -> RecordedValue:
        """Return an integer as a node."""
        return self.lift(number)


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

    def __pow__(self, exponent: int) -> RecordedValue:
        if exponent != int(exponent):
            raise UnrecordedError("a power is not whole")
        if exponent < 0:
            return self.inverse() ** -exponent
        return self.space.record("power", self, numbers=[exponent]) if exponent else self.space.lift(1.0)

    def inverse(self) -> RecordedValue:
        """Return the reciprocal."""
        return self.space.record("inverse", self)

    def sqrt(self) -> RecordedValue:
        """Return the square root."""
        return self.space.record("sqrt", self)

    def sin(self) -> RecordedValue:
        """Return the sine."""
        return self.space.record("sin", self)

    def cos(self) -> RecordedValue:
        """Return the cosine."""
        return self.space.record("cos", self)

    def arctan(self) -> RecordedValue:
        """Return the arc tangent."""
        return self.space.record("arctan", self)

    def exp(self) -> RecordedValue:
        """Return the exponential."""
        return self.space.record("exp", self)

    def log(self) -> RecordedValue:
        """Return the natural logarithm."""
        return self.space.record("log", self)

    def floor(self) -> RecordedValue:
        """Return the largest integer below."""
        return self.space.record("floor", self)

    def polynomial(self, coefficients: Sequence[float]) -> RecordedValue:
        """Return the sum of a_k x^k, with the highest power first."""
        return self.space.record("polynomial", self, numbers=[float(a) for a in coefficients])

    def where(self, condition: Any, other: Any) -> RecordedValue:
        """Return this node where a condition holds, and the other where not."""
        if not isinstance(condition, RecordedValue):
            return self if condition else self.space.lift(other)
        return self.space.record("select", self, self.space.lift(other), condition)

    def reaches(self, other: Any) -> RecordedValue:
        """Return whether this is at least another, for a choice that is continuous where they are equal."""
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


class RecordingNamespace(JetNamespace):
    """Array namespace `xp` of generated code, for nodes."""

    def __init__(self, recorder: Any) -> None:
        super().__init__(recorder)
        self._recorder = recorder

    @cached_property
    def pi(self) -> Any:
        return self._recorder.record("pi")

    def where(self, condition: Any, yes: Any, no: Any) -> Any:
        """Return a selection by a condition."""
        return self._recorder.lift(yes).where(condition, no)

    def absolute(self, x: Any) -> Any:
        """Return the absolute value."""
        return self.where(self._recorder.lift(x).reaches(0), x, -x)

    def arctan2(self, y: Any, x: Any) -> Any:
        """Return the angle of a point."""
        return self._recorder.record("arctan2", self._recorder.lift(y), self._recorder.lift(x))

    def logical_or(self, a: Any, b: Any) -> Any:  # type: ignore[override]
        """Return whether one of two conditions holds."""
        return self._recorder.record("or", a, b)

    def logical_and(self, a: Any, b: Any) -> Any:  # type: ignore[override]
        """Return whether both of two conditions hold."""
        return self._recorder.record("and", a, b)

    def logical_not(self, a: Any) -> Any:  # type: ignore[override]
        """Return whether a condition does not hold."""
        return self._recorder.record("not", a)


Code = Callable[[Any, Sequence[Any]], Sequence[Any]]
"""(xp, inputs) -> results, in the array namespace `xp`."""


def record_program(code: Code, count: int) -> RecordedProgram:
    """Return the operations of code of a number of inputs. Raises UnrecordedError if they are no straight line."""
    recorder = Recorder()
    inputs = [recorder.record("input", numbers=[k]) for k in range(count)]
    results = code(RecordingNamespace(recorder), inputs)
    return RecordedProgram(tuple(recorder.operations), tuple(recorder.lift(result).index for result in results))


class StraightLine:
    """Code whose results over a box are enclosed, in C if it can be recorded and there is a compiler."""

    def __init__(self, code: Code) -> None:
        self._code = code
        self._compiled: dict[int, CompiledProgram | None] = {}

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, Sequence[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked; `script` has answers."""
        compiled = self._find_compiled(len(inputs))
        if compiled is not None:
            return compiled.enclose(space, inputs, lanes, script)
        branches = Branches(len(lanes), script)
        part = space.asking(branches, lanes)
        taken = [_move(jet if jet.lanes == 1 else jet.taken(lanes), part) for jet in inputs]
        return branches, [part.lift(result) for result in self._code(JetNamespace(part), taken)]

    def enclose_smooth(self, space: Space, inputs: Sequence[Jet]) -> list[Jet]:
        """Return the results in all lanes. Raises Unbounded if a condition has several answers over the box."""
        count = max(jet.lanes for jet in inputs)
        branches, jets = self.enclose(space, inputs, np.arange(count), np.empty((0, count)))
        if branches.alternatives:
            raise Unbounded("a condition has several answers over a box")
        return [_move(jet, space) for jet in jets]

    def _find_compiled(self, count: int) -> CompiledProgram | None:
        if count not in self._compiled:
            try:
                self._compiled[count] = CompiledProgram(record_program(self._code, count))
            except (UnrecordedError, CompilerError):
                self._compiled[count] = None
        return self._compiled[count]


def _move(jet: Jet, space: Space) -> Jet:
    return Jet(space, jet.felt, jet.value, jet.gradient, jet.hessian)


class _Program(ctypes.Structure):
    """`program` in programs.c."""

    _fields_ = (
        *((name, ctypes.c_long) for name in ("operations", "inputs", "outputs", "registers", "conditions", "rows",
                                             "parameters")),
        *((name, ctypes.c_void_p) for name in ("code", "tables", "results", "numbers")),
    )  # fmt: skip


class _Call(ctypes.Structure):
    """`call` in programs.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("half", "script", "input_mid", "input_rad", "output_mid", "output_rad",
                                               "largest", "smallest", "answers", "strides")),
        *((name, ctypes.c_long) for name in ("lanes", "script_rows", "cutting")),
    )  # fmt: skip


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
    """A program for inputs of known parameters: `felt` of the outputs, and the numbers that C reads."""

    felt: tuple[tuple[int, ...], ...]
    arrays: tuple[Any, ...]
    structure: _Program


class CompiledProgram:
    """A program that C runs. Raises CompilerError without a compiler."""

    def __init__(self, program: RecordedProgram) -> None:
        self.program, self._run = program, _load()
        self._plans: dict[Any, _Plan] = {}
        if any(len(step.numbers) > MOST_TERMS for step in program.operations):
            raise UnrecordedError("a polynomial has many terms")

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, list[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked."""
        size, count = len(space.half), len(lanes)
        key = (size, *(jet.felt for jet in inputs))
        if key not in self._plans:
            self._plans[key] = _plan(self.program, [jet.felt for jet in inputs], size)
        plan = self._plans[key]
        half = space.half if space.half.shape[1] == 1 else space.half[:, lanes]
        mids, rads = zip(*(_pack(jet, lanes) for jet in inputs), strict=True)
        strides = np.array([mid.shape[1] > 1 for mid in (*mids, half)], dtype=ctypes.c_long)
        rows = [2 + 2 * len(felt) + packed_size(len(felt)) for felt in plan.felt]
        results = [(np.empty((row, count)), np.empty((row, count))) for row in rows]
        answers = np.zeros((3, len(self.program.jumps), count))
        arrays = [np.ascontiguousarray(half), np.ascontiguousarray(script), strides, *answers]
        call = _Call(
            arrays[0].ctypes.data, arrays[1].ctypes.data, _point(mids), _point(rads), _point([m for m, _ in results]),
            _point([r for _, r in results]), *(part.ctypes.data for part in arrays[3:]), strides.ctypes.data, count,
            len(script), space.is_cutting,
        )  # fmt: skip
        constants = (intervals.U, intervals.SLACK, intervals.GROWTH, intervals.TINY, intervals.LIBM, np.pi)
        rounding = (ctypes.c_double * len(constants))(*constants)
        if self._run(ctypes.byref(plan.structure), ctypes.byref(call), rounding):
            raise MemoryError
        branches = Branches(count, script)
        branches.replay(answers[0], answers[1], answers[2], self.program.jumps)
        return branches, [_unpack(space, felt, *pair) for felt, pair in zip(plan.felt, results, strict=True)]


def _point(arrays: Sequence[Array]) -> Any:
    """Return an array of the addresses of arrays."""
    return ctypes.cast((ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays)), ctypes.c_void_p)


def _pack(jet: Jet, lanes: Integers) -> tuple[Array, Array]:
    """Return midpoints and radii (rows, lanes), or (rows, 1) if all lanes are the same."""
    count = len(jet.felt)
    width = 1 if jet.lanes == 1 else len(lanes)
    packed = np.empty((2, 2 + 2 * count + packed_size(count), width))
    for to, part in zip(packed, ("mid", "rad"), strict=True):
        for start, ball in ((0, jet.value), (2, jet.gradient), (2 + 2 * count, jet.hessian)):
            side = getattr(ball, part)
            side = side.reshape(-1, side.shape[-1])
            to[start : start + len(side)] = side if side.shape[-1] == 1 else side[:, lanes]
    return packed[0], packed[1]


def _unpack(space: Space, felt: tuple[int, ...], mid: Array, rad: Array) -> Jet:
    count, lanes = len(felt), mid.shape[1]
    ends = 2, 2 + 2 * count
    sides = [np.split(side, ends) for side in (mid, rad)]
    value, gradient, hessian = (Ball(a, b) for a, b in zip(*sides, strict=True))
    slopes = Ball(gradient.mid.reshape(2, count, lanes), gradient.rad.reshape(2, count, lanes))
    return Jet(space, felt, value, slopes, hessian)


def _plan(program: RecordedProgram, felts: Sequence[tuple[int, ...]], parameters: int) -> _Plan:
    """Return a program as numbers for C, for inputs of known parameters, with as few registers as can be."""
    steps, order = program.operations, program.order
    felt: dict[int, tuple[int, ...]] = {}
    for n in order:
        felt[n] = _find_felt(steps[n], [felt[a] for a in steps[n].arguments], felts)
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
        argument_felts = [felt[a] for a in step.arguments if steps[a].name not in CONDITIONS]
        more = arguments[2] if step.name == "select" else _find_more(step)
        pair = [*arguments, 0, 0][:2]
        code.append([CODES.index(step.name), registers[n], *pair, more, len(tables), len(numbers)])
        tables += _tabulate(felt[n], argument_felts)
        numbers += step.numbers
    results = np.array([[registers[n], len(felt[n])] for n in program.outputs], dtype=ctypes.c_long)
    arrays = np.array(code, dtype=ctypes.c_long), np.array(tables, dtype=ctypes.c_long), results, np.array(numbers)
    size = max(len(part) for part in felt.values())
    if max(size, parameters) > MOST_PARAMETERS:
        raise Unbounded("a mechanism has many parameters")
    structure = _Program(
        len(order), len(felts), len(results), used[0], used[1], max(5, 2 + 2 * size + packed_size(size)), parameters,
        *(array.ctypes.data for array in arrays),
    )  # fmt: skip
    return _Plan(tuple(felt[n] for n in program.outputs), arrays, structure)


def _find_felt(
    step: RecordedStep, argument_felts: Sequence[tuple[int, ...]], felts: Sequence[tuple[int, ...]]
) -> tuple[int, ...]:
    """Return the parameters on which the result of an operation depends."""
    if step.name == "input":
        return felts[int(step.numbers[0])]
    if step.name in ("floor", *CONDITIONS):
        return ()
    return tuple(sorted({k for part in argument_felts for k in part}))


def _find_more(step: RecordedStep) -> int:
    if step.name == "polynomial":
        return len(step.numbers)
    return int(step.numbers[0]) if step.name in ("power", "below", "input") else 0


def _tabulate(felt: tuple[int, ...], argument_felts: Sequence[tuple[int, ...]]) -> list[int]:
    """Return the parameters of a result and of two arguments, and where those of the result are in the arguments."""
    first, second = (*argument_felts, (), ())[:2]
    places = [[part.index(k) if k in part else -1 for k in felt] for part in (first, second)]
    return [len(felt), len(first), len(second), *felt, *places[0], *places[1], *range(len(felt))]
