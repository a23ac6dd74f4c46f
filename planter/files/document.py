"""Files whose numbers know where they come from: TOML in, validated sections out, every value with unit and origin."""

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, field_validator, model_validator

from planter.errors import InputError
from planter.files import paths, units
from planter.files.complaints import SET, explain, lacking, not_allowed, refused
from planter.files.fields import Section

_ORIGIN = re.compile(r"(paper|assumed|calibrated|measured|optimised)\b")


def _flat(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return {path: item for path, item in paths.walk(value) if not isinstance(item, dict)}


Origins = Annotated[dict[str, str], BeforeValidator(_flat)]


class Document(Section):
    """The whole of a file: its sections, and where each of their numbers comes from.

    Sections hold the values as the file shows them; `si` gives the value inside. A file's class ends with the field
    `origins: Origins = Field(alias="origin")`.
    """

    name: Annotated[str, Field(min_length=1, max_length=80)]
    description: str
    if TYPE_CHECKING:
        origins: Origins

    _source: str = PrivateAttr(default="machine")
    _overridden: tuple[str, ...] = PrivateAttr(default=())

    @classmethod
    def read(cls, table: Mapping[str, Any], source: str, overridden: tuple[str, ...] = ()) -> Self:
        """The validated content of a file; `source` names it in the error.

        Raises InputError, one sentence that names file, key, value and what is allowed.
        """
        try:
            found = cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, source, cls, overridden) from None
        found._source = source
        found._overridden = overridden
        return found

    @property
    def source(self) -> str:
        """The file or built-in name that this was loaded from."""
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
        """The nested table of the file, overrides included."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    def input_error(self, name: str, allowed: str, kind: type[InputError] = InputError) -> InputError:
        """The error that a value cannot be used, for checks that need more than its file.

        `allowed` says what would be right: "it must be ...".
        """
        values = self._values()
        path = self._path(name, values)
        return kind(not_allowed(self.source, path, values[path], allowed, overridden=path in self.overridden))

    def with_numbers(self, changes: Mapping[str, float]) -> Self:
        """A copy with some numbers set on the command line.

        A name is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that fits one path only; values
        are in the unit that the name ends in.

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
        return self.read(table, self.source, tuple(changed))

    def _values(self) -> dict[str, Any]:
        return _values_of(self.table())

    def _path(self, name: str, values: Mapping[str, Any]) -> str:
        found = _candidates(name, values)
        if len(found) != 1:
            raise InputError(f"{self.source}: {name} is not allowed: {_which(name, found, values)}")
        return found[0]

    @field_validator("origins", check_fields=False)
    @classmethod
    def _origins_are_known_words(cls, origins: dict[str, str]) -> dict[str, str]:
        for entry, text in origins.items():
            if not _ORIGIN.match(text):
                raise refused(entry, text, "it must start with paper, assumed, calibrated, measured or optimised")
        if "default" not in origins:
            raise lacking("default", "it must say where the numbers come from that have no entry of their own")
        return origins

    @model_validator(mode="after")
    def _origins_name_something(self) -> Self:
        values = self._values()
        for entry, text in self.origins.items():
            found = _candidates(entry, values)
            if entry != "default" and len(found) != 1:
                raise refused(f"origin.{entry}", text, _which(entry, found, values))
        return self


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
