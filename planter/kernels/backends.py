"""Three ways to evaluate a function over lanes: vector loops, CasADi's own C, CasADi's virtual
machine.

Each takes the inputs as arrays of shape (rows, lanes) or, shared by all lanes, (rows, columns), and
returns outputs (rows, lanes), or (rows, 1) summed over the lanes. All agree to 1e-12.

CasADi lets other threads run during a call, so each thread evaluates in its own memory, without a
lock. CasADi's functions are built one at a time, and a fork waits for that. `multiprocessing` forks
by default on Linux up to Python 3.13, and in the child only the forking thread goes on: a lock that
another thread holds would never open again. The lock that `functools.cached_property` has before
Python 3.12 is therefore replaced in the child.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import FrameType
from typing import Any, Protocol, TypeVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.kernels import toolchain
from planter.kernels.compiler import CompilerError, find_compiler
from planter.kernels.lane_graph import LaneGraph, NotPrintableError
from planter.kernels.lane_source import print_file

T = TypeVar("T")

_defers = False
"""Whether the main thread is within a call that a Ctrl-C waits for."""


def defer_interrupt(call: Callable[[], T]) -> T:
    """Turn a Ctrl-C within a call into KeyboardInterrupt after it: inside, CasADi's wrappers make
    other errors of it.

    What asks between its steps, as CasADi's solvers do, ends the call then. Calls within such a
    call cost nothing more.
    """
    global _defers
    if _defers or threading.current_thread() is not threading.main_thread():
        return call()
    before = signal.getsignal(signal.SIGINT)
    if not callable(before):
        return call()
    pending: list[tuple[int, FrameType | None]] = []

    def note(number: int, frame: FrameType | None) -> None:
        pending.append((number, frame))
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    _defers = True
    try:
        result = call()
    except BaseException:
        if not pending:
            raise
    finally:
        _defers = False
        signal.signal(signal.SIGINT, before)
    if pending:
        before(*pending[0])
        raise KeyboardInterrupt
    return result


def guard_fork(lock: Any) -> None:
    """Let a fork wait for a reentrant lock, so that its child finds it open."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(
            before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release
        )


def _renew_locks() -> None:
    """Renew the locks of all cached properties: the child computes the values that another thread
    was computing.
    """
    for held_object in gc.get_objects():
        if type(held_object) is cached_property:
            vars(held_object)["lock"] = threading.RLock()


if sys.version_info < (3, 12) and hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_locks)


Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

LARGE_FUNCTION = 10_000
"""Instructions from which a function is compiled with fewer passes."""
MAX_LOOP_SIZE = 20_000
"""Instructions of a loop over lanes at most: one of 84,000 takes a compiler half an hour, CasADi's
own C a second.
"""


@dataclass(frozen=True)
class LaneTask:
    """A function to be evaluated: `varying` inputs have a column for each lane; `summed` outputs
    are added up.
    """

    function: ca.Function
    varying: tuple[str, ...]
    summed: bool

    @property
    def size(self) -> int:
        return int(self.function.n_instructions())

    @property
    def is_straight(self) -> bool:
        """Whether the function is straight-line code, which neither fails nor looks for a
        Ctrl-C.
        """
        return bool(self.function.is_a("SXFunction"))

    @cached_property
    def loop(self) -> str:
        """The function as a loop over lanes.

        Raises NotPrintableError if it has no such form, or is too large.
        """
        return print_file(
            [LaneGraph.from_function(self.function, self.varying, MAX_LOOP_SIZE)], [self.summed]
        )

    @property
    def passes(self) -> tuple[str, ...]:
        return toolchain.FEW_PASSES if self.size > LARGE_FUNCTION else toolchain.OPTIMISED


CACHE_BYTES = 16_000_000
"""Memory that a kernel keeps in each thread for the numbers of lanes it was last called with; the
last always.
"""

_BUILD_LOCK = threading.RLock()
guard_fork(_BUILD_LOCK)


class VirtualMachine:
    """A function over lanes by the virtual machine, or by a compiled function in its place."""

    def __init__(self, work: LaneTask, function: ca.Function | None = None) -> None:
        self.name = "casadi-vm" if function is None else "casadi-c"
        self.work, self.function = work, function or work.function
        self._calls = _Calls(self._bind)

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]:
        if not count:  # CasADi maps over no fewer than one lane
            sizes = map(self.function.size_out, range(self.function.n_out()))
            return [np.zeros((height, width if self.work.summed else 0)) for height, width in sizes]
        return self._calls[count](arrays)

    def _bind(self, count: int) -> _Call:
        is_single = count == 1 or not self.work.varying
        function = self.function if is_single else self._map(count)
        return _Call(function, is_single and self.work.is_straight)

    def _map(self, count: int) -> ca.Function:
        names, outputs = self.function.name_in(), self.function.n_out()
        shared = [i for i, name in enumerate(names) if name not in self.work.varying]
        reduced = list(range(outputs)) if self.work.summed else []
        return self.function.map(self.function.name(), "serial", count, shared, reduced)


class _Calls(threading.local):
    """Calls of a thread by their number of lanes: the last used, together in `KEPT_BYTES`."""

    def __init__(self, bind: Callable[[int], _Call]) -> None:
        self._bind = bind
        self._kept: OrderedDict[int, _Call] = OrderedDict()

    def __getitem__(self, count: int) -> _Call:
        if count not in self._kept:
            with _BUILD_LOCK:
                self._kept[count] = self._bind(count)
            self._forget()
        self._kept.move_to_end(count)
        return self._kept[count]

    def _forget(self) -> None:
        total = sum(call.bytes for call in self._kept.values())
        while total > CACHE_BYTES and len(self._kept) > 1:
            total -= self._kept.popitem(last=False)[1].bytes


class _Call:
    """A CasADi function on its own memory: no matrices are made for a call."""

    def __init__(self, function: ca.Function, is_straight: bool) -> None:
        self.function = function
        self._inputs = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self._outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self._places = [_find_nonzeros(function.sparsity_out(i)) for i in range(function.n_out())]
        self._shapes = [function.size_out(i) for i in range(function.n_out())]
        self.bytes = 8 * function.sz_w() + sum(
            memory.nbytes for memory in (*self._inputs, *self._outputs)
        )
        self._run = bind_memory(function, self._inputs, self._outputs, is_straight)

    def __call__(self, arrays: Sequence[Array]) -> list[Array]:
        for memory, array in zip(self._inputs, arrays, strict=True):
            memory[:] = array.ravel(order="F")
        self._run()
        return [self._filled(i) for i in range(len(self._outputs))]

    def _filled(self, index: int) -> Array:
        shape, places, values = self._shapes[index], self._places[index], self._outputs[index]
        if places is None:
            full = values.copy()
        else:
            full = np.zeros(shape[0] * shape[1])
            full[places] = values
        return full.reshape(shape, order="F")


def bind_memory(
    function: ca.Function, inputs: Sequence[Array], outputs: Sequence[Array], is_straight: bool
) -> Callable[[], None]:
    """Return a call of a CasADi function on memory that the caller keeps: contiguous numbers of all
    inputs and outputs, column by column, without what is structurally zero.

    The call raises RuntimeError if the evaluation fails. For straight-line code nothing has to be
    deferred or asked for: what that takes is longer than most functions.
    """
    # `Function.call` makes matrices for every call
    buffer: Any
    buffer, run = function.buffer()
    run.buffer = buffer  # the call has only its address
    for i, memory in enumerate(inputs):
        buffer.set_arg(i, memory.data)
    for i, memory in enumerate(outputs):
        buffer.set_res(i, memory.data)

    def call() -> None:
        defer_interrupt(run)
        if buffer.ret():
            raise RuntimeError("the evaluation failed")

    return run if is_straight else call


def _find_nonzeros(sparsity: ca.Sparsity) -> NDArray[np.int64] | None:
    """Places of what a sparse matrix holds, column by column; None for a dense one."""
    if sparsity.is_dense():
        return None
    return np.array(sparsity.find(), dtype=np.int64)


BACKENDS = ("lanes", "casadi-c", "casadi-vm")


class Backend(Protocol):
    """A way to evaluate a function."""

    name: str

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]: ...


class LaneBackend:
    """A loop over lanes in vector instructions."""

    name = "lanes"

    def __init__(self, work: LaneTask, library: Path) -> None:
        self.work, self.library = work, library
        self._shapes = [work.function.size_out(i) for i in range(work.function.n_out())]
        self._varies = [name in work.varying for name in work.function.name_in()]
        (self.loop,) = toolchain.load_functions(library, work.function.name())
        self.loop.restype = None

    def __call__(self, arrays: Sequence[Array], count: int) -> list[Array]:
        pairs = zip(arrays, self._varies, strict=True)
        inputs = [
            np.ascontiguousarray(a) if varies else np.asfortranarray(a) for a, varies in pairs
        ]
        outputs = self.memory(count)
        self.loop(*self._arguments(inputs, outputs, count))
        return self.results(outputs)

    def memory(self, count: int) -> list[Array]:
        """Return the memory of the loop's results: a row per element of an output, by columns, over
        the lanes.
        """
        columns = 1 if self.work.summed else count
        return [np.empty((height * width, columns)) for height, width in self._shapes]

    def results(self, memory: Sequence[Array]) -> list[Array]:
        """The outputs in what the loop has written; those of one column are the memory itself."""
        return [
            _side_by_side(elements, *shape)
            for elements, shape in zip(memory, self._shapes, strict=True)
        ]

    def prepared(
        self, inputs: Sequence[Array], outputs: Sequence[Array], count: int
    ) -> Callable[[], object]:
        """The loop on arrays as they are laid out for it; who calls it keeps them."""
        return partial(self.loop, *self._arguments(inputs, outputs, count))

    @staticmethod
    def _arguments(
        inputs: Sequence[Array], outputs: Sequence[Array], count: int
    ) -> Iterator[object]:
        yield ctypes.c_long(count)
        for array in (*inputs, *outputs):
            yield ctypes.c_void_p(array.ctypes.data)


def _side_by_side(elements: Array, height: int, width: int) -> Array:
    """A matrix for each lane, its elements column by column, (height width, lanes), as (height,
    lanes width).
    """
    # a column is laid out as the caller wants it
    if width == 1:
        return elements
    lanes = elements.shape[1]
    return elements.reshape(width, height, lanes).transpose(1, 2, 0).reshape(height, lanes * width)


def _library_source(work: LaneTask, way: str) -> tuple[str, str, tuple[str, ...]]:
    """Name, C text and flags of a function's library in a way, `lanes` or `casadi-c`.

    Raises what its text raises.
    """
    name = work.function.name()
    if way == "lanes":
        return name, work.loop, toolchain.loop_flags(work.passes)
    generator = ca.CodeGenerator(f"{name}.c")
    generator.add(work.function)
    return name, str(generator.dump()), work.passes


def build_library(work: LaneTask, way: str) -> Path:
    """Return the library of a function in a way, `lanes` or `casadi-c`.

    Raises CompilerError, or NotPrintableError for a loop over lanes.
    """
    return toolchain.build_library(*_library_source(work, way))


def build_compiled(work: LaneTask, way: str) -> Backend:
    """Return a function in a way, `lanes` or `casadi-c`. Raises what `build_library` raises."""
    path, name = build_library(work, way), work.function.name()
    if way == "lanes":
        return LaneBackend(work, path)
    toolchain.load_functions(path, name)
    return VirtualMachine(work, ca.external(name, str(path)))


def predict_backend(work: LaneTask) -> str:
    """Name of the fastest way that there should be here, without compiling anything."""
    try:
        find_compiler()
    except CompilerError:
        return BACKENDS[-1]
    return next(name for name in list_allowed() if name != "lanes" or _is_printable(work))


def _is_printable(work: LaneTask) -> bool:
    try:
        return bool(work.varying and work.loop)
    except NotPrintableError:
        return False


def is_compiled(work: LaneTask) -> bool:
    """Whether the fastest way has been compiled before, so that it need only be loaded."""
    way = predict_backend(work)
    try:
        return way != BACKENDS[-1] and toolchain.is_intact(
            toolchain.library_path(*_library_source(work, way))
        )
    except (CompilerError, OSError):
        return False


def list_allowed() -> tuple[str, ...]:
    """Names of the ways that the variable PLANTER_KERNELS allows: the one it names and all slower
    ones, else all.
    """
    fastest = os.environ.get("PLANTER_KERNELS", BACKENDS[0])
    return BACKENDS[BACKENDS.index(fastest) :] if fastest in BACKENDS else BACKENDS


def select_fastest(work: LaneTask) -> Backend:
    """The fastest way that there is here; where nothing can be compiled, one warning says why."""
    for way in list_allowed()[:-1]:
        try:
            if way != "lanes" or work.varying:
                return build_compiled(work, way)
        except NotPrintableError:
            continue
        except CompilerError as reason:
            toolchain.warn_once(reason)
            break
    return VirtualMachine(work)
