"""The strict call layer: no `casadi.Function` is called but here.

CasADi fills a missing input with zeros, spreads a scalar over a vector and hands out NaN; here every input is wanted by
name, in its exact shape and finite, and so is every output.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence

import casadi as ca
import numpy as np

from planter.errors import ComputationError, PlanterError
from planter.kernels import backends
from planter.kernels.virtual import VirtualMachine
from planter.kernels.work import Array, Work

__all__ = ["Array", "CallError", "Kernel"]


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
        self._shapes = [function.size_in(i) for i in range(function.n_in())]
        self.work = Work(function, self.lanes, summed)
        self._way = backends.virtual_machine(self.work)

    @property
    def way(self) -> str:
        """How the function is evaluated now: `lanes`, `casadi-c` or `casadi-vm`."""
        return self._way.name

    @property
    def compiled(self) -> ca.Function | None:
        """The function in CasADi's own C, for the use in its graphs; None where it is evaluated otherwise."""
        return self._way.function if isinstance(self._way, VirtualMachine) and self.way == "casadi-c" else None

    def interface(self, count: int) -> ca.Function | None:
        """The compiled loop over `count` lanes for CasADi's solvers; None where it is not evaluated in lanes (yet)."""
        return self._way.interface(count) if isinstance(self._way, backends.Lanes) else None

    def compile(self, wait: bool = True) -> None:
        """Run the fastest way that there is here from now on; without waiting, from when it has been compiled."""
        if wait or backends.kept(self.work):
            self._way = backends.fastest(self.work)
        else:
            threading.Thread(target=self.compile, name=f"compile {self._name}", daemon=True).start()

    def __call__(self, **inputs: object) -> dict[str, Array]:
        """Outputs by name, each (rows, columns); lane outputs have a column for each lane."""
        if set(inputs) != set(self.names):
            raise CallError(f"{self._name} takes {self.names}, and was given {sorted(inputs)}")
        arrays = {name: self._array(name, value) for name, value in inputs.items()}
        count = self._count(arrays)
        return self._evaluated(arrays, count)

    def _evaluated(self, arrays: dict[str, Array], count: int) -> dict[str, Array]:
        arguments = [self._shaped(i, name, arrays[name], count) for i, name in enumerate(self.names)]
        try:
            results = self._way(arguments, count)
        except RuntimeError as error:
            raise ComputationError(f"{self._name} did not succeed: {str(error).strip().splitlines()[-1]}") from error
        return {name: self._finite(name, result) for name, result in zip(self.outputs, results, strict=True)}

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
            rows = self._shapes[self.names.index(name)][0]
            if rows == 1 and arrays[name].shape[1] == 1:
                arrays[name] = arrays[name].T
        counts = {arrays[name].shape[1] for name in self.lanes}
        if len(counts) > 1:
            raise CallError(f"{self._name}: lane inputs {self.lanes} have different numbers of lanes: {sorted(counts)}")
        return counts.pop() if counts else 1

    def _shaped(self, index: int, name: str, array: Array, count: int) -> Array:
        rows, columns = self._shapes[index]
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
