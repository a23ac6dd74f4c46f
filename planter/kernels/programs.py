"""Programs of CasADi functions on vectors with names: evaluated here, or printed as C99 or
WebAssembly.

The C99 has a file of loops over lanes, and a file of CasADi's own C with the functions that call
both:

    double *NAME_numbers(void);    all vectors one after another; the inputs are reset to their
    initial values int NAME(void);                runs the program on them; nonzero if a result is
    not finite

The WebAssembly module has vector instructions and is built by the compiler of the extra `compiler`.
It imports nothing, and exports its memory and both functions of each program.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from string import Template

import casadi as ca
import numpy as np

from planter.kernels import compiler, toolchain
from planter.kernels.backends import Array
from planter.kernels.compiler import CompilerError
from planter.kernels.kernel import Kernel
from planter.kernels.lane_graph import LaneGraph
from planter.kernels.lane_source import print_file, print_prototype


@dataclass(frozen=True)
class ProgramStep:
    """A function; inputs that vary over `lanes` are rows of numbers, and so are then its
    outputs.
    """

    function: ca.Function
    lanes: tuple[str, ...] = ()


class Program:
    """Steps whose inputs are `start` or results of earlier steps; their functions have different
    names.

    All vectors are flat: what varies over lanes row by row, other matrices column by column. Inside
    a program a name belongs to one vector alone.
    """

    def __init__(self, name: str, start: Mapping[str, Array], steps: Sequence[ProgramStep]) -> None:
        self.name, self.steps = name, steps
        self.start = {key: np.asarray(value, dtype=float).ravel() for key, value in start.items()}
        self.sizes = {key: len(value) for key, value in self.start.items()}
        for step in steps:
            f = step.function
            self.sizes |= {key: f.numel_out(key) * self.count(step) for key in f.name_out()}

    def count(self, step: ProgramStep) -> int:
        """Number of lanes of a step."""
        counts = {self.sizes[name] // step.function.numel_in(name) for name in step.lanes}
        assert len(counts) <= 1, f"{step.function.name()}: lanes of different numbers"
        return counts.pop() if counts else 1

    @cached_property
    def offsets(self) -> dict[str, int]:
        """Offsets of the vectors, which are consecutive, those of `start` first."""
        ends = np.cumsum([0, *self.sizes.values()]).tolist()
        return dict(zip(self.sizes, ends, strict=False))

    @property
    def size(self) -> int:
        """Total length of all vectors."""
        return sum(self.sizes.values())

    @cached_property
    def _kernels(self) -> list[Kernel]:
        return [Kernel(step.function, lanes=step.lanes) for step in self.steps]

    def __call__(self, **changed: Array) -> dict[str, Array]:
        """All vectors by name, from what is given, some of it changed."""
        vectors = self.start | changed
        for step, kernel in zip(self.steps, self._kernels, strict=True):
            before = vectors
            inputs = {
                name: self._matrix(step, name, before[name]) for name in step.function.name_in()
            }
            vectors = before | {
                name: _flatten(step, value) for name, value in kernel(**inputs).items()
            }
        return vectors

    @staticmethod
    def _matrix(step: ProgramStep, name: str, vector: Array) -> Array:
        rows, columns = step.function.size_in(name)
        return (
            vector.reshape(rows, -1)
            if name in step.lanes
            else vector.reshape((rows, columns), order="F")
        )


def _flatten(step: ProgramStep, value: Array) -> Array:
    return value.ravel() if step.lanes else value.T.ravel()


LOOPS_FILE, MAIN_FILE = "loops.c", "programs.c"


def print_programs(programs: Sequence[Program]) -> dict[str, str]:
    """The texts by file name.

    Raises NotPrintableError where a function over lanes has no such form.
    """
    steps = [step for program in programs for step in program.steps]
    graphs = [LaneGraph.from_function(step.function, step.lanes) for step in steps if step.lanes]
    return {
        LOOPS_FILE: print_file(graphs, [False] * len(graphs), wasm=True),
        MAIN_FILE: _print_main(programs, steps),
    }


def _print_main(programs: Sequence[Program], steps: Sequence[ProgramStep]) -> str:
    generator = ca.CodeGenerator("planter.c")
    for step in steps:
        if not step.lanes:
            generator.add(step.function)
    functions = [step.function for step in steps if not step.lanes]
    work = {
        key: max((int(getattr(f, f"sz_{key}")()) for f in functions), default=0) + 1
        for key in ("arg", "res", "iw", "w")
    }
    text = resources.files(__package__).joinpath("program.c").read_text(encoding="utf-8")
    prototypes = "\n".join(f"{print_prototype(step.function)};" for step in steps if step.lanes)
    head = Template(text).substitute(work, functions=str(generator.dump()), prototypes=prototypes)
    return "\n".join([head, *map(_print_program, programs)])


def _print_program(program: Program) -> str:
    interface = f"{program.name}_numbers"
    place = {name: f"{program.name}_all + {offset}" for name, offset in program.offsets.items()}
    start = [repr(float(value)) for vector in program.start.values() for value in vector]
    count = len(start)
    return "\n".join(
        [
            f"static double {program.name}_all[{program.size}];",
            "",
            f"double *{interface}(void)",
            "{",
            f"  static const double start[{count}] = {{{', '.join(start)}}};",
            f"  memcpy({program.name}_all, start, sizeof start);",
            f"  return {program.name}_all;",
            "}",
            "",
            f"int {program.name}(void)",
            "{",
            *(_print_call(program, step, place) for step in program.steps),
            f"  return any_not_finite({program.name}_all + {count}, {program.size - count});",
            "}",
            "",
        ]
    )


def _print_call(program: Program, step: ProgramStep, place: dict[str, str]) -> str:
    f = step.function
    inputs, outputs = ([place[name] for name in names] for names in (f.name_in(), f.name_out()))
    if step.lanes:
        return f"  {f.name()}({', '.join([str(program.count(step)), *inputs, *outputs])});"
    arguments = [f"arg[{index}] = {at};" for index, at in enumerate(inputs)]
    results = [f"res[{index}] = {at};" for index, at in enumerate(outputs)]
    return f"  {' '.join([*arguments, *results])}\n  if ({f.name()}(arg, res, iw, w, 0)) return 1;"


WASM_TARGET = "wasm32-wasi"
COMMON_FLAGS = ("-std=gnu99", "-O3", "-msimd128", "-mexec-model=reactor", "-ffp-contract=off")
FILE_FLAGS = {
    LOOPS_FILE: ("-ffinite-math-only", "-fno-signed-zeros", "-fno-math-errno", "-fno-trapping-math")
}
"""For loops, that they can become vector instructions; the order of additions stays what it is."""


def build_webassembly(programs: Sequence[Program]) -> bytes:
    """Return the module.

    Raises CompilerError, or NotPrintableError for operations without a form in C.
    """
    command = compiler.bundled_command(WASM_TARGET)
    if not command:
        raise CompilerError("planter[compiler] is not installed: pip install 'planter[compiler]'")
    exports = [f"-Wl,--export={name}" for p in programs for name in (p.name, f"{p.name}_numbers")]
    with tempfile.TemporaryDirectory(prefix="planter-") as path:
        folder = Path(path)
        objects = []
        for name, text in print_programs(programs).items():
            source = folder / name
            source.write_text(text, encoding="utf-8")
            objects.append(f"{source}.o")
            flags = (*COMMON_FLAGS, *FILE_FLAGS.get(name, ()))
            _run_step([*command, *flags, "-c", str(source), "-o", objects[-1]], folder)
        _run_step(
            [*command, *COMMON_FLAGS, *objects, "-o", str(folder / "all.wasm"), "-s", *exports],
            folder,
        )
        return (folder / "all.wasm").read_bytes()


def _run_step(command: list[str], folder: Path) -> None:
    try:
        toolchain.run_bundled(WASM_TARGET, command, folder)
    except (OSError, subprocess.SubprocessError) as error:
        raise CompilerError(
            f"{command[0]} did not build the functions: {toolchain.summarise_error(error)}"
        ) from error
