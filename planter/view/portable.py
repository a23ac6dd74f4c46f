"""Programs of a machine with which a page computes the machine without Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from planter.kernels import Array
from planter.kernels.programs.program import Program
from planter.view.subject import Shown, Values


@dataclass(frozen=True)
class Input:
    """The position of a file's number in all programs: its vector and index, and the factor to SI units."""

    path: str
    vector: str
    index: int
    factor: float


@dataclass(frozen=True)
class Portable:
    """A machine in one of its models.

    `rows` are the vectors of `seen` with rows of numbers, stored one row after another, and the number of their rows;
    the vector `singles` has the named numbers of the drawing and the readings. `gradient`, if there is one, computes
    the `objective`, which is minimised, and its `gradient` with respect to the SI values of the numbers at the paths
    `design`. `assumptions` are those of the model, and `notes` list what a page omits.
    """

    inputs: Sequence[Input]
    seen: Program
    rows: Mapping[str, int]
    singles: Sequence[str]
    gradient: Program | None = None
    design: Sequence[str] = ()
    assumptions: Sequence[str] = ()
    notes: Sequence[str] = ()

    @property
    def programs(self) -> list[Program]:
        """All programs."""
        return [self.seen] if self.gradient is None else [self.seen, self.gradient]

    def at(self, values: Values, program: Program) -> dict[str, Array]:
        """Evaluate a program with changed numbers of the file, and return its vectors by name."""
        vectors = {number.vector: program.given[number.vector].copy() for number in self.inputs}
        for number in self.inputs:
            if number.path in values:
                vectors[number.vector][number.index] = values[number.path] * number.factor
        return program(**vectors)


@runtime_checkable
class Movable(Shown, Protocol):
    """A machine that a page can compute without Python."""

    def portable(self, model: str) -> Portable:
        """Return the programs that compute the numbers of the first scene.

        Raises InputError, with the reason, if the model cannot be compiled.
        """

    def handed(self, values: Values) -> str:
        """Return the text of the machine's file with changed numbers, without paths of this computer."""
