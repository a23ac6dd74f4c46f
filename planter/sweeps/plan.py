"""Plans of sweeps: TOML in, a validated `Plan` out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError

from planter.errors import InputError
from planter.files.complaints import explain, lacking, refused
from planter.files.fields import Line, Problems, Section, Whole, Words, check
from planter.files.text import read_toml
from planter.sweeps.axes import Axis, axis
from planter.sweeps.points import SCHEMES, Grid, Points

MOST_ROWS = 100_000_000


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Sources = Annotated[list[Annotated[Line, Field(min_length=1)]], BeforeValidator(_listed), Field(min_length=1)]


class Map(Section):
    """A figure of an output over two inputs."""

    x: Line
    y: Line
    output: Line


class Plan(Section):
    """What a sweep varies and what it asks for.

    `machine` is one file or name, or a list of them, which is then the first input. `points` is for the schemes sobol
    and latin: how many.
    """

    name: Annotated[Line, Field(max_length=80)] = "sweep"
    description: Words = ""
    machine: Sources
    scheme: Literal["grid", "sobol", "latin"] = "grid"
    points: Annotated[Whole, Field(ge=1, le=MOST_ROWS)] | None = None
    seed: Annotated[Whole, Field(ge=0)] = 0
    outputs: list[Line] = Field(default_factory=list)
    inputs: dict[str, Annotated[Axis, BeforeValidator(axis)]]
    map: list[Map] = Field(default_factory=list)

    _folder: Path | None = PrivateAttr(default=None)
    _source: str = PrivateAttr(default="plan")

    @property
    def folder(self) -> Path | None:
        """Where its machines' files are looked for first."""
        return self._folder

    @property
    def source(self) -> str:
        return self._source

    @classmethod
    def load(cls, path: Path) -> Self:
        """The plan in a file. Raises InputError, one sentence that names file, key, value and what is allowed."""
        return cls.read(read_toml(path), str(path), path.parent)

    @classmethod
    def read(cls, table: dict[str, Any], source: str, folder: Path | None = None) -> Self:
        """The plan of a table. Raises InputError as `load`."""
        try:
            found = cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, source, cls) from None
        found._source, found._folder = source, folder
        return found

    @check
    def _something_is_varied(self) -> Problems:
        if not self.inputs:
            yield refused(
                "inputs", {}, "name at least one input to vary, or use `planter simulate` for a single design"
            )

    @check
    def _scheme_has_its_numbers(self) -> Problems:
        if self.scheme == "grid":
            if self.points is not None:
                yield refused("points", self.points, "a grid has as many as its steps and lists make")
            for name, one in self.inputs.items():
                if one.values is None and one.steps is None:
                    yield lacking(f"inputs.{name}.steps", "a range on a grid must say in how many steps")
            if len(self.inputs) > 32:
                yield refused("inputs", len(self.inputs), "a grid must have at most 32")
        elif self.points is None:
            yield lacking("points", f"the scheme {self.scheme} must say how many")
        else:
            for name, one in self.inputs.items():
                if one.steps is not None:
                    yield refused(f"inputs.{name}.steps", one.steps, f"the scheme {self.scheme} has no steps")

    @check
    def _there_are_not_too_many(self) -> Problems:
        if self.scheme == "grid" and self.inputs and self.drawn.rows > MOST_ROWS:
            yield refused("inputs", f"{self.drawn.rows} points", f"there must be at most {MOST_ROWS}")

    @property
    def axes(self) -> dict[str, Axis]:
        """The inputs by name; several machines are the first."""
        several = {"machine": Axis(values=tuple(self.machine))} if len(self.machine) > 1 else {}
        return several | self.inputs

    @property
    def drawn(self) -> Points:
        """The points."""
        axes = list(self.axes.values())
        if self.scheme == "grid":
            return Grid(axes)
        return SCHEMES[self.scheme](axes, self.points or 0, self.seed)


def load(path: str | Path) -> Plan:
    """The plan in a file. Raises InputError where there is none, or none that is allowed."""
    if not str(path).lower().endswith(".toml"):
        raise InputError(f"{path}: a plan must be a .toml file; docs/sweeps.md shows one")
    return Plan.load(Path(path))
