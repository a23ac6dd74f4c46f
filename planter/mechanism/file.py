"""The file of a user-defined mechanism: values for the functions that were generated from its
statement.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PrivateAttr

from planter import paths
from planter.engine.measures import Limit, Measure, format_sum, parse_sum
from planter.engine.sections import (
    GeneticAlgorithm,
    LimitsSection,
    parse_holds,
    with_whole_limits,
)
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document, Origins
from planter.files.examples import list_examples
from planter.files.fields import FileSection, Line, Pair, Real, Whole
from planter.kernels import Array
from planter.kernels.formulas import Formulas
from planter.kernels.formulas import load as formulas
from planter.kernels.generated import check_user_model
from planter.measured.section import SECTION, MeasurementSection
from planter.text_files import is_file, read_toml

GENERATED = Path("generated")


class CycleSettings(FileSection):
    """Samples of a cycle."""

    samples: Annotated[Whole, Field(ge=4, le=100_000)] = 360
    """number of angles of a cycle that are reported"""


class ObjectiveSection(FileSection):
    """Objective of `planter optimise`: a sum of measures, over `samples` of a cycle or, "refined",
    by true extremes.
    """

    least: Line
    """sum of measures that `planter optimise` minimises, such as range F_Ox"""
    samples: Annotated[Whole, Field(ge=4, le=100_000)] | Literal["refined"] = "refined"
    """number of angles that stand for the cycle, or "refined" for true extremes and integrals"""


class MechanismFile(Document):
    """Values of a mechanism, bounds for a search, and the name of its functions, which lie near the
    file.
    """

    states_goals: ClassVar[bool] = True

    functions: Annotated[Line, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
    """name of the functions that were generated from the statement"""
    folder: Line | None = None
    """folder of the functions, if they are not near the file"""
    values: dict[str, Real]
    """numbers that the functions take, by keys that end in their units"""
    bounds: Annotated[dict[str, Pair], Field(default_factory=dict)]
    """lower and upper end, within which searches move a value"""
    turn: Annotated[CycleSettings, Field(default_factory=CycleSettings)]
    objective: ObjectiveSection | None = None
    requirements: LimitsSection | None = None
    genetic_algorithm: GeneticAlgorithm | None = None
    measurement: MeasurementSection | None = None
    origins: Origins = Field(alias="origin")

    _folder: Path = PrivateAttr(default=Path())

    @property
    def model(self) -> Formulas:
        """The generated functions."""
        return formulas(self.functions, self._folder)

    @property
    def objective_terms(self) -> tuple[Measure, ...]:
        """The measures of the objective; none without [objective].

        Raises InputError if it cannot be parsed.
        """
        if self.objective is None:
            return ()
        return parse_sum(self.objective.least, f"{self.source}: objective.least =")

    @property
    def measure_limits(self) -> tuple[Limit, ...]:
        """The limits of the file's [requirements]. Raises InputError if one cannot be parsed."""
        return parse_holds(self.requirements, self.source)

    def with_numbers(self, changes: Mapping[str, float]) -> Self:
        """Return a copy with some numbers set, and the same functions.

        Raises InputError as `load`.
        """
        changed = super().with_numbers(changes)
        _check(changed)
        return changed

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return a copy with other values, by key."""
        return self.with_numbers({f"values.{key}": value for key, value in values.items()})

    def written_table(self) -> dict[str, Any]:
        """Return the table with absolute paths of the functions' folder and of curves, for a file
        in any folder.
        """
        table = self.table() | {"folder": str(self._folder)}
        if self.objective is not None:
            terms = [term.with_whole_paths(self.source) for term in self.objective_terms]
            table["objective"]["least"] = format_sum(terms)
        return with_whole_limits(table, self.measure_limits, self.source)

    @property
    def is_driven(self) -> bool:
        """Whether an angle drives the mechanism; else it moves freely."""
        return "speed" in self.model.sidecar

    @property
    def place(self) -> Path:
        """The folder of the generated functions."""
        return self._folder

    @property
    def entries(self) -> list[dict[str, str]]:
        """Name, unit, meaning and key of every value, in the order in which the functions take
        them.
        """
        entries: list[dict[str, str]] = self.model.sidecar["vectors"]["data"]
        return entries

    def data(self) -> Array:
        """Return the values (n,) in the order of the functions, in SI."""
        import numpy as np

        return np.array([self.si(entry["shown"]) for entry in self.entries])


def load(source: str | Path, changes: Mapping[str, float] | None = None) -> MechanismFile:
    """Return the file of a mechanism by its path, or by NAME for NAME.toml here or in
    ``generated/``.

    ``changes`` holds other values by key, in the unit that the key ends in: ``{"r_mm": 50}``.
    Raises InputError if there is no file, or for an invalid key or value, with what is allowed.
    """
    path = find_file(str(source))
    file = MechanismFile.read(read_toml(path), str(path), changes)
    file._folder = _find_functions(path, file)
    _check(file)
    return file


def build_from_table(table: Mapping[str, Any], source: str, folder: Path) -> MechanismFile:
    """Return the file of a table, whose functions are in a folder. Raises InputError as `load`."""
    file = MechanismFile.read(table, source)
    file._folder = folder
    _check(file)
    return file


def find_file(source: str) -> Path:
    """Return the path of a file by its path, or by its name here or in ``generated/``.

    Raises InputError for none.
    """
    file = Path(source if source.endswith(".toml") else f"{source}.toml")
    candidates = [file] if source.endswith(".toml") else [file, GENERATED / file]
    for path in candidates:
        if is_file(path):
            return path
    if source in list_examples(suffix=".toml"):
        raise InputError(
            f"{source}: this is a built-in machine, but it must be the file of a mechanism of your "
            f"own, as `planter derive` writes one"
        )
    places = " or ".join(map(str, candidates))
    raise InputError(
        f"{source}: there is no {places}; `planter derive FILE.py` writes one for a statement"
    )


def _find_functions(path: Path, file: MechanismFile) -> Path:
    """Return the folder of the generated functions: the one of the file, the file's own, or
    ``generated/`` in it.
    """
    name, named = file.functions, [] if file.folder is None else [path.parent / file.folder]
    for folder in (*named, path.parent, path.parent / GENERATED):
        if (folder / f"{name}.json").is_file():
            check_user_model(name, folder.resolve())
            return folder.resolve()
    allowed = (
        f"{name}.py and {name}.json must be in the folder of the file or in {GENERATED}/ there"
    )
    raise InputError(f"{path}: functions = {name}: {allowed}; `planter derive FILE.py` writes them")


def _check(file: MechanismFile) -> None:
    """Raise InputError unless values and bounds are those that the functions take."""
    meanings = {entry["shown"].rpartition(".")[2]: entry["meaning"] for entry in file.entries}
    _ = file.objective_terms, file.measure_limits
    for section, numbers in (("values", file.values), ("bounds", file.bounds)):
        for key in numbers:
            if key not in meanings:
                close = paths.find_similar(key, meanings)
                hint = f"did you mean {close[0]}? " if close else ""
                names = ", ".join(meanings)
                raise InputError(f"{file.source}: {section}.{key}: {hint}there are {names}")
    for key, value in file.values.items():
        if value < 0 and units.unit_suffix(key) == "_kg":  # products of inertia may be negative
            raise file.input_error(f"values.{key}", "it must not be negative")
    missing = [f"{key} ({meaning})" for key, meaning in meanings.items() if key not in file.values]
    if missing:
        raise InputError(f"{file.source}: [values] lacks {', '.join(missing)}")
    if file.measurement is not None and not file.is_driven:
        raise InputError(
            f"{file.source}: [{SECTION}] needs a cycle, but no angle drives the mechanism"
        )
    for key, (lower, upper) in file.bounds.items():
        if not lower < upper:
            raise InputError(
                f"{file.source}: bounds.{key} = [{lower:g}, {upper:g}]: lower must be below upper"
            )
