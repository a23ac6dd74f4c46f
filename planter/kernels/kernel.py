"""The strict call layer: no `casadi.Function` is called but here.

CasADi fills a missing input with zeros, spreads a scalar over a vector and returns NaN; here every
input is required by name, in its exact shape and finite, and so is every output. A `BoundKernel` is
called on arrays that stay in place, a `StackedKernel` for each matrix of a stack, both without the
cost of a strict call.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from importlib import resources
from threading import get_ident
from typing import Any, Literal, Never

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.errors import ComputationError, NotFiniteError, PlanterError
from planter.kernels import backends, toolchain
from planter.kernels.backends import Array, LaneBackend, LaneTask, VirtualMachine, bind_memory
from planter.kernels.compiler import CompilerError
from planter.kernels.lane_source import print_prototype
from planter.progress import name_step


def build_finite_check(arrays: Sequence[Array]) -> Callable[[], int]:
    """Return a check: the number, from 1, of the first of some contiguous arrays that is not
    finite; 0 if all are.

    The caller must keep the arrays alive.
    """
    try:
        look = _load_finite_check()
    except CompilerError:
        return partial(_find_non_finite, arrays)
    places = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
    sizes = (ctypes.c_long * len(arrays))(*(array.size for array in arrays))
    return partial(look, ctypes.c_long(len(arrays)), places, sizes)


@cache
def _load_finite_check() -> Callable[..., int]:
    source = resources.files(__package__).joinpath("finite.c").read_text(encoding="utf-8")
    look: Callable[..., int]
    (look,) = toolchain.load_functions(
        toolchain.build_library("finite", source, toolchain.OPTIMISED), "not_finite"
    )
    return look


def _find_non_finite(arrays: Sequence[Array]) -> int:
    for number, array in enumerate(arrays, 1):
        if not is_finite(array):
            return number
    return 0


def is_finite(array: Array) -> bool:
    """Whether all numbers are finite; they are counted, in a third of the time of `all`."""
    return bool(np.count_nonzero(np.isfinite(array)) == array.size)


def bind_lanes(
    way: LaneBackend, inputs: Sequence[Array], outputs: Sequence[Array], count: int
) -> Callable[[], bool]:
    """A call that writes the outputs and says whether all numbers are finite; with others, it may
    write nothing.

    Inputs are laid out as the loop takes them, outputs (height, width lanes) row by row.
    """
    memory = [
        output if elements.shape == output.shape else elements
        for elements, output in zip(way.memory(count), outputs, strict=True)
    ]
    matrices = [index for index, output in enumerate(outputs) if memory[index] is not output]
    loop = way.prepared(inputs, memory, count)
    strange_input, strange_output = build_finite_check(inputs), build_finite_check(memory)

    def call() -> bool:
        if strange_input():
            return False
        loop()
        return not strange_output()

    def call_for_matrices() -> bool:
        all_finite = call()
        for index in matrices:
            outputs[index][:] = way.results(memory)[index]
        return all_finite

    return call_for_matrices if matrices else call


def bind_machine(
    way: VirtualMachine, inputs: Sequence[Array], outputs: Sequence[Array]
) -> Callable[[], bool]:
    """A call of straight-line code that writes the outputs and says whether all numbers are finite;
    with others, it may write nothing.

    Inputs and outputs (height, width) are dense and laid out column by column.
    """
    run = bind_memory(way.function, inputs, outputs, is_straight=True)
    inputs = [array for array in inputs if array.size]

    def call() -> bool:
        if _find_non_finite(inputs):
            return False
        run()
        return not _find_non_finite(outputs)

    return call


__all__ = ["Array", "BoundKernel", "CallError", "Kernel"]


class CallError(PlanterError):
    """A kernel was called with other inputs than it takes."""


class Kernel:
    """A CasADi function behind exact names and shapes; `lanes` inputs may carry a column for each
    lane.

    Raises CallError for a missing, unknown, misshapen or non-finite input, ComputationError for a
    non-finite output.
    """

    def __init__(
        self,
        function: ca.Function,
        lanes: Sequence[str] = (),
        summed: bool = False,
    ) -> None:
        self.function = function
        self.names: list[str] = function.name_in()
        self.outputs: list[str] = function.name_out()
        self.lanes = tuple(lanes)
        self._wanted = frozenset(self.names)
        self._shapes = [function.size_in(i) for i in range(function.n_in())]
        self.work = LaneTask(function, self.lanes, summed)
        self._way: backends.Backend = backends.VirtualMachine(self.work)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the function only: a loaded kernel uses the virtual machine until it is compiled
        there.
        """
        return Kernel, (self.function, self.lanes, self.work.summed)

    @property
    def way(self) -> str:
        """Name of the current backend: `lanes`, `casadi-c` or `casadi-vm`."""
        return self._way.name

    @property
    def loop(self) -> Any:
        """The compiled loop over lanes as a function of C; None where it is not evaluated in lanes
        (yet).
        """
        return self._way.loop if isinstance(self._way, backends.LaneBackend) else None

    def compile(self) -> None:
        """Run the fastest way that there is here from now on."""
        with name_step(f"compiling {self._name}"):
            self._way = backends.select_fastest(self.work)

    def __call__(self, **inputs: object) -> dict[str, Array]:
        """Outputs by name, each (rows, columns) [in the function's units]; lanes have a column
        each.
        """
        return self._evaluated(*self._flatten_inputs(inputs))

    def masked(self, **inputs: Array) -> tuple[dict[str, Array], NDArray[np.bool_]]:
        """Return the outputs by name, each (rows, lanes), and the lanes (n,) that are finite [units
        of the function].

        Inputs are not checked. Raises CallError for a missing, unknown or misshapen input.
        """
        arrays, count = self._flatten_inputs(inputs)
        results = dict(zip(self.outputs, self._way(arrays, count), strict=True))
        finite = np.ones(count, dtype=bool)
        for result in results.values():
            if not np.isfinite(result).all():
                finite &= np.isfinite(result).all(axis=0)
        return results, finite

    def _flatten_inputs(self, inputs: Mapping[str, object]) -> tuple[list[Array], int]:
        """Inputs in their order, as matrices of their exact shapes, and the number of lanes."""
        if inputs.keys() != self._wanted:
            raise CallError(f"{self._name} takes {self.names}, and was given {sorted(inputs)}")
        arrays = {name: self._array(value) for name, value in inputs.items()}
        count = self._count(arrays)
        return [
            self._shaped(i, name, arrays[name], count) for i, name in enumerate(self.names)
        ], count

    def _evaluated(self, arrays: Sequence[Array], count: int) -> dict[str, Array]:
        self._check_finite(arrays)
        try:
            results = self._way(arrays, count)
        except RuntimeError as error:
            raise ComputationError(
                f"{self._name} did not succeed: {str(error).strip().splitlines()[-1]}"
            ) from error
        return {
            name: self._finite(name, result)
            for name, result in zip(self.outputs, results, strict=True)
        }

    def bind(self, **inputs: Array) -> BoundKernel:
        """The kernel on arrays that stay: what is written into them is what the next call takes.

        Inputs are arrays of float64 in the shapes and units [of the function] of a call,
        contiguous: those of lanes row by row, others column by column. Raises CallError for others.
        """
        for name, array in inputs.items():
            if not (
                isinstance(array, np.ndarray) and array.dtype == np.float64 and array.flags.aligned
            ):
                raise CallError(
                    f"{self._name}: input {name} must be an array of float64 to be bound"
                )
        arrays, count = self._flatten_inputs(inputs)
        for name, array in zip(self.names, arrays, strict=True):
            lanes = name in self.lanes
            if not (array.flags.c_contiguous if lanes else array.flags.f_contiguous):
                order = "row by row" if lanes else "column by column"
                raise CallError(
                    f"{self._name}: input {name} must be contiguous, {order}, to be bound"
                )
        return BoundKernel(self, arrays, count)

    @property
    def _name(self) -> str:
        return str(self.function.name())

    @staticmethod
    def _array(value: object) -> Array:
        array = np.asarray(value, dtype=float)
        return array.reshape(-1, 1) if array.ndim < 2 else array

    def _count(self, arrays: dict[str, Array]) -> int:
        """Number of lanes: a lane input that is scalar in the function may come as a row or as a
        plain list.
        """
        for name in self.lanes:
            rows = self._shapes[self.names.index(name)][0]
            if rows == 1 and arrays[name].shape[1] == 1:
                arrays[name] = arrays[name].T
        counts = {arrays[name].shape[1] for name in self.lanes}
        if len(counts) > 1:
            raise CallError(
                f"{self._name}: lane inputs {self.lanes} have different numbers of lanes: "
                f"{sorted(counts)}"
            )
        return counts.pop() if counts else 1

    def _shaped(self, index: int, name: str, array: Array, count: int) -> Array:
        rows, columns = self._shapes[index]
        expected = (rows, count if name in self.lanes else columns)
        if array.shape != expected:
            raise CallError(
                f"{self._name}: input {name} has the shape {array.shape}; expected {expected}"
            )
        return array

    def _check_finite(self, arrays: Sequence[Array]) -> None:
        for name, array in zip(self.names, arrays, strict=True):
            if not np.isfinite(array).all():
                raise CallError(
                    f"{self._name}: input {name} is not finite: {array[~np.isfinite(array)][0]}"
                )

    def _finite(self, name: str, array: Array) -> Array:
        if not np.isfinite(array).all():
            row, lane = np.argwhere(~np.isfinite(array))[0]
            raise NotFiniteError(self._name, name, int(row), int(lane))
        return array


class BoundKernel:
    """A kernel on arrays that stay, made by `Kernel.bind`: nothing is made for a call.

    Each call writes into `outputs`, by name and in the shapes that a call of the kernel gives. The
    arrays are those of the thread that bound them; another binds its own. Raises what the kernel
    raises, and CallError in another thread.
    """

    def __init__(self, kernel: Kernel, inputs: Sequence[Array], count: int) -> None:
        self._kernel, self._inputs, self._count = kernel, inputs, count
        self._thread = get_ident()
        columns = 1 if kernel.work.summed else count
        sizes = map(kernel.function.size_out, range(len(kernel.outputs)))
        order: Literal["F", "C"] = "F" if count == 1 else "C"
        memory = (np.zeros((height, width * columns), order=order) for height, width in sizes)
        self.outputs: dict[str, Array] = dict(zip(kernel.outputs, memory, strict=True))
        self._prepare()

    def __reduce__(self) -> Never:
        raise TypeError(
            f"{self._kernel._name} is bound to arrays of this process: pickle the kernel, and "
            f"bind it there"
        )

    def __call__(self) -> dict[str, Array]:
        """Return the outputs at the current content of the inputs."""
        # seldom so, and cheaper to ask for than a lock is
        if self._kernel._way is not self._way or get_ident() != self._thread:
            self._attend()
        if not self._run():
            self._refuse()
        return self.outputs

    def _attend(self) -> None:
        if get_ident() != self._thread:
            raise CallError(
                f"{self._kernel._name} was bound in another thread: bind it to arrays of this one"
            )
        self._prepare()

    def _prepare(self) -> None:
        """Prepare the call for the current backend of the kernel."""
        self._way = self._kernel._way
        self._run: Callable[[], bool] = self._by_a_call
        outputs = list(self.outputs.values())
        if isinstance(self._way, backends.LaneBackend):
            self._run = bind_lanes(self._way, self._inputs, outputs, self._count)
        elif isinstance(self._way, VirtualMachine) and self._is_direct():
            self._run = bind_machine(self._way, self._inputs, outputs)

    def _is_direct(self) -> bool:
        """Whether the virtual machine can work on the arrays themselves."""
        function, work = self._kernel.function, self._kernel.work
        sparsities = map(function.sparsity_out, range(function.n_out()))
        is_dense = all(sparsity.is_dense() for sparsity in sparsities)
        return is_dense and work.is_straight and self._count == 1

    def _by_a_call(self) -> bool:
        for name, result in self._kernel._evaluated(self._inputs, self._count).items():
            self.outputs[name][:] = result
        return True

    def _refuse(self) -> None:
        self._kernel._check_finite(self._inputs)
        for name, array in self.outputs.items():
            self._kernel._finite(name, array)


class VectorFunction:
    """A CasADi function called with vectors by position, of which a call takes microseconds.

    Numbers are not checked: what is not finite is passed on. Each thread evaluates in its own
    memory.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self._shapes = [(function.numel_in(i),) for i in range(function.n_in())]
        self._machine = backends.VirtualMachine(LaneTask(function, (), summed=False))

    def __call__(self, *vectors: Array | float) -> list[Array]:
        """Return new outputs (rows, columns); inputs are numbers or vectors (n,).

        Raises CallError for an input of another shape.
        """
        arrays = [np.asarray(vector, dtype=float) for vector in vectors]
        shapes = [array.shape or (1,) for array in arrays]
        if shapes != self._shapes:
            names = self.function.name_in()
            raise CallError(
                f"{self.function.name()}: inputs {names} have the shapes {shapes}; expected "
                f"{self._shapes}"
            )
        return self._machine(arrays, 1)


class StackedKernel:
    """A function over lanes whose inputs `stacked` are stacks: a matrix for each call.

    Outputs are stacks (calls, rows, lanes), or (calls, rows) summed over the lanes.
    """

    def __init__(
        self,
        function: ca.Function,
        lanes: Sequence[str],
        stacked: Sequence[str],
        summed: bool = False,
    ) -> None:
        self.kernel, self.stacked = Kernel(function, lanes, summed), tuple(stacked)
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
        """Return the outputs by name; inputs are (rows, lanes) or (rows,), with the calls before
        them if stacked.

        Numbers that are not finite are passed on. Raises CallError for an input of another shape.
        """
        lanes, calls = inputs[self.kernel.lanes[0]].shape[-1], len(inputs[self.stacked[0]])
        arrays = {}
        for name, height in self._inputs.items():
            expected = (
                *([calls] if name in self.stacked else []),
                height,
                *([lanes] if self._varies(name) else []),
            )
            if inputs[name].shape != expected:
                raise CallError(
                    f"{self._name}: input {name} has the shape {inputs[name].shape}; expected "
                    f"{expected}"
                )
            arrays[name] = np.ascontiguousarray(inputs[name], dtype=float)
        columns = () if self.kernel.work.summed else (lanes,)
        results = {
            name: np.empty((calls, height, *columns)) for name, height in self._outputs.items()
        }
        if self._run is None:
            for call in range(calls):
                self._call(call, arrays, results)
        else:
            pointers = (
                ctypes.c_void_p(array.ctypes.data)
                for array in (*arrays.values(), *results.values())
            )
            self._run(ctypes.c_long(calls), ctypes.c_long(lanes), *pointers)
        return results

    def _varies(self, name: str) -> bool:
        return name in self.kernel.lanes

    def _call(self, call: int, arrays: dict[str, Array], results: dict[str, Array]) -> None:
        now = {
            name: array[call] if name in self.stacked else array for name, array in arrays.items()
        }
        shaped = {
            name: array if self._varies(name) else array[:, None] for name, array in now.items()
        }
        for name, result in self.kernel.masked(**shaped)[0].items():
            results[name][call] = result.reshape(results[name][call].shape)

    def _load(self) -> Any:
        """Return the compiled loop, None if there is no compiler."""
        try:
            library = backends.build_library(self.kernel.work, "lanes")
            path = toolchain.build_library(
                self._name, self._print(), toolchain.OPTIMISED, (library,)
            )
            (run,) = toolchain.load_functions(path, self._name)
        except CompilerError as reason:
            toolchain.warn_once(reason)
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
        return "\n".join(
            [
                f"{print_prototype(function)};",
                f"void {self._name}(long calls, long lanes, {', '.join([*inputs, *outputs])})",
                "{",
                "  for (long call = 0; call < calls; ++call)",
                f"    {function.name()}(lanes, {', '.join(self._print_arguments())});",
                "}\n",
            ]
        )

    def _print_arguments(self) -> Iterator[str]:
        for name, height in self._inputs.items():
            size = f"{height} * lanes" if self._varies(name) else f"{height}"
            yield f"{name} + call * {size}" if name in self.stacked else name
        for name, height in self._outputs.items():
            yield f"{name} + call * {height}{'' if self.kernel.work.summed else ' * lanes'}"
