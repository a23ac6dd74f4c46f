"""A program: CasADi functions, one after another, on vectors of numbers that inputs and outputs are named after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.kernels.kernel import Kernel
from planter.kernels.work import Array


@dataclass(frozen=True)
class Step:
    """A function; inputs that vary over `lanes` are rows of numbers, and so are then its outputs."""

    function: ca.Function
    lanes: tuple[str, ...] = ()


class Program:
    """Steps that take what is `given` or what a step before has found; each of their functions has a name of its own.

    All vectors are flat: what varies over lanes row by row, other matrices column by column. Inside a program a name
    belongs to one vector alone.
    """

    def __init__(self, name: str, given: Mapping[str, Array], steps: Sequence[Step]) -> None:
        self.name, self.steps = name, steps
        self.given = {key: np.asarray(value, dtype=float).ravel() for key, value in given.items()}
        self.sizes = {key: len(value) for key, value in self.given.items()}
        for step in steps:
            f = step.function
            self.sizes |= {key: f.numel_out(key) * self.count(step) for key in f.name_out()}

    def count(self, step: Step) -> int:
        """How many lanes a step has."""
        counts = {self.sizes[name] // step.function.numel_in(name) for name in step.lanes}
        assert len(counts) <= 1, f"{step.function.name()}: lanes of different numbers"
        return counts.pop() if counts else 1

    @cached_property
    def offsets(self) -> dict[str, int]:
        """Where each vector begins, all of them one after another: what is given first."""
        ends = np.cumsum([0, *self.sizes.values()]).tolist()
        return dict(zip(self.sizes, ends, strict=False))

    @property
    def size(self) -> int:
        """How many numbers all vectors have together."""
        return sum(self.sizes.values())

    @cached_property
    def _kernels(self) -> list[Kernel]:
        return [Kernel(step.function, lanes=step.lanes) for step in self.steps]

    def __call__(self, **changed: Array) -> dict[str, Array]:
        """All vectors by name, from what is given, some of it changed."""
        found = self.given | changed
        for step, kernel in zip(self.steps, self._kernels, strict=True):
            known = found
            inputs = {name: self._matrix(step, name, known[name]) for name in step.function.name_in()}
            found = known | {name: _flat(step, value) for name, value in kernel(**inputs).items()}
        return found

    @staticmethod
    def _matrix(step: Step, name: str, vector: Array) -> Array:
        rows, columns = step.function.size_in(name)
        return vector.reshape(rows, -1) if name in step.lanes else vector.reshape((rows, columns), order="F")


def _flat(step: Step, value: Array) -> Array:
    return value.ravel() if step.lanes else value.T.ravel()
