"""CasADi's virtual machine, or a compiled function in its place: one lane after the other.

CasADi lets other threads run during a call, so each thread evaluates in memory of its own, without a lock. Functions
are put together one at a time, and a fork waits for that: its child has no lock that nobody opens again.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.kernels import forks
from planter.kernels.interrupts import uninterrupted
from planter.kernels.work import Array, Work

KEPT_BYTES = 16_000_000
"""Memory that a kernel keeps in each thread for the numbers of lanes it was last called with; the last always."""

_PUT_TOGETHER = threading.RLock()
forks.guard(_PUT_TOGETHER)


class VirtualMachine:
    """A function over lanes by the virtual machine, or by a compiled function in its place."""

    def __init__(self, work: Work, function: ca.Function | None = None) -> None:
        self.name = "casadi-vm" if function is None else "casadi-c"
        self.work, self.function = work, function or work.function
        self._calls = _Calls(self._mapped)

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]:
        return self._calls[count](arrays)

    def _mapped(self, count: int) -> ca.Function:
        if not self.work.varying:
            return self.function
        names, outputs = self.function.name_in(), self.function.n_out()
        shared = [i for i, name in enumerate(names) if name not in self.work.varying]
        reduced = list(range(outputs)) if self.work.summed else []
        return self.function.map(self.function.name(), "serial", count, shared, reduced)


class _Calls(threading.local):
    """Calls of a thread by their number of lanes: the last used, together in `KEPT_BYTES`."""

    def __init__(self, mapped: Callable[[int], ca.Function]) -> None:
        self._mapped = mapped
        self._kept: OrderedDict[int, _Call] = OrderedDict()

    def __getitem__(self, count: int) -> _Call:
        if count not in self._kept:
            with _PUT_TOGETHER:
                self._kept[count] = _Call(self._mapped(count))
            self._forget()
        self._kept.move_to_end(count)
        return self._kept[count]

    def _forget(self) -> None:
        total = sum(call.bytes for call in self._kept.values())
        while total > KEPT_BYTES and len(self._kept) > 1:
            total -= self._kept.popitem(last=False)[1].bytes


class _Call:
    """A CasADi function on its own memory: no matrices are made for a call."""

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self._inputs = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self._outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self._places = [_places(function.sparsity_out(i)) for i in range(function.n_out())]
        self.bytes = 8 * function.sz_w() + sum(memory.nbytes for memory in (*self._inputs, *self._outputs))
        self._buffer, self._run = function.buffer()
        buffer: Any = self._buffer
        for i, memory in enumerate(self._inputs):
            buffer.set_arg(i, memory.data)
        for i, memory in enumerate(self._outputs):
            buffer.set_res(i, memory.data)

    def __call__(self, arrays: Sequence[Array]) -> list[Array]:
        for memory, array in zip(self._inputs, arrays, strict=True):
            memory[:] = array.ravel(order="F")
        uninterrupted(self._run)
        if self._buffer.ret():
            raise RuntimeError("the evaluation failed")
        return [self._filled(i) for i in range(len(self._outputs))]

    def _filled(self, index: int) -> Array:
        shape, places = self.function.size_out(index), self._places[index]
        if places is None:
            return self._outputs[index].reshape(shape, order="F").copy()
        full = np.zeros(shape)
        full[places] = self._outputs[index]
        return full


def _places(sparsity: ca.Sparsity) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Rows and columns of what a sparse matrix holds; None for a dense one."""
    if sparsity.is_dense():
        return None
    rows, columns = (np.array(part, dtype=np.int64) for part in sparsity.get_triplet())
    return rows, columns
