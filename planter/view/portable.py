"""What a machine brings so that a page can compute it without Python: programs that find what follows its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from planter.kernels import Array
from planter.kernels.programs.program import Program
from planter.view.subject import Shown, Values


@dataclass(frozen=True)
class Input:
    """Where a number of the machine's file goes in all programs: a vector, the place in it, SI per shown unit."""

    path: str
    vector: str
    index: int
    factor: float


@dataclass(frozen=True)
class Portable:
    """A machine in one of its models.

    The vectors `rows` of `seen` hold rows of numbers, those of a row one after another, as many as are told; the
    vector `singles` holds numbers, each under a name: of the drawing, and of the readings by theirs. `gradient`, where
    there is one, finds the `objective`, a number that is to be small, and its `gradient` in the SI values of the
    numbers at the paths `design`. `assumptions` are the model's, `notes` say what a page leaves out.
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
        """Both."""
        return [self.seen] if self.gradient is None else [self.seen, self.gradient]

    def at(self, values: Values, program: Program) -> dict[str, Array]:
        """All vectors of one of the programs, by name, with other numbers of the file."""
        changed = {one.vector: program.given[one.vector].copy() for one in self.inputs}
        for one in self.inputs:
            if one.path in values:
                changed[one.vector][one.index] = values[one.path] * one.factor
        return program(**changed)


@runtime_checkable
class Movable(Shown, Protocol):
    """A machine that a page can compute by itself."""

    def portable(self, model: str) -> Portable:
        """Its programs, which find the numbers of its first scene. Raises InputError where it has none, saying why."""

    def handed(self, values: Values) -> str:
        """The machine's file with other numbers for a reader elsewhere: without places on this computer."""
