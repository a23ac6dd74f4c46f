"""The strict call layer: no `casadi.Function` is called but here.

CasADi fills a missing input with zeros, spreads a scalar over a vector and hands out NaN; here every input is wanted by
name, in its exact shape and finite, and so is every output.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.compiled import compiled
from planter.errors import ComputationError, PlanterError

Array = NDArray[np.float64]


T = TypeVar("T")


def _uninterrupted(call: Callable[[], T]) -> T:
    """Let a Ctrl-C wait for the end of a call: inside, CasADi's wrappers would turn it into other errors."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        return call()
    pending: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: pending.append(number))
    try:
        result = call()
    finally:
        signal.signal(signal.SIGINT, before)
    if pending:
        raise KeyboardInterrupt
    return result


class CallError(PlanterError):
    """A kernel was called with other inputs than it takes."""


class Kernel:
    """A CasADi function behind exact names and shapes; `lanes` inputs may carry a column for each lane.

    Raises CallError for a missing, unknown, misshapen or non-finite input, ComputationError for a non-finite output.
    """

    def __init__(self, function: ca.Function, lanes: Sequence[str] = (), summed: bool = False) -> None:
        self.function = function
        self.names: list[str] = function.name_in()
        self.outputs: list[str] = function.name_out()
        self.lanes = tuple(lanes)
        self.summed = summed
        self._maps: dict[int, ca.Function] = {}

    def compile(self) -> None:
        """Run in machine code from now on, where there is a compiler."""
        self.function = compiled(self.function)
        self._maps.clear()

    def __call__(self, **inputs: object) -> dict[str, Array]:
        """Outputs by name, each (rows, columns); lane outputs have a column for each lane."""
        if set(inputs) != set(self.names):
            raise CallError(f"{self._name} takes {self.names}, and was given {sorted(inputs)}")
        arrays = {name: self._array(name, value) for name, value in inputs.items()}
        count = self._count(arrays)
        return _uninterrupted(lambda: self._evaluated(arrays, count))

    def _evaluated(self, arrays: dict[str, Array], count: int) -> dict[str, Array]:
        arguments = [self._shaped(i, name, arrays[name], count) for i, name in enumerate(self.names)]
        try:
            results = self._mapped(count)(*arguments)
        except RuntimeError as error:
            raise ComputationError(f"{self._name} did not succeed: {str(error).strip().splitlines()[-1]}") from error
        many = results if len(self.outputs) > 1 else [results]
        return {n: self._finite(n, np.asarray(r, dtype=float)) for n, r in zip(self.outputs, many, strict=True)}

    @property
    def _name(self) -> str:
        return str(self.function.name())

    @staticmethod
    def _array(name: str, value: object) -> Array:
        array = np.asarray(value, dtype=float)
        return array.reshape(-1, 1) if array.ndim < 2 else array

    def _count(self, arrays: dict[str, Array]) -> int:
        """Number of lanes: a lane input that is scalar in the function may come as a row or as a plain list."""
        for name in self.lanes:
            rows = self.function.size1_in(self.names.index(name))
            if rows == 1 and arrays[name].shape[1] == 1:
                arrays[name] = arrays[name].T
        counts = {arrays[name].shape[1] for name in self.lanes}
        if len(counts) > 1:
            raise CallError(f"{self._name}: lane inputs {self.lanes} have different numbers of lanes: {sorted(counts)}")
        return counts.pop() if counts else 1

    def _shaped(self, index: int, name: str, array: Array, count: int) -> Array:
        rows, columns = self.function.size_in(index)
        expected = (rows, count if name in self.lanes else columns)
        if array.shape != expected:
            raise CallError(f"{self._name}: input {name} has the shape {array.shape}; expected {expected}")
        if not np.isfinite(array).all():
            raise CallError(f"{self._name}: input {name} is not finite: {array[~np.isfinite(array)][0]}")
        return array

    def _finite(self, name: str, array: Array) -> Array:
        if not np.isfinite(array).all():
            row, lane = np.argwhere(~np.isfinite(array))[0]
            raise ComputationError(f"{self._name}: output {name}[{row}] is not finite in lane {lane}")
        return array

    def _mapped(self, count: int) -> ca.Function:
        if not self.lanes:
            return self.function
        if count not in self._maps:
            fixed = [i for i, name in enumerate(self.names) if name not in self.lanes]
            reduced = list(range(len(self.outputs))) if self.summed else []
            self._maps[count] = self.function.map(self._name, "serial", count, fixed, reduced)
        return self._maps[count]
