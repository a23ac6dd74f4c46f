"""Points of sweeps and tolerances: plans (TOML) with their axes, grids, Latin hypercubes and Sobol'
sequences, and distributions of inputs. Every chunk is drawn alone.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import erfc, exp, pi, sqrt
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, Self

import numpy as np
import scipy
from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError

from planter.errors import InputError
from planter.files.fields import (
    FileSection,
    Line,
    Problems,
    Real,
    Whole,
    Words,
    check,
    describe_problems,
    invalid_value_problem,
    missing_value_problem,
)
from planter.kernels import Array
from planter.numerics.latin_hypercube import draw_latin_hypercube
from planter.rows.job import CHUNK
from planter.text_files import read_toml

MOST_STEPS = 1_000_000


def _choice(value: Any) -> Any:
    """Return a list as a tuple.

    Raises ValueError unless it has only numbers or only texts, each once.
    """
    if not isinstance(value, list | tuple):
        return value
    texts = [isinstance(item, str) for item in value]
    numbers = [isinstance(item, int | float) and not isinstance(item, bool) for item in value]
    if value and not all(texts) and not all(numbers):
        raise invalid_value_problem("", value, "it must be a list of numbers, or a list of texts")
    if len(set(value)) < len(value):
        raise invalid_value_problem("", value, "it must have no value twice")
    return tuple(value)


class Axis(FileSection):
    """An input: a list of `values`, or a range `from` ...

    `to`, which a grid divides into `steps` values.
    """

    values: Annotated[
        tuple[Real | str, ...] | None, BeforeValidator(_choice), Field(min_length=1)
    ] = None
    low: Annotated[Real | None, Field(alias="from")] = None
    high: Annotated[Real | None, Field(alias="to")] = None
    steps: Annotated[Whole, Field(ge=2, le=MOST_STEPS)] | None = None

    @check
    def _list_or_range(self) -> Problems:
        ends = (self.low, self.high)
        if (self.values is None) == (ends == (None, None)) or (
            self.values is not None and self.steps is not None
        ):
            yield invalid_value_problem(
                "",
                self.table,
                "it must be a list of values, or { from = ..., to = ..., steps = ... }",
            )
        elif self.values is None and (
            self.low is None or self.high is None or not self.low < self.high
        ):
            yield invalid_value_problem("", self.table, "it must have from less than to")

    @property
    def table(self) -> dict[str, Any]:
        """The table of the file."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    @property
    def texts(self) -> tuple[str, ...] | None:
        """The values, if they are texts."""
        return tuple(value for value in self.values or () if isinstance(value, str)) or None

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest number."""
        numbers = self._numbers
        return float(numbers.min()), float(numbers.max())

    def list_values(self, numbers: Array) -> list[Any]:
        """Return the values of numbers (n,), texts by their indices."""
        texts = self.texts
        return numbers.tolist() if texts is None else [texts[int(index)] for index in numbers]

    @property
    def _numbers(self) -> Array:
        """The values: of texts their indices in the list, of a range its steps or its two ends."""
        if self.texts is not None:
            return np.arange(float(len(self.texts)))
        if self.values is not None:
            return np.array(self.values, dtype=float)
        assert self.low is not None
        assert self.high is not None
        return np.linspace(self.low, self.high, self.steps or 2)

    @property
    def count(self) -> int:
        """Number of values on a grid."""
        return len(self._numbers)

    def on_grid(self, indices: Any) -> Array:
        """Return the numbers at indices (n,) of the grid."""
        numbers: Array = self._numbers[indices]
        return numbers

    def from_unit(self, shares: Array) -> Array:
        """Return the numbers at shares (n,) in [0, 1) of the range or of the list."""
        if self.values is None:
            low, high = self.ends
            return low + shares * (high - low)
        return self.on_grid((shares * self.count).astype(np.int64))


def to_axis_table(entry: Any) -> Any:
    """Return the table of an axis for an entry of a file, where a list stands for its values.

    Raises ValueError if the entry is neither a list nor a table.

    >>> to_axis_table([1, 2])
    {'values': [1, 2]}
    """
    if isinstance(entry, Axis | Mapping):
        return entry
    if isinstance(entry, list | tuple):
        return {"values": list(entry)}
    raise invalid_value_problem(
        "", entry, "it must be a list of values, or { from = ..., to = ..., steps = ... }"
    )


Cube = Callable[[int, int], Array]


class UnitScale(Protocol):
    """A scale of shares of the unit interval."""

    def from_unit(self, shares: Array) -> Array:
        """Return the numbers at shares (n,) in [0, 1)."""


class Grid:
    """All combinations of the values of all axes, `rows` points; the last axis changes fastest."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        self.axes = axes
        self.shape = tuple(axis.count for axis in axes)
        self.rows = math.prod(self.shape)

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n)."""
        indices = np.unravel_index(np.arange(start, stop), self.shape)
        return np.column_stack(
            [axis.on_grid(index) for axis, index in zip(self.axes, indices, strict=True)]
        )


class UnitCubePoints:
    """A number of `rows` points of the unit cube, scaled to the axes; `cube` returns those from one
    row, the first of a chunk, to another, (m, n).
    """

    def __init__(self, axes: Sequence[UnitScale], rows: int, cube: Cube) -> None:
        self.axes, self.rows, self.cube = axes, rows, cube

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start`, the first of a chunk, to `stop`: (stop - start, n) for n
        axes.
        """
        return self.scale(self.cube(start, stop))

    def scale(self, cube: Array) -> Array:
        """Return points (m, n) of the unit cube as values on the axes."""
        return np.column_stack(
            [axis.from_unit(shares) for axis, shares in zip(self.axes, cube.T, strict=True)]
        )


def draw_random(size: int, seed: int) -> Cube:
    """Return random points; each chunk has a separate seed."""
    return lambda start, stop: chunk_generator(seed, start).random((stop - start, size))


def draw_latin(size: int, seed: int) -> Cube:
    """Return a Latin hypercube for each chunk: m rows, one in each of m slices of every axis."""
    return lambda start, stop: draw_latin_hypercube(
        stop - start, size, chunk_generator(seed, start)
    )


class SobolSequence:
    """A scrambled Sobol' sequence in [0, 1) with random access; forward is faster than backward."""

    def __init__(self, size: int, seed: int) -> None:
        self.size, self.seed = size, seed
        self._begin()

    def _begin(self) -> None:
        self._engine = scipy.stats.qmc.Sobol(self.size, rng=np.random.default_rng(self.seed))

    def __call__(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, size)."""
        if start < self._engine.num_generated:
            self._begin()
        if start > self._engine.num_generated:
            self._engine.fast_forward(start - self._engine.num_generated)
        with warnings.catch_warnings():  # SciPy warns of counts that are not a power of 2
            warnings.simplefilter("ignore", UserWarning)
            points: Array = self._engine.random(stop - start)
        return points


def chunk_generator(seed: int, start: int) -> np.random.Generator:
    """Return the random generator of the chunk that begins at row `start`."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(start // CHUNK,)))


Points = Grid | UnitCubePoints
SCHEMES: Mapping[str, Callable[[int, int], Cube]] = {"sobol": SobolSequence, "latin": draw_latin}
MOST_ROWS = 100_000_000


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Sources = Annotated[
    list[Annotated[Line, Field(min_length=1)]], BeforeValidator(_listed), Field(min_length=1)
]


class Map(FileSection):
    """A figure of an output over two inputs."""

    x: Line
    y: Line
    output: Line


class Plan(FileSection):
    """Plan of a sweep: the inputs that vary and the outputs to compute.

    `machine` is a file or a name, or a list of these, which is then the first input. `points` is
    the number of points of the schemes sobol and latin.
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
        """Load a plan from a file.

        Raises InputError, which names file, key, value and the allowed values.
        """
        return cls.read(read_toml(path), str(path), path.parent)

    @classmethod
    def read(cls, table: dict[str, Any], source: str, folder: Path | None = None) -> Self:
        """Build a plan from a table. Raises InputError as `load_plan`."""
        try:
            plan = cls.model_validate(table)
        except ValidationError as error:
            raise describe_problems(error, source, cls) from None
        plan._source, plan._folder = source, folder
        return plan

    @check
    def _check_inputs(self) -> Problems:
        if not self.inputs:
            yield invalid_value_problem(
                "inputs",
                {},
                "name at least one input to vary, or use `planter simulate` for a single design",
            )

    @check
    def _check_scheme(self) -> Problems:
        if self.scheme == "grid":
            if self.points is not None:
                yield invalid_value_problem(
                    "points",
                    self.points,
                    "steps and lists determine the points of a grid; delete this key",
                )
            for name, axis in self.inputs.items():
                if axis.values is None and axis.steps is None:
                    yield missing_value_problem(
                        f"inputs.{name}.steps", "a range of a grid needs its number of steps"
                    )
            if len(self.inputs) > 32:
                yield invalid_value_problem(
                    "inputs", len(self.inputs), "a grid must have at most 32"
                )
        elif self.points is None:
            yield missing_value_problem(
                "points", f"the scheme {self.scheme} needs a number of points"
            )
        else:
            for name, axis in self.inputs.items():
                if axis.steps is not None:
                    yield invalid_value_problem(
                        f"inputs.{name}.steps", axis.steps, f"the scheme {self.scheme} has no steps"
                    )

    @check
    def _check_size(self) -> Problems:
        if self.scheme == "grid" and self.inputs and self.sample_points.rows > MOST_ROWS:
            yield invalid_value_problem(
                "inputs", f"{self.sample_points.rows} points", f"there must be at most {MOST_ROWS}"
            )

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
        cube = SCHEMES[self.scheme](len(axes), self.seed)
        return UnitCubePoints(axes, self.points or 0, cube)


def load_plan(path: str | Path) -> Plan:
    """Load a plan from a file. Raises InputError if it cannot be read or is invalid."""
    if not str(path).lower().endswith(".toml"):
        raise InputError(f"{path}: a plan must be a .toml file; docs/sweeps.md shows one")
    return Plan.load(Path(path))


Kind = Literal["normal", "uniform", "triangular"]
ENDS = 3.0
"""Standard deviations at which a normal distribution is truncated."""
_TAIL = erfc(ENDS / sqrt(2)) / 2


@dataclass(frozen=True)
class Spread:
    """Symmetric distribution between `low` and `high` [display unit of the input]."""

    kind: Kind
    low: float
    high: float

    @property
    def centre(self) -> float:
        """Mean."""
        return (self.low + self.high) / 2

    @property
    def std(self) -> float:
        """Standard deviation.

        >>> round(Spread("uniform", 35, 45).std, 4), round(Spread("normal", -3, 3).std, 4)
        (2.8868, 0.9866)
        """
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return width / sqrt(12)
            case "triangular":
                return width / sqrt(24)
        lost = 2 * ENDS * exp(-(ENDS**2) / 2) / sqrt(2 * pi) / (1 - 2 * _TAIL)
        return width / (2 * ENDS) * sqrt(1 - lost)

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends."""
        return self.low, self.high

    def from_unit(self, shares: Array) -> Array:
        """Return the quantiles (n,) at probabilities `shares` (n,) in [0, 1]."""
        width = self.high - self.low
        match self.kind:
            case "uniform":
                return self.low + shares * width
            case "triangular":
                half = np.sqrt(np.minimum(shares, 1 - shares) / 2)
                return np.where(shares < 0.5, self.low + half * width, self.high - half * width)
        values: Array = self.centre + width / (2 * ENDS) * scipy.special.ndtri(
            _TAIL + shares * (1 - 2 * _TAIL)
        )
        return values


def draw_points(spreads: Sequence[Spread], rows: int, seed: int) -> UnitCubePoints:
    """Return random points of the distributions of the inputs."""
    return UnitCubePoints(spreads, rows, draw_random(len(spreads), seed))


class StackedPoints(UnitCubePoints):
    """Matrices of `base` points each, one below another, from one Sobol' sequence of `size`
    numbers a point.
    """

    axes: Sequence[Spread]

    def __init__(
        self, spreads: Sequence[Spread], base: int, matrices: int, size: int, seed: int
    ) -> None:
        super().__init__(spreads, base * matrices, SobolSequence(size, seed))
        self.base = base

    def block(self, start: int, stop: int) -> Array:
        """Return the points from `start` to `stop`, (stop - start, n)."""
        parts, row = [], start
        while row < stop:
            matrix, first = divmod(row, self.base)
            last = min(first + stop - row, self.base)
            parts.append(self.mix(matrix, self.cube(first, last)))
            row += last - first
        return np.vstack(parts)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return the rows (m, n) of a matrix from those of the sequence (m, size)."""
        raise NotImplementedError


class Saltelli(StackedPoints):
    """Points for Sobol' indices (Saltelli et al. 2010): A, B, and for each column, A with that
    column of B.

    A and B are the halves of one Sobol' sequence, of `base` points, a power of 2.
    """

    def __init__(self, spreads: Sequence[Spread], base: int, seed: int) -> None:
        super().__init__(spreads, base, len(spreads) + 2, 2 * len(spreads), seed)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return rows of A, of B, or of a mixed matrix."""
        size = len(self.axes)
        points = cube[:, size:] if matrix == 1 else cube[:, :size].copy()
        if matrix > 1:
            points[:, matrix - 2] = cube[:, size + matrix - 2]
        return self.scale(points)


class HalvedTolerances(StackedPoints):
    """Points of the same machines with each tolerance halved in turn: X, then for each column X
    with half deviations.

    X are the points of one Sobol' sequence, `machines` of them, so that their outputs differ by the
    tolerance alone.
    """

    def __init__(self, spreads: Sequence[Spread], machines: int, seed: int) -> None:
        super().__init__(spreads, machines, len(spreads) + 1, len(spreads), seed)

    def mix(self, matrix: int, cube: Array) -> Array:
        """Return rows of X, with one column halved behind the first matrix."""
        points = self.scale(cube)
        if matrix:
            column = points[:, matrix - 1]
            points[:, matrix - 1] += (self.axes[matrix - 1].centre - column) / 2
        return points
