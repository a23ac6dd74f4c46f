"""Machine files: TOML in, a validated `Machine` out, every number with its unit and its origin."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, field_validator, model_validator

from planter import builtin, paths, units
from planter.complaints import SET, explain, lacking, not_allowed, refused
from planter.errors import InputError
from planter.sections import (
    Cam,
    Centroid,
    Contact,
    GeneticAlgorithm,
    Inertia,
    Mass,
    Nozzle,
    Objective,
    Operation,
    Pair,
    Real,
    Section,
    Spring,
    Stage,
    least_inertia,
)
from planter.textfile import parse_toml

_ORIGIN = re.compile(r"(paper|assumed|calibrated|measured)\b")


def _flat(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return {path: item for path, item in paths.walk(value) if not isinstance(item, dict)}


Origins = Annotated[dict[str, str], BeforeValidator(_flat)]


class Machine(Section):
    """A planting device: two gear stages on a carrier, a cam-driven nozzle on each of two sides.

    Sections hold the values as the file shows them; `si` gives the value inside. The names in `design` and
    `bounds` are open here: which ones a device needs follows from its gear families.
    """

    name: Annotated[str, Field(min_length=1, max_length=80)]
    description: str
    operation: Operation
    contact: Contact
    mass: Mass
    inertia: Inertia
    centroid: Centroid
    nozzle: Nozzle
    cam: Cam
    spring: Spring
    stage1: Stage
    stage2: Stage
    design: Annotated[dict[str, Real], Field(min_length=1)]
    bounds: dict[str, Pair]
    objective: Objective
    genetic_algorithm: GeneticAlgorithm
    origins: Origins = Field(alias="origin")

    _source: str = PrivateAttr(default="machine")
    _overridden: tuple[str, ...] = PrivateAttr(default=())

    @property
    def source(self) -> str:
        """The file or built-in name that this machine was loaded from."""
        return self._source

    @property
    def overridden(self) -> tuple[str, ...]:
        """Full paths of the values that were set on the command line."""
        return self._overridden

    def si(self, name: str) -> float:
        """The number at a path such as `mass.sun_kg` or `nozzle.hinge_A_mm[0]`, in SI units and radians.

        The last part of a path is enough where it fits one only. Raises InputError for anything else.
        """
        numbers = self.numbers()
        path = self._path(name, numbers)
        return float(numbers[path]) * units.factor(path)

    def origin(self, name: str) -> str:
        """Where a value comes from: its own entry in [origin], else its section's, else the default."""
        values = self._values()
        path = self._path(name, values)
        if any(item == path or item.startswith(f"{path}[") for item in self.overridden):
            return SET
        entries = {_full(entry, values): text for entry, text in self.origins.items()}
        holders = (path, path.partition("[")[0], path.partition(".")[0], "default")
        return next(entries[holder] for holder in holders if holder in entries)

    def numbers(self) -> dict[str, float]:
        """Every number of the file by its full path, as shown in the file."""
        return {path: value for path, value in self._values().items() if isinstance(value, int | float)}

    def table(self) -> dict[str, Any]:
        """The machine as the nested table of its file, overrides included."""
        return self.model_dump(mode="json", by_alias=True)

    def input_error(self, name: str, allowed: str, kind: type[InputError] = InputError) -> InputError:
        """The error that a value of this machine cannot be used, for checks that need more than its file.

        `allowed` says what would be right: "it must be ...".
        """
        values = self._values()
        path = self._path(name, values)
        return kind(not_allowed(self.source, path, values[path], allowed, overridden=path in self.overridden))

    def check_names(self, names: tuple[str, ...]) -> None:
        """Raise InputError unless the design holds exactly these names (those that its gear families ask for)."""
        allowed = f"the design of this device is {', '.join(names)}"
        for name in names:
            if name not in self.design:
                raise InputError(f"{self.source}: design.{name} is missing: {allowed}")
        for name, value in self.design.items():
            if name not in names:
                raise InputError(not_allowed(self.source, f"design.{name}", value, allowed))

    def with_numbers(self, changes: Mapping[str, float]) -> "Machine":
        """A copy with some numbers set on the command line; see `load` for their names.

        Raises InputError for an unknown or ambiguous name, and for a value that a file could not hold either.
        """
        numbers, table, changed = self.numbers(), self.table(), dict.fromkeys(self.overridden)
        for name, value in changes.items():
            found = _candidates(name, numbers)
            if len(found) != 1:
                allowed = _which(name, found, numbers)
                raise InputError(not_allowed(self.source, name, value, allowed, overridden=True))
            whole = isinstance(numbers[found[0]], int) and float(value).is_integer()
            table = paths.with_value(table, found[0], int(value) if whole else value)
            changed[found[0]] = None
        return _validated(table, self.source, tuple(changed))

    def _values(self) -> dict[str, Any]:
        return _values_of(self.table())

    def _path(self, name: str, values: Mapping[str, Any]) -> str:
        found = _candidates(name, values)
        if len(found) != 1:
            raise InputError(f"{self.source}: {name} is not allowed: {_which(name, found, values)}")
        return found[0]

    @field_validator("design", "bounds")
    @classmethod
    def _names_are_plain(cls, named: dict[str, Any]) -> dict[str, Any]:
        for name in named:
            if not (name.isascii() and name.isidentifier()):
                raise refused("", name, "a name must be made of letters, digits and underscores")
        return named

    @field_validator("bounds")
    @classmethod
    def _bounds_are_upright(cls, bounds: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        for name, (lower, upper) in bounds.items():
            if not lower < upper:
                raise refused(name, [lower, upper], "it must be [lower, upper] with lower less than upper")
        return bounds

    @field_validator("origins")
    @classmethod
    def _origins_are_known_words(cls, origins: dict[str, str]) -> dict[str, str]:
        for entry, text in origins.items():
            if not _ORIGIN.match(text):
                raise refused(entry, text, "it must start with paper, assumed, calibrated or measured")
        if "default" not in origins:
            raise lacking("default", "it must say where the numbers come from that have no entry of their own")
        return origins

    @model_validator(mode="after")
    def _bounds_belong_to_the_design(self) -> Self:
        for name in self.design:
            if name not in self.bounds:
                raise lacking(f"bounds.{name}", "every name in [design] must have its [lower, upper]")
        for name, pair in self.bounds.items():
            if name not in self.design:
                allowed = f"it must be a name in [design]: {', '.join(self.design)}"
                raise refused(f"bounds.{name}", pair, allowed)
        return self

    @model_validator(mode="after")
    def _inertia_fits_mass_and_centroid(self) -> Self:
        inertia, mass, centroid = self.inertia, self.mass, self.centroid
        least = {
            "J56_about_A1_kg_m2": least_inertia(mass.middle_kg, (centroid.middle_radius_mm,)),
            "J7_about_B1_kg_m2": least_inertia(mass.planet_kg, centroid.planet_xy_mm),
        }
        for key, bound in least.items():
            if getattr(inertia, key) < bound:
                allowed = f"it must be at least mass times squared centroid distance, {bound:.6g}"
                raise refused(f"inertia.{key}", getattr(inertia, key), allowed)
        return self

    @model_validator(mode="after")
    def _origins_name_something(self) -> Self:
        values = self._values()
        for entry, text in self.origins.items():
            found = _candidates(entry, values)
            if entry != "default" and len(found) != 1:
                raise refused(f"origin.{entry}", text, _which(entry, found, values))
        return self


def load(source: str | Path, overrides: Mapping[str, float] | None = None) -> Machine:
    """The machine in a file, or the built-in one of that name, with some numbers set by `overrides`.

    A name in `overrides` is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that fits one
    path only; `R3_mm` means the design value, not its bounds. Values are in the unit that the name ends in.

    Raises InputError, one sentence that names file, key, value and what is allowed.
    """
    label = str(source)
    machine = _validated(parse_toml(builtin.text(source, "planting"), label), label)
    return machine.with_numbers(overrides) if overrides else machine


def _validated(table: Mapping[str, Any], source: str, overridden: tuple[str, ...] = ()) -> Machine:
    try:
        machine = Machine.model_validate(table)
    except ValidationError as error:
        raise explain(error, source, Machine, overridden) from None
    machine._source = source
    machine._overridden = overridden
    return machine


def _values_of(table: Mapping[str, Any]) -> dict[str, Any]:
    return dict(paths.walk({key: value for key, value in table.items() if key != "origin"}))


def _candidates(name: str, values: Mapping[str, Any]) -> list[str]:
    found = paths.matching(name, values.keys())
    return [path for path in found if not path.startswith("bounds.")] or found


def _full(entry: str, values: Mapping[str, Any]) -> str:
    return entry if entry == "default" else _candidates(entry, values)[0]


def _which(name: str, found: list[str], values: Mapping[str, Any]) -> str:
    if found:
        return f"it fits several values, name one of {', '.join(found)}"
    similar = paths.close(name, values.keys())
    wanted = f"did you mean {' or '.join(similar)}?" if similar else f"names look like {next(iter(values))}"
    return f"the file has no such value, {wanted}"
