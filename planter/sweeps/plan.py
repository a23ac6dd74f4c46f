"""Plans of sweeps: a TOML file read into a validated `Plan`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError

from planter.errors import InputError
from planter.files.fields import Line, Problems, Section, Whole, Words, check, explain, lacking, refused
from planter.files.text import read_toml
from planter.sweeps.axes import Axis, to_axis_table
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
    """Plan of a sweep: the inputs that vary and the outputs to compute.

    `machine` is a file or a name, or a list of these, which is then the first input. `points` is the number of points
    of the schemes sobol and latin.
    """

    name: Annotated[Line, Field(max_length=80)] = "sweep"
    description: Words = ""
    machine: Sources
    scheme: Literal["grid", "sobol", "latin"] = "grid"
    points: Annotated[Whole, Field(ge=1, le=MOST_ROWS)] | None = None
    seed: Annotated[Whole, Field(ge=0)] = 0
    outputs: list[Line] = Field(default_factory=list)
    inputs: dict[str, Annotated[Axis, BeforeValidator(to_axis_table)]]
    map: list[Map] = Field(default_factory=list)

    _folder: Path | None = PrivateAttr(default=None)
    _source: str = PrivateAttr(default="plan")

    @property
    def folder(self) -> Path | None:
        """Folder in which machine files are looked for first."""
        return self._folder

    @property
    def source(self) -> str:
        """Path of the file, as messages begin with it."""
        return self._source

    @classmethod
    def load(cls, path: Path) -> Self:
        """Load a plan from a file. Raises InputError, which names file, key, value and the allowed values."""
        return cls.read(read_toml(path), str(path), path.parent)

    @classmethod
    def read(cls, table: dict[str, Any], source: str, folder: Path | None = None) -> Self:
        """Build a plan from a table. Raises InputError as `load`."""
        try:
            plan = cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, source, cls) from None
        plan._source, plan._folder = source, folder
        return plan

    @check
    def _check_inputs(self) -> Problems:
        if not self.inputs:
            yield refused(
                "inputs", {}, "name at least one input to vary, or use `planter simulate` for a single design"
            )

    @check
    def _check_scheme(self) -> Problems:
        if self.scheme == "grid":
            if self.points is not None:
                yield refused("points", self.points, "steps and lists determine the points of a grid; delete this key")
            for name, axis in self.inputs.items():
                if axis.values is None and axis.steps is None:
                    yield lacking(f"inputs.{name}.steps", "a range of a grid needs its number of steps")
            if len(self.inputs) > 32:
                yield refused("inputs", len(self.inputs), "a grid must have at most 32")
        elif self.points is None:
            yield lacking("points", f"the scheme {self.scheme} needs a number of points")
        else:
            for name, axis in self.inputs.items():
                if axis.steps is not None:
                    yield refused(f"inputs.{name}.steps", axis.steps, f"the scheme {self.scheme} has no steps")

    @check
    def _check_size(self) -> Problems:
        if self.scheme == "grid" and self.inputs and self.sample_points.rows > MOST_ROWS:
            yield refused("inputs", f"{self.sample_points.rows} points", f"there must be at most {MOST_ROWS}")

    @property
    def axes(self) -> dict[str, Axis]:
        """Inputs by name; if there are several machines, these are the first input."""
        machines = {"machine": Axis(values=tuple(self.machine))} if len(self.machine) > 1 else {}
        return machines | self.inputs

    @property
    def sample_points(self) -> Points:
        """Points of the scheme."""
        axes = list(self.axes.values())
        if self.scheme == "grid":
            return Grid(axes)
        return SCHEMES[self.scheme](axes, self.points or 0, self.seed)


def load(path: str | Path) -> Plan:
    """Load a plan from a file. Raises InputError if it cannot be read or is invalid."""
    if not str(path).lower().endswith(".toml"):
        raise InputError(f"{path}: a plan must be a .toml file; docs/sweeps.md shows one")
    return Plan.load(Path(path))
