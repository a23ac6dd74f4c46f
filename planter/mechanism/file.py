"""The file of a mechanism of one's own: values for the functions that were generated of its statement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr

from planter.engine.measures import Limit, Measure, format_sum, parse_limit, parse_sum
from planter.errors import InputError
from planter.files import paths, units
from planter.files.document import Document, Origins
from planter.files.fields import Line, Pair, Real, Section, Whole
from planter.files.text import is_file, read_toml
from planter.kernels import Array
from planter.kernels.formulas import Formulas
from planter.kernels.formulas import load as formulas
from planter.optimise.sections import GeneticAlgorithm

GENERATED = "generated"


class Turn(Section):
    """Samples of a turn."""

    samples: Annotated[Whole, Field(ge=4, le=100_000)] = 360


class Objective(Section):
    """What `planter optimise` minimises: a sum of measures, over `samples` of a turn or "refined", by true extremes."""

    least: Line
    samples: Annotated[Whole, Field(ge=4, le=100_000)] | Literal["refined"] = "refined"


class Requirements(Section):
    """Limits on measures of a turn."""

    hold: Annotated[list[Line], Field(min_length=1)]


class MechanismFile(Document):
    """Values of a mechanism, bounds for the search, and the name of its functions, which stand beside the file."""

    functions: Annotated[Line, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
    folder: Line | None = None
    values: dict[str, Real]
    bounds: Annotated[dict[str, Pair], Field(default_factory=dict)]
    turn: Annotated[Turn, Field(default_factory=Turn)]
    objective: Objective | None = None
    requirements: Requirements | None = None
    genetic_algorithm: GeneticAlgorithm | None = None
    origins: Origins = Field(alias="origin")

    _folder: Path = PrivateAttr(default=Path())

    @property
    def model(self) -> Formulas:
        """The generated functions."""
        return formulas(self.functions, self._folder)

    @property
    def least(self) -> tuple[Measure, ...]:
        """The measures of the file's sum; none if it has no [objective]. Raises InputError for what is no sum."""
        if self.objective is None:
            return ()
        return parse_sum(self.objective.least, f"{self.source}: objective.least =")

    @property
    def limits(self) -> tuple[Limit, ...]:
        """The limits of the file's [requirements]. Raises InputError for what is none."""
        texts = [] if self.requirements is None else self.requirements.hold
        return tuple(parse_limit(text, f"{self.source}: requirements.hold[{i}] =") for i, text in enumerate(texts))

    def with_numbers(self, changes: Mapping[str, float]) -> Self:
        """Return a copy with some numbers set, and the same functions. Raises InputError as `load`."""
        changed = super().with_numbers(changes)
        _check(changed)
        return changed

    def moved_to(self, values: Mapping[str, float]) -> Self:
        """The same with other values, by key."""
        return self.with_numbers({f"values.{key}": value for key, value in values.items()})

    def written_table(self) -> dict[str, Any]:
        """Return the table with whole paths of the functions' folder and of curves, to be written anywhere."""
        table = self.table() | {"folder": str(self._folder)}
        if self.objective is not None:
            table["objective"]["least"] = format_sum([term.with_whole_paths(self.source) for term in self.least])
        if self.requirements is not None:
            holds = [replace(limit, measure=limit.measure.with_whole_paths(self.source)) for limit in self.limits]
            table["requirements"]["hold"] = [str(limit) for limit in holds]
        return table

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
        """Name, unit, meaning and key of every value, in the order in which the functions take them."""
        found: list[dict[str, str]] = self.model.sidecar["vectors"]["data"]
        return found

    def data(self) -> Array:
        """The values (n,) as the functions take them, in SI."""
        import numpy as np

        return np.array([self.si(entry["shown"]) for entry in self.entries])


def load(source: str | Path, changes: Mapping[str, float] | None = None) -> MechanismFile:
    """Return the file of a mechanism by its path, or by NAME for NAME.toml here or in ``generated/``.

    ``changes`` holds other values by key, in the unit that the key ends in: ``{"r_mm": 50}``. Raises InputError if
    there is no file, or for a key or value that is not allowed, with what is.
    """
    place = path(str(source))
    found = MechanismFile.read(read_toml(place), str(place), changes)
    found._folder = _functions(place, found)
    _check(found)
    return found


def made(table: Mapping[str, Any], source: str, folder: Path) -> MechanismFile:
    """The file of a table, whose functions are in a folder. Raises InputError as `load`."""
    found = MechanismFile.read(table, source)
    found._folder = folder
    _check(found)
    return found


def path(source: str) -> Path:
    """The file that is meant by its path, or by its name here or in ``generated/``. Raises InputError for none."""
    near = [Path(source)] if source.endswith(".toml") else [Path(f"{source}.toml"), Path(GENERATED, f"{source}.toml")]
    for place in near:
        if is_file(place):
            return place
    places = " or ".join(map(str, near))
    raise InputError(f"{source}: there is no {places}; `planter derive FILE.py` writes one beside the generated code")


def _functions(path: Path, file: MechanismFile) -> Path:
    """The folder of the generated functions: that which is named, the file's own, or ``generated/`` in it."""
    name, own = file.functions, [] if file.folder is None else [path.parent / file.folder]
    for folder in (*own, path.parent, path.parent / GENERATED):
        if (folder / f"{name}.json").is_file():
            return folder.resolve()
    allowed = f"{name}.py and {name}.json must stand beside the file or in {GENERATED}/ there"
    raise InputError(f"{path}: functions = {name} is not allowed: {allowed}; `planter derive FILE.py` writes them")


def _check(found: MechanismFile) -> None:
    """The values are those that the functions take. Raises InputError."""
    known = {entry["shown"].rpartition(".")[2]: entry["meaning"] for entry in found.entries}
    _ = found.least, found.limits
    for section, given in (("values", found.values), ("bounds", found.bounds)):
        for key in given:
            if key not in known:
                close = paths.close(key, known)
                hint = f"did you mean {close[0]}? " if close else ""
                raise InputError(f"{found.source}: {section}.{key} is not allowed: {hint}there are {', '.join(known)}")
    for key, value in found.values.items():
        if value < 0 and units.suffix(key) == "_kg":  # products of inertia may be
            raise found.input_error(f"values.{key}", "it must not be negative")
    lacking = [f"{key} ({meaning})" for key, meaning in known.items() if key not in found.values]
    if lacking:
        raise InputError(f"{found.source}: [values] lacks {', '.join(lacking)}")
    for key, (lower, upper) in found.bounds.items():
        if not lower < upper:
            raise InputError(
                f"{found.source}: bounds.{key} = [{lower:g}, {upper:g}] is not allowed: "
                "it must be [lower, upper] with lower < upper"
            )
