"""A kernel that is called for one matrix of a stack after the other, without Python between the calls."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import backends, loops, toolchain
from planter.kernels.kernel import CallError, Kernel
from planter.kernels.toolchain import NoCompiler
from planter.kernels.work import Array


class Stacked:
    """A function over lanes whose inputs `stacked` are stacks: a matrix for each call.

    Outputs are stacks (calls, rows, lanes), or (calls, rows) summed over the lanes.
    """

    def __init__(
        self, function: ca.Function, lanes: Sequence[str], stacked: Sequence[str], summed: bool = False,
        few_passes: bool = False,
    ) -> None:  # fmt: skip
        """`few_passes` are for a function that is not called often enough to pay for the compiler's time."""
        self.kernel, self.stacked = Kernel(function, lanes, summed, few_passes), tuple(stacked)
        self._inputs = {name: function.numel_in(i) for i, name in enumerate(self.kernel.names)}
        self._outputs = {name: function.numel_out(i) for i, name in enumerate(self.kernel.outputs)}
        self._run: Any = None
        self._is_compiled = False

    def compile(self) -> None:
        """Compile the function, and the loop over the calls if it is one over lanes."""
        if not self._is_compiled:
            self._is_compiled = True
            self.kernel.compile()
            self._run = self._load() if self.kernel.way == "lanes" else None

    def __call__(self, **inputs: Array) -> dict[str, Array]:
        """Return the outputs by name; inputs are (rows, lanes) or (rows,), with the calls before them if stacked.

        Numbers that are not finite are passed on. Raises CallError for an input of another shape.
        """
        lanes, calls = inputs[self.kernel.lanes[0]].shape[-1], len(inputs[self.stacked[0]])
        arrays = {}
        for name, height in self._inputs.items():
            expected = (*([calls] if name in self.stacked else []), height, *([lanes] if self._varies(name) else []))
            if inputs[name].shape != expected:
                raise CallError(f"{self._name}: input {name} has the shape {inputs[name].shape}; expected {expected}")
            arrays[name] = np.ascontiguousarray(inputs[name], dtype=float)
        columns = () if self.kernel.work.summed else (lanes,)
        results = {name: np.empty((calls, height, *columns)) for name, height in self._outputs.items()}
        if self._run is None:
            for call in range(calls):
                self._call(call, arrays, results)
        else:
            pointers = (ctypes.c_void_p(array.ctypes.data) for array in (*arrays.values(), *results.values()))
            self._run(ctypes.c_long(calls), ctypes.c_long(lanes), *pointers)
        return results

    def _varies(self, name: str) -> bool:
        return name in self.kernel.lanes

    def _call(self, call: int, arrays: dict[str, Array], results: dict[str, Array]) -> None:
        now = {name: array[call] if name in self.stacked else array for name, array in arrays.items()}
        shaped = {name: array if self._varies(name) else array[:, None] for name, array in now.items()}
        for name, result in self.kernel.masked(**shaped)[0].items():
            results[name][call] = result.reshape(results[name][call].shape)

    def _load(self) -> Any:
        """Return the compiled loop, None if there is no compiler."""
        try:
            library = backends.lane_library(self.kernel.work)
            path = toolchain.library(self._name, self._print(), toolchain.OPTIMISED, (library,))
            (run,) = toolchain.functions(path, self._name)
        except NoCompiler as reason:
            toolchain.warn(reason)
            return None
        run.restype = None
        return run

    @property
    def _name(self) -> str:
        return f"{self.kernel.function.name()}_stacked"

    def _print(self) -> str:
        """Return the C text of the loop over the calls."""
        function = self.kernel.function
        inputs = [f"const double *{name}" for name in self._inputs]
        outputs = [f"double *{name}" for name in self._outputs]
        return "\n".join([
            f"{loops.prototype(function)};",
            f"void {self._name}(long calls, long lanes, {', '.join([*inputs, *outputs])})",
            "{",
            "  for (long call = 0; call < calls; ++call)",
            f"    {function.name()}(lanes, {', '.join(self._print_arguments())});",
            "}\n",
        ])  # fmt: skip

    def _print_arguments(self) -> Iterator[str]:
        for name, height in self._inputs.items():
            size = f"{height} * lanes" if self._varies(name) else f"{height}"
            yield f"{name} + call * {size}" if name in self.stacked else name
        for name, height in self._outputs.items():
            yield f"{name} + call * {height}{'' if self.kernel.work.summed else ' * lanes'}"
