"""Files whose numbers know where they come from: TOML in, validated sections out, every value with unit and origin."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, field_validator

from planter.errors import InputError
from planter.files import examples, paths, units
from planter.files.changes import applied
from planter.files.complaints import SET, explain, lacking, not_allowed, refuse, refused
from planter.files.fields import Line, Problems, Section, Words, check
from planter.files.text import parse_toml

_ORIGIN = re.compile(r"(paper|assumed|calibrated|measured|optimised)\b")


def _flat(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return {path: item for path, item in paths.walk(value) if not isinstance(item, dict)}


Origins = Annotated[dict[str, Words], BeforeValidator(_flat)]


class Document(Section):
    """The whole of a file: its sections, and where each of their numbers comes from.

    Sections hold the values as the file shows them; `si` gives the value inside. A file's class ends with the field
    `origins: Origins = Field(alias="origin")`.
    """

    name: Annotated[Line, Field(min_length=1, max_length=80)]
    description: Words
    if TYPE_CHECKING:
        origins: Origins

    _source: str = PrivateAttr(default="machine")
    _changed: tuple[str, ...] = PrivateAttr(default=())

    @classmethod
    def load(cls, source: str | Path, kind: str, changes: Mapping[str, float] | None = None) -> Self:
        """The content of the file at a path, or of the built-in one of that name in a room; `changes` as in `read`.

        Raises InputError as `read` does, and for a file that cannot be read or belongs to another kind of machine.
        """
        label = str(source)
        table = parse_toml(examples.text(source, kind), label)
        try:
            return cls.read(table, label, changes)
        except InputError:
            examples.check_kind(table, label, kind)
            raise

    @classmethod
    def read(
        cls,
        table: Mapping[str, Any],
        source: str,
        changes: Mapping[str, float] | None = None,
        changed: tuple[str, ...] = (),
    ) -> Self:
        """The validated content of a file; `source` names it in the error, `changed` what was set in `table` before.

        `changes` are numbers set on the command line, before anything is checked: what the file itself has in their
        place need not be allowed. A name is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that
        fits one path only; values are in the unit that the name ends in.

        Raises InputError, one sentence that names file, key, value and what is allowed.
        """
        if changes:
            table, paths_set = applied(cls, table, source, changes)
            changed = tuple(dict.fromkeys((*changed, *paths_set)))
        try:
            found = cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, source, cls, changed) from None
        found._source = source
        found._changed = changed
        return found

    @property
    def source(self) -> str:
        """The file or built-in name that this was loaded from."""
        return self._source

    @property
    def changed(self) -> tuple[str, ...]:
        """Full paths of the values that were set on the command line."""
        return self._changed

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
        return self._origin(self._path(name, values), self._entries(values))

    def number_origins(self) -> dict[str, str]:
        """Where every number of the file comes from, by its full path."""
        values = self._values()
        entries = self._entries(values)
        return {path: self._origin(path, entries) for path, value in values.items() if isinstance(value, int | float)}

    def numbers(self) -> dict[str, float]:
        """Every number of the file by its full path, as shown in the file."""
        return {path: value for path, value in self._values().items() if isinstance(value, int | float)}

    def table(self) -> dict[str, Any]:
        """The nested table of the file, changes included."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    def written_table(self) -> dict[str, Any]:
        """Return the table as it is written into another folder."""
        return self.table()

    def input_error(self, name: str, allowed: str, kind: type[InputError] = InputError) -> InputError:
        """The error that a value cannot be used, for checks that need more than its file.

        `allowed` says what would be right: "it must be ...".
        """
        values = self._values()
        path = self._path(name, values)
        return kind(not_allowed(self.source, path, values[path], allowed, changed=path in self.changed))

    def with_numbers(self, changes: Mapping[str, float]) -> Self:
        """A copy with some numbers set on the command line, as in `read`, and what else was read beside the file."""
        copy = self.read(self.table(), self.source, changes, self.changed)
        for name, value in (self.__pydantic_private__ or {}).items():
            if name not in ("_source", "_changed"):
                setattr(copy, name, value)
        return copy

    def _origin(self, path: str, entries: Mapping[str, str]) -> str:
        if any(item == path or item.startswith(f"{path}[") for item in self.changed):
            return SET
        holders = (path, path.partition("[")[0], path.partition(".")[0], "default")
        return next(entries[holder] for holder in holders if holder in entries)

    def _entries(self, values: Mapping[str, Any]) -> dict[str, str]:
        """The entries of [origin] by the full path of what they name."""
        names = paths.Names(values)
        return {(names.candidates(entry) or [entry])[0]: text for entry, text in self.origins.items()}

    def _values(self) -> dict[str, Any]:
        return _values_of(self.table())

    def _path(self, name: str, values: Mapping[str, Any]) -> str:
        names = paths.Names(values)
        found = names.candidates(name)
        if len(found) != 1:
            raise InputError(f"{self.source}: {name} is not allowed: {names.complaint(name)}")
        return found[0]

    @field_validator("origins", check_fields=False)
    @classmethod
    def _origins_are_known_words(cls, origins: dict[str, str]) -> dict[str, str]:
        allowed = "it must start with paper, assumed, calibrated, measured or optimised"
        problems = [refused(entry, text, allowed) for entry, text in origins.items() if not _ORIGIN.match(text)]
        if "default" not in origins:
            missing = "it must say where the numbers come from that have no entry of their own"
            problems.append(lacking("default", missing))
        refuse(problems)
        return origins

    @check
    def _origins_name_something(self) -> Problems:
        names = paths.Names(self._values())
        for entry, text in self.origins.items():
            if entry != "default" and len(names.candidates(entry)) != 1:
                yield refused(f"origin.{entry}", text, names.complaint(entry))


def _values_of(table: Mapping[str, Any]) -> dict[str, Any]:
    return dict(paths.walk({key: value for key, value in table.items() if key != "origin"}))
