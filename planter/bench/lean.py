"""CasADi functions called as lean as CasADi allows: on separate memory, no checks, interrupts not held back.

For peers alone: everything else goes through `planter.kernels`. The few microseconds that this layer takes in a call
of CasADi's, and does not in one of a lane kernel, would stand against them.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, toolchain


class Lean:
    """A function with dense outputs; inputs of any shape with as many numbers as it takes, column by column."""

    def __init__(self, function: ca.Function) -> None:
        self._inputs = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        shapes: list[tuple[int, int]] = [function.size_out(i) for i in range(function.n_out())]
        self._outputs: list[Array] = [np.zeros(shape, order="F") for shape in shapes]
        self._buffer, self._run = function.buffer()
        buffer: Any = self._buffer
        for i, memory in enumerate(self._inputs):
            buffer.set_arg(i, memory.data)
        for i, place in enumerate(self._outputs):
            buffer.set_res(i, place.ravel(order="F").data)

    def __call__(self, *arrays: Array) -> list[Array]:
        """The outputs, (rows, columns) each."""
        for memory, array in zip(self._inputs, arrays, strict=True):
            memory[:] = array if array.ndim == 1 else array.ravel(order="F")
        self._run()
        if self._buffer.ret():
            raise ComputationError("a function of CasADi's did not succeed")
        return [memory.copy() for memory in self._outputs]


def compiled(function: ca.Function, flags: tuple[str, ...] = toolchain.OPTIMISED) -> ca.Function:
    """The function in CasADi's own C. Raises NoCompiler."""
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    path = toolchain.library(function.name(), generator.dump(), flags)
    toolchain.load(path)
    return ca.external(function.name(), str(path))


def fastest(function: ca.Function) -> ca.Function:
    """The function in CasADi's own C, or, where there is no compiler, as it is."""
    try:
        return compiled(function)
    except toolchain.NoCompiler:
        return function
