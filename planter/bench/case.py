"""What every way is given: a device, the angles of a turn, designs, and what a design fixes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planter import machine, toolchain, ways
from planter.device import Device
from planter.kernels import Array
from planter.turns import Turns

MACHINE = "wang2017"
EXACT = 1e-10
"""Ways must agree to this, relative to the largest entry of what they find."""

Call = Callable[[Array], Any]
"""From a design (p,) to its objective; to that and its gradient (p,); to its Hessian (p, p); from designs (m, p) to
their objectives (m,)."""


class Absent(Exception):
    """A way is not there, or does not do this work; the message says why."""


@dataclass(frozen=True)
class Contender:
    """One way to do a work: how it is called, how it was built, and how well each part of its result must agree."""

    call: Call
    built: str
    tolerances: tuple[float, ...] = (EXACT, EXACT)


class Case:
    """The objective of a built-in machine over a turn, and designs drawn from its box.

    Where both sides of a device are equal, F(phi) = S(phi) + S(phi - pi) with the share S of one side: `lanes` are the
    angles at which S is wanted. Every way may use this, and what the prologue h and its tangent dh save.
    """

    def __init__(self, name: str = MACHINE, samples: int | None = None) -> None:
        self.device = Device(machine.load(name))
        self.turns = Turns(self.device, samples)
        self.objective, self.constants = self.turns.objective, self.device.constants
        self.sides = len(self.turns.shares.offsets)
        self.angles = self.turns.angles
        self.lanes: Array = np.add.outer(self.turns.shares.offsets, self.angles).ravel()

    def designs(self, seed: int = 0) -> Iterator[Array]:
        """Designs (p,) without end, all different; the same seed gives the same ones."""
        rng = np.random.default_rng(seed)
        while True:
            yield self.drawn(rng, 1)[0]

    def drawn(self, rng: np.random.Generator, count: int) -> Array:
        """Designs (count, p) in the box."""
        lower, upper = self.device.lower, self.device.upper
        found: Array = lower + rng.random((count, len(lower))) * (upper - lower)
        return found

    def prologue(self, x: Array) -> tuple[Array, Array]:
        """h (k,) and dh (k, p) of a design, in CasADi's C, unchecked: for ways without a prologue of their own."""
        h, dh = self._prologue([x, self.constants], 1)
        return h[:, 0], dh

    def prologues(self, designs: Array) -> Array:
        """h of designs (m, p), (k, m)."""
        found: Array = self._prologues([designs.T, self.constants], len(designs))[0]
        return found

    def bending(self, x: Array, weights: Array) -> Array:
        """Hessian (p, p) of weights . h in the design."""
        found: Array = self._bending([x, self.constants, weights], 1)[0]
        return found

    @cached_property
    def _prologue(self) -> ways.Way:
        return without_lanes(self.device.prologue_kernel.work)

    @cached_property
    def _prologues(self) -> ways.Way:
        return without_lanes(ways.Work(self.device.functions.prologue_function, ("x",), False))

    @cached_property
    def _bending(self) -> ways.Way:
        return without_lanes(self.device.prologue_hessian_kernel.work)

    def folded(self, share: Any) -> Any:
        """The force at `angles` from the share at `lanes`, along the last axis."""
        return share.reshape(*share.shape[:-1], self.sides, -1).sum(-2)

    def value(self, force: Array) -> float:
        """The objective of a force (n,)."""
        return self.objective.value(float(np.ptp(force)), float(force.var()))

    def weights(self, force: Array) -> Array:
        """Slope of the objective in the force at each angle, (n,)."""
        n = len(force)
        weights: Array = 2 / n * self.objective.spread(float(force.var()))[1] * (force - force.mean())
        weights[force.argmax()] += self.objective.weight_range
        weights[force.argmin()] -= self.objective.weight_range
        return weights


def without_lanes(work: ways.Work) -> ways.Way:
    """A function in CasADi's own C, or where there is no compiler in its virtual machine."""
    try:
        return ways.casadi_c(work)
    except toolchain.NoCompiler:
        return ways.virtual_machine(work)
