"""Three ways to evaluate a function over lanes: vector loops, CasADi's own C, CasADi's virtual machine.

Each takes the inputs as arrays of shape (rows, lanes) or, shared by all lanes, (rows, columns), and gives outputs
(rows, lanes), or (rows, 1) summed over the lanes. All give the same to 1e-12.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Protocol

import casadi as ca
import numpy as np

from planter.kernels import loops, toolchain
from planter.kernels.toolchain import NoCompiler
from planter.kernels.virtual import VirtualMachine
from planter.kernels.work import Array, Work

NAMES = ("lanes", "casadi-c", "casadi-vm")


class Way(Protocol):
    """How a function is evaluated."""

    name: str

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]: ...


class Lanes:
    """A loop over lanes in vector instructions."""

    name = "lanes"

    def __init__(self, work: Work, library: Path) -> None:
        self.work, self.library = work, library
        self._shapes = [work.function.size_out(i) for i in range(work.function.n_out())]
        self._varies = [name in work.varying for name in work.function.name_in()]
        (self.loop,) = toolchain.functions(library, work.function.name())
        self.loop.restype = None

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]:
        given = zip(arrays, self._varies, strict=True)
        inputs = [np.ascontiguousarray(a) if varies else np.asfortranarray(a) for a, varies in given]
        outputs = self.memory(count)
        self.loop(*self._arguments(inputs, outputs, count))
        return self.results(outputs)

    def memory(self, count: int) -> list[Array]:
        """What the loop writes to: a row for each element of an output, column by column, over the lanes."""
        columns = 1 if self.work.summed else count
        return [np.empty((height * width, columns)) for height, width in self._shapes]

    def results(self, memory: Sequence[Array]) -> list[Array]:
        """The outputs in what the loop has written; those of one column are the memory itself."""
        return [_side_by_side(elements, *shape) for elements, shape in zip(memory, self._shapes, strict=True)]

    def prepared(self, inputs: Sequence[Array], outputs: Sequence[Array], count: int) -> Callable[[], object]:
        """The loop on arrays as they are laid out for it; who calls it keeps them."""
        return partial(self.loop, *self._arguments(inputs, outputs, count))

    @staticmethod
    def _arguments(inputs: Sequence[Array], outputs: Sequence[Array], count: int) -> Iterator[object]:
        yield ctypes.c_long(count)
        for array in (*inputs, *outputs):
            yield ctypes.c_void_p(array.ctypes.data)

    def interface(self, count: int) -> ca.Function:
        """The loop over `count` lanes as a CasADi function that its solvers call without Python.

        Inputs and outputs that vary are (lanes, rows). Raises NoCompiler.
        """
        function, own = self.work.function, loops.interface.name(self.work.function, count)
        text = loops.interface.source(function, self.work.varying, self.work.summed, count)
        path = toolchain.library(own, text, toolchain.OPTIMISED, (self.library,))
        toolchain.functions(path, own)
        return ca.external(own, str(path))


def _side_by_side(elements: Array, height: int, width: int) -> Array:
    """A matrix for each lane, its elements column by column, (height width, lanes), as (height, lanes width)."""
    if width == 1:
        return elements
    return elements.reshape(width, height, -1).transpose(1, 2, 0).reshape(height, -1)


def virtual_machine(work: Work) -> Way:
    return VirtualMachine(work)


def casadi_text(work: Work) -> str:
    """A function in CasADi's own C."""
    generator = ca.CodeGenerator(f"{work.function.name()}.c")
    generator.add(work.function)
    return str(generator.dump())


def casadi_library(work: Work) -> Path:
    """The library of a function in CasADi's own C. Raises NoCompiler."""
    return toolchain.library(*_source(work, "casadi-c"))


def casadi_c(work: Work) -> Way:
    """A function in CasADi's own C. Raises NoCompiler."""
    path, name = casadi_library(work), work.function.name()
    toolchain.functions(path, name)
    return VirtualMachine(work, ca.external(name, str(path)))


def lane_library(work: Work) -> Path:
    """The library of a function as a loop over lanes. Raises NoCompiler, or NotPrintable for one without that form."""
    return toolchain.library(*_source(work, "lanes"))


def lane_kernel(work: Work) -> Way:
    """A function as a loop over lanes. Raises what `lane_library` raises."""
    return Lanes(work, lane_library(work))


def place(work: Work, way: str) -> Path:
    """Where the library of a way, `lanes` or `casadi-c`, is kept, whether it is there or not. Raises NoCompiler."""
    return toolchain.place(*_source(work, way))


def _source(work: Work, way: str) -> tuple[str, str, tuple[str, ...]]:
    """Name, C text and flags of a function's library in a way, `lanes` or `casadi-c`. Raises what its text raises."""
    if way == "lanes":
        return work.function.name(), work.loop, toolchain.loop_flags(work.passes)
    return work.function.name(), casadi_text(work), work.passes


def foreseen(work: Work) -> str:
    """Name of the fastest way that there should be here, without compiling anything."""
    try:
        toolchain.compiler()
    except NoCompiler:
        return NAMES[-1]
    return next(name for name in allowed() if name != "lanes" or _printable(work))


def _printable(work: Work) -> bool:
    try:
        return bool(work.varying and work.loop)
    except loops.NotPrintable:
        return False


def kept(work: Work) -> bool:
    """Whether the fastest way has been compiled before, so that it need only be loaded."""
    way = foreseen(work)
    try:
        return way != NAMES[-1] and toolchain.sound(place(work, way))
    except (NoCompiler, OSError):
        return False


def allowed() -> tuple[str, ...]:
    """Names of the ways that the variable PLANTER_KERNELS allows: the one it names and all slower ones, else all."""
    fastest = os.environ.get("PLANTER_KERNELS", NAMES[0])
    return NAMES[NAMES.index(fastest) :] if fastest in NAMES else NAMES


def fastest(work: Work) -> Way:
    """The fastest way that there is here; where nothing can be compiled, one warning says why."""
    for name in allowed():
        try:
            if name == "lanes" and work.varying:
                return lane_kernel(work)
            if name == "casadi-c":
                return casadi_c(work)
        except loops.NotPrintable:
            continue
        except NoCompiler as reason:
            toolchain.warn(reason)
            break
    return virtual_machine(work)
