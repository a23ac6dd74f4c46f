"""CasADi functions called as lean as CasADi allows: on separate memory, no checks, interrupts not
held back.

For peers alone: everything else goes through `planter.kernels`. The few microseconds that this
layer takes in a call of CasADi's, and does not in one of a lane kernel, would stand against them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from planter.bench.variance import WeightedSum
from planter.errors import ComputationError
from planter.kernels import Array, generated, toolchain
from planter.kernels.compiler import CompilerError
from planter.planting import file, functions
from planter.planting.model import FORCE, Device
from planter.planting.objective import CycleObjective


class LeanFunction:
    """A function with dense outputs; inputs of any shape with as many numbers as it takes, column
    by column.
    """

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
        """Return the outputs, (rows, columns) each."""
        for memory, array in zip(self._inputs, arrays, strict=True):
            memory[:] = array if array.ndim == 1 else array.ravel(order="F")
        self._run()
        if self._buffer.ret():
            raise ComputationError("a function of CasADi's did not succeed")
        return [memory.copy() for memory in self._outputs]


def compile_to_c(
    function: ca.Function, flags: tuple[str, ...] = toolchain.OPTIMISED
) -> ca.Function:
    """Return the function in CasADi's own C. Raises CompilerError if it cannot be compiled."""
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    path = toolchain.build_library(function.name(), generator.dump(), flags)
    toolchain.load_library(path)
    return ca.external(function.name(), str(path))


def compile_if_possible(function: ca.Function) -> ca.Function:
    """Return the function in CasADi's own C, or unchanged if it cannot be compiled."""
    try:
        return compile_to_c(function)
    except CompilerError:
        return function


MACHINE = "wang2017"
EXACT = 1e-10
"""Ways must agree to this, relative to the largest entry of what they find."""

Call = Callable[[Array], Any]
"""From a design (p,) to its objective; to that and its gradient (p,); to its Hessian (p, p); from
designs (m, p) to their objectives (m,).
"""


class Absent(Exception):
    """Raised if a way is not installed or cannot do a task; the message is the reason."""


@dataclass(frozen=True)
class Contender:
    """A way to do a task: its function, its description, and the relative tolerances of the parts
    of its result.
    """

    call: Call
    built: str
    tolerances: tuple[float, ...] = (EXACT, EXACT)


class BenchmarkCase:
    """The objective of a built-in machine over a turn, and designs drawn from its box.

    Where both sides of a device are equal, F(phi) = S(phi) + S(phi - pi) with the share S of one
    side: `lanes` are the angles at which S is wanted. Every way may use this, and what the prologue
    h and its tangent dh save.
    """

    def __init__(self, name: str = MACHINE, samples: int | None = None) -> None:
        self.device = Device(file.load(name))
        self.turns = CycleObjective(self.device, samples)
        self.objective, self.constants = self.turns.objective, self.device.constants
        self.sides = len(self.turns.offsets)
        self.angles = self.turns.angles
        self._mapped: dict[int, LeanFunction] = {}
        self.lanes: Array = np.add.outer(self.turns.offsets, self.angles).ravel()

    def designs(self, seed: int = 0) -> Iterator[Array]:
        """Yield random designs (p,) without end; the same seed yields the same ones."""
        rng = np.random.default_rng(seed)
        while True:
            yield self.draw_designs(rng, 1)[0]

    def draw_designs(self, rng: np.random.Generator, count: int) -> Array:
        """Return random designs (count, p) within the bounds."""
        lower, upper = self.device.lower, self.device.upper
        designs: Array = lower + rng.random((count, len(lower))) * (upper - lower)
        return designs

    def prologue(self, x: Array) -> tuple[Array, Array]:
        """Return h (k,) and dh (k, p) of a design, by CasADi's C, unchecked: for ways without a
        prologue.
        """
        h, dh = self._prologue(self.values(x))
        return h[:, 0], dh

    def values(self, x: Array) -> Array:
        """Return a design (p,), then the constants: all values (v,) of the machine."""
        return np.concatenate([x, self.constants])

    def invariants(self, x: Array) -> Array:
        """Return h (k,) of a design."""
        invariants: Array = self._hoisted(x, self.constants)[0][:, 0]
        return invariants

    def prologues(self, designs: Array) -> Array:
        """Return h (k, m) of designs (m, p)."""
        count = len(designs)
        if count not in self._mapped:
            self._mapped[count] = LeanFunction(
                self._function.map("prologues", "serial", count, [1], [])
            )
        return self._mapped[count](designs.T, self.constants)[0]

    def prologue_hessian(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . h in the design."""
        return self._bending(self.values(x), weights)[0]

    @cached_property
    def _function(self) -> ca.Function:
        return compile_if_possible(self.device.functions.prologue_function)

    @cached_property
    def _hoisted(self) -> LeanFunction:
        return LeanFunction(self._function)

    @cached_property
    def _prologue(self) -> LeanFunction:
        return LeanFunction(
            compile_if_possible(_dense(self.device.force.response.prologue_kernel.function))
        )

    @cached_property
    def _bending(self) -> LeanFunction:
        return LeanFunction(
            compile_if_possible(_dense(self.device.force.response.prologue_hessian_kernel.function))
        )

    def add_sides(self, share: Any) -> Any:
        """Return the force at `angles` from the share at `lanes`, along the last axis."""
        return share.reshape(*share.shape[:-1], self.sides, -1).sum(-2)

    def build_objective(self, force: Array) -> WeightedSum:
        """Return the objective of a force (n,)."""
        return WeightedSum(self.objective, force)


def _dense(function: ca.Function) -> ca.Function:
    """Return the function with dense outputs."""
    inputs = function.mx_in()
    outputs = function.call(inputs)
    return ca.Function(function.name(), inputs, [ca.densify(output) for output in outputs])


ContactFunction = Callable[..., Any]
Sides = tuple[Any, Any]


class ArrayCode:
    """Array code of a device: `module` has its dynamics, `contacts` the pitch curves of both
    stages.
    """

    def __init__(
        self,
        device: Device,
        module: ModuleType | None = None,
        contacts: Sequence[ContactFunction] = (),
    ) -> None:
        self.module = module or load_array_module(f"planting_{device.model}")
        self.contacts = contacts or [
            load_array_module(f"curve_{s.family}").contact for s in device.stages
        ]
        self.flank = load_array_module(functions.find_flank_module(device.machine.cam.flank)).law
        sizes = [len(stage.names) for stage in device.stages]
        self._x = np.cumsum([0, device.size - sum(sizes), *sizes]).tolist()
        self._h = np.cumsum([0, *(1 + stage.terms for stage in device.stages)]).tolist()
        names = [entry["name"] for entry in device.sidecar["vectors"]["totals"]]
        self._force = names.index(FORCE)

    def side(self, xp: Any, phi: Any, x: Any, h: Any, c: Any) -> Any:
        """Return all quantities of a side at angles `phi`."""
        mounting, first, second = (x[a:b] for a, b in zip(self._x, self._x[1:], strict=False))
        curve1, curve2, hoisted = h[: self._h[1]], h[self._h[1] : self._h[2]], h[self._h[2] :]
        return self.module.lane(
            xp, phi, mounting, first, curve1, second, curve2, c, hoisted, *self.contacts, self.flank
        )

    def share(self, xp: Any, phi: Any, x: Any, h: Any, c: Any) -> Any:
        """Return the force of one side at `phi`, with half of the force that belongs to neither
        side.
        """
        side = self.side(xp, phi, x, h, c)
        nothing = [0.0] * len(side)
        return self._total(xp, (side, nothing), c) - self._total(xp, (nothing, nothing), c) / 2

    def force(self, xp: Any, phi: tuple[Any, Any], x: Any, h: Any, c: Any) -> Any:
        """Return the force of both sides, each at its own angles."""
        first, second = (self.side(xp, angles, x, h, c) for angles in phi)
        return self._total(xp, (first, second), c)

    def _total(self, xp: Any, sides: Sides, c: Any) -> Any:
        return self.module.frame(xp, *sides, c)[self._force]


def load_array_module(name: str) -> ModuleType:
    """Return a generated module of array code."""
    return generated.module(f"array.{name}")
