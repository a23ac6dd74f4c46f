"""What every way is given: a device, the angles of a turn, designs, and what a design fixes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.bench.lean import Lean, fastest
from planter.kernels import Array
from planter.optimise.spread import Weighed
from planter.planting import file
from planter.planting.model import Device
from planter.planting.turns import Turns

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
        self.device = Device(file.load(name))
        self.turns = Turns(self.device, samples)
        self.objective, self.constants = self.turns.objective, self.device.constants
        self.sides = len(self.turns.offsets)
        self.angles = self.turns.angles
        self._mapped: dict[int, Lean] = {}
        self.lanes: Array = np.add.outer(self.turns.offsets, self.angles).ravel()

    def designs(self, seed: int = 0) -> Iterator[Array]:
        """Designs (p,) without end, all different; the same seed gives the same ones."""
        rng = np.random.default_rng(seed)
        while True:
            yield self.draw_designs(rng, 1)[0]

    def draw_designs(self, rng: np.random.Generator, count: int) -> Array:
        """Designs (count, p) in the box."""
        lower, upper = self.device.lower, self.device.upper
        designs: Array = lower + rng.random((count, len(lower))) * (upper - lower)
        return designs

    def prologue(self, x: Array) -> tuple[Array, Array]:
        """h (k,) and dh (k, p) of a design, in CasADi's C, unchecked: for ways without a prologue."""
        h, dh = self._prologue(self.values(x))
        return h[:, 0], dh

    def values(self, x: Array) -> Array:
        """Return a design (p,), then the constants: all values (v,) of the machine."""
        return np.concatenate([x, self.constants])

    def hoisted(self, x: Array) -> Array:
        """h (k,) alone."""
        invariants: Array = self._hoisted(x, self.constants)[0][:, 0]
        return invariants

    def prologues(self, designs: Array) -> Array:
        """h of designs (m, p), (k, m)."""
        count = len(designs)
        if count not in self._mapped:
            self._mapped[count] = Lean(self._function.map("prologues", "serial", count, [1], []))
        return self._mapped[count](designs.T, self.constants)[0]

    def bending(self, x: Array, weights: Array) -> Array:
        """Hessian (p, p) of weights . h in the design."""
        return self._bending(self.values(x), weights)[0]

    @cached_property
    def _function(self) -> ca.Function:
        return fastest(self.device.functions.prologue_function)

    @cached_property
    def _hoisted(self) -> Lean:
        return Lean(self._function)

    @cached_property
    def _prologue(self) -> Lean:
        return Lean(fastest(_dense(self.device.force.response.prologue_kernel.function)))

    @cached_property
    def _bending(self) -> Lean:
        return Lean(fastest(_dense(self.device.force.response.prologue_hessian_kernel.function)))

    def folded(self, share: Any) -> Any:
        """The force at `angles` from the share at `lanes`, along the last axis."""
        return share.reshape(*share.shape[:-1], self.sides, -1).sum(-2)

    def weighed(self, force: Array) -> Weighed:
        """The objective of a force (n,)."""
        return Weighed(self.objective, force)


def _dense(function: ca.Function) -> ca.Function:
    """Return the function with dense outputs."""
    inputs = function.mx_in()
    outputs = function.call(inputs)
    return ca.Function(function.name(), inputs, [ca.densify(output) for output in outputs])
