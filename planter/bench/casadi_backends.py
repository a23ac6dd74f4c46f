"""CasADi: from a design to objective, gradient and Hessian in one function, in its virtual machine
or in its own C.

Both have what our own kernels have: the share of one side at each lane, a hoisted prologue whose
tangent crosses the cut, and separate memory, so that a call makes no matrices. The angles are a
loop that CasADi prints (`map`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from planter.bench.case import Absent, BenchmarkCase, Call, Contender, LeanFunction, compile_to_c
from planter.kernels import Array, toolchain
from planter.kernels.compiler import CompilerError, find_compiler
from planter.planting.objective import Weights, evaluate_many

BUILT = (
    "one function, share of a side in a loop over the lanes, prologue and its tangent "
    "hoisted, own memory"
)


def express_spread(
    weights: Weights, values: ca.MX, slopes: ca.MX | None = None
) -> tuple[ca.MX, ca.MX, ca.MX]:
    """Return the weighted spread of values (n,), its slope (n,) in them, and what slopes (n, p) add
    to its Hessian.
    """
    count = values.numel()
    f, direction = (
        ca.MX.sym("f", count),
        ca.MX.sym("direction", count, 0 if slopes is None else slopes.size2()),
    )
    spread = weights.weighted(ca.sumsqr(f - ca.sum1(f) / count) / count, ca.sqrt)
    slope = ca.gradient(spread, f)
    squared = direction.T @ ca.jtimes(slope, f, direction)
    function = ca.Function("spread", [f, direction], [spread, slope, squared])
    arguments = [values, ca.MX(count, 0) if slopes is None else slopes]
    value, rate, added = function.call(arguments, True, False)
    return value, rate, added


def build_virtual_machine(case: BenchmarkCase, work: str) -> Contender:
    """Return the virtual machine of CasADi."""
    return _contender(case, work, _function(case, work), BUILT)


def build_c_contender(case: BenchmarkCase, work: str) -> Contender:
    """Return the C code of CasADi. Raises Absent if it cannot be compiled."""
    return _compiled(case, work, ())


def build_fast_c_contender(case: BenchmarkCase, work: str) -> Contender:
    """Return CasADi's C with the floating-point freedom of the lanes."""
    return _compiled(case, work, toolchain.FAST_MATH)


def _compiled(case: BenchmarkCase, work: str, more: tuple[str, ...]) -> Contender:
    flags = (*toolchain.OPTIMISED, *more)
    try:
        built = f"{BUILT}; {' '.join((*flags, *find_compiler().flags))}"
        return _contender(case, work, compile_to_c(_function(case, work), flags), built)
    except CompilerError as reason:
        raise Absent(str(reason)) from None


def _contender(case: BenchmarkCase, work: str, function: ca.Function, built: str) -> Contender:
    if work == "batch":
        return Contender(_many(function), f"{built}; {_threads()} threads")
    return Contender(_call(LeanFunction(function), work), built)


def _call(run: LeanFunction, work: str) -> Call:
    if work == "cycle":
        return lambda x: float(run(x)[0][0, 0])
    if work == "hessian":
        return lambda x: run(x)[0]

    def both(x: Array) -> tuple[float, Array]:
        value, gradient = run(x)
        return float(value[0, 0]), gradient[:, 0]

    return both


def _threads() -> int:
    return os.cpu_count() or 1


def _many(function: ca.Function) -> Call:
    calls: dict[int, LeanFunction] = {}

    def call(designs: Array) -> Array:
        count = len(designs)
        if count not in calls:
            calls[count] = LeanFunction(function.map(count, "thread", min(_threads(), count)))
        return calls[count](designs.T)[0][0]

    return call


def _function(case: BenchmarkCase, work: str) -> ca.Function:
    graphs = Graphs(case)
    builders: dict[str, Callable[[], ca.Function]] = {
        "cycle": graphs.value,
        "cycle+gradient": graphs.gradient,
        "hessian": graphs.hessian,
        "batch": graphs.value,
    }
    return builders[work]()


class Graphs:
    """A turn as CasADi functions of the design."""

    def __init__(self, case: BenchmarkCase) -> None:
        device = case.device
        self.case, self.response = case, device.force.response
        self.x = ca.MX.sym("x", device.size)
        self.d = ca.vertcat(self.x, ca.DM(case.constants))
        self.lanes = ca.DM(case.lanes).T

    def value(self) -> ca.Function:
        """Return the function from a design to its objective."""
        h = self.response.machine.prologue(self.d)
        share = self._mapped(self.response.values_kernel)(self.lanes, self.d, h)
        return ca.Function("peer_value", [self.x], [self._objective(self._folded(share))])

    def gradient(self) -> ca.Function:
        """Return the function from a design to its objective and gradient."""
        force, rows, _ = self._slopes()
        gradient = ca.mtimes(rows, self._tiled(self._weights(force)).T)
        return ca.Function("peer_slopes", [self.x], [self._objective(force), ca.densify(gradient)])

    def hessian(self) -> ca.Function:
        """Return the Hessian as `Turns.hessian` has it: the extremes stay at their samples."""
        force, rows, (h, dh) = self._slopes()
        run = self._mapped(self.response.hessian_kernel)
        packed, slope = run(self.lanes, self.d, h, dh, self._tiled(self._weights(force)))
        curved = self.response.prologue_hessian_kernel.function(self.d, slope)
        folded = _sum(ca.horzsplit(rows, force.numel()))
        squared = express_spread(self.case.objective, force.T, folded.T)[2]
        return ca.Function(
            "peer_hessian", [self.x], [ca.densify(self._unpacked(packed) + curved + squared)]
        )

    def _mapped(self, kernel: Any) -> ca.Function:
        """A kernel's function over all lanes, as a loop; summed where the kernel is."""
        function, varying = kernel.work.function, kernel.work.varying
        shared = [i for i, name in enumerate(function.name_in()) if name not in varying]
        summed = list(range(function.n_out())) if kernel.work.summed else []
        return function.map(f"{function.name()}_turn", "serial", self.lanes.numel(), shared, summed)

    def _slopes(self) -> tuple[ca.MX, ca.MX, tuple[ca.MX, ca.MX]]:
        """Force (1, n), rows of the shares' slopes in the design (p, lanes), and h with the entries
        of its tangent.
        """
        h, jacobian = self.response.tangent(self.d)
        dh = ca.vec(jacobian.nz[:])
        share, rows = self._mapped(self.response.slopes_kernel)(self.lanes, self.d, h, dh)
        return self._folded(share), rows[1:, :], (h, dh)

    def _folded(self, share: ca.MX) -> ca.MX:
        return _sum(ca.horzsplit(share, len(self.case.angles)))

    def _tiled(self, row: ca.MX) -> ca.MX:
        return ca.repmat(row, 1, self.case.sides)

    def _objective(self, force: ca.MX) -> ca.MX:
        return (
            self.case.objective.weight_range * (ca.mmax(force) - ca.mmin(force))
            + express_spread(self.case.objective, force.T)[0]
        )

    def _weights(self, force: ca.MX) -> ca.MX:
        """Slope of the objective in the force at each angle, (1, n)."""
        extremes = (force == ca.mmax(force)) - (force == ca.mmin(force))
        return (
            express_spread(self.case.objective, force.T)[1].T
            + self.case.objective.weight_range * extremes
        )

    def _unpacked(self, packed: ca.MX) -> ca.MX:
        """The Hessian in the design from its packed rows in (angle, design)."""
        size = 1 + self.x.numel()
        places = np.zeros((size, size), dtype=int)
        rows, columns = np.tril_indices(size)
        places[rows, columns] = places[columns, rows] = np.arange(len(rows))
        return ca.reshape(packed[places[1:, 1:].ravel().tolist()], size - 1, size - 1)


def _sum(terms: Sequence[ca.MX]) -> ca.MX:
    first, *rest = terms
    for term in rest:
        first = first + term
    return first


def build_kernel_contender(case: BenchmarkCase, work: str) -> Contender:
    """Return the kernels of planter. Raises Absent if they are evaluated otherwise here."""
    turns = case.turns
    if turns.way != "lanes":
        raise Absent(f"this machine evaluates turns by {turns.way}")
    built = " ".join((*toolchain.loop_flags(toolchain.OPTIMISED), *find_compiler().flags))
    if work == "cycle":
        return Contender(turns.value, f"Turns.value; {built}")
    if work == "cycle+gradient":
        return Contender(turns.gradient, f"Turns.gradient; {built}")
    if work == "hessian":
        case.device.compile()
        kernel = case.device.force.response.hessian_kernel
        kernel.compile()
        return Contender(turns.hessian, f"Turns.hessian, {kernel.way}; {built}")
    return Contender(
        lambda designs: evaluate_many(case.device, designs, case.turns.samples).objective,
        f"evaluate_many, all cores; {built}",
    )
