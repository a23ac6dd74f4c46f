"""TOML text of tables, with notes as comments after values."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    field_validator,
)

from planter import paths, safe_text
from planter.errors import InputError
from planter.files import examples, units
from planter.files.fields import (
    OWN,
    SET,
    FileSection,
    Line,
    Problems,
    Words,
    check,
    describe_problems,
    fill_defaults,
    find_annotation,
    invalid_value_problem,
    missing_value_problem,
    raise_problems,
    value_error,
)
from planter.paths import Location
from planter.text_files import parse_toml


def format_lines(table: Mapping[str, Any], notes: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of the keys outside sections, then of the sections; `notes` by full path
    become comments.
    """
    sections = {key: value for key, value in table.items() if _sections(value)}
    yield from (
        f"{_key(key)} = {_value(value)}" for key, value in table.items() if key not in sections
    )
    for section, values in sections.items():
        if isinstance(values, Mapping):
            yield from ("", f"[{_key(section)}]", *_section(section, values, notes))
        else:
            for index, entry in enumerate(values):
                yield from (
                    "",
                    f"[[{_key(section)}]]",
                    *_section(f"{section}[{index}]", entry, notes),
                )


def _sections(value: Any) -> bool:
    """Return whether a value is a section, or a list of sections."""
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)
    )


def _section(path: str, values: Mapping[str, Any], notes: Mapping[str, str]) -> Iterator[str]:
    for key, value in values.items():
        note = notes.get(f"{path}.{key}", "")
        yield f"{_key(key)} = {_value(value)}{f'  # {note}' if note else ''}"


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if plain else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)


def apply_overrides(
    model: type[BaseModel], table: Mapping[str, Any], source: str, changes: Mapping[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Return a copy of the table of a file with changed numbers, and their full paths.

    A name is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that fits one path
    only; values are in the unit that the name ends in. Raises InputError for an unknown or
    ambiguous name.
    """
    full_table = fill_defaults(model, table)
    locations = _numbers(full_table)
    names = paths.Names(locations.keys())
    values: dict[Location, float] = {}
    for name, value in changes.items():
        candidates = names.candidates(name)
        if len(candidates) != 1:
            raise value_error(name, value, names.complaint(name), source, is_changed=True)
        location = locations[candidates[0]]
        kind = find_annotation(model, location)
        is_integer = int in (kind, *get_args(kind)) and float(value).is_integer()
        values[location] = int(value) if is_integer else value
    return paths.with_values(full_table, values), [
        paths.join_location(location) for location in values
    ]


def _numbers(table: Mapping[str, Any]) -> dict[str, Location]:
    """Return the locations of the numbers of a table by path, including numbers in quotes."""
    rows: Iterable[tuple[Location, Any]] = paths.walk_locations(
        {k: v for k, v in table.items() if k != "origin"}
    )
    return {
        paths.join_location(location): location for location, value in rows if _is_number(value)
    }


def _is_number(value: Any) -> bool:
    if isinstance(value, str):
        try:
            float(safe_text.replace_decimal_comma(value) or value)
        except ValueError:
            return False
        return True
    return isinstance(value, int | float)


_ORIGIN = re.compile(r"(paper|assumed|calibrated|measured|optimised)\b")


def _flat(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return {path: item for path, item in paths.walk_paths(value) if not isinstance(item, dict)}


Origins = Annotated[
    dict[str, Words],
    BeforeValidator(_flat),
    Field(
        description="where numbers are from: paper, assumed, calibrated or measured, by key, or "
        "as default"
    ),
]


class Document(FileSection):
    """A file: its sections, and the origins of their numbers.

    Sections have values in the units of the file; `si` converts them. The class of a file ends with
    the field `origins: Origins = Field(alias="origin")`.
    """

    name: Annotated[Line, Field(min_length=1, max_length=80)]
    """name of the machine in results"""
    description: Words
    """a sentence on the machine"""
    if TYPE_CHECKING:
        origins: Origins

    states_goals: ClassVar[bool] = False
    """Whether files of this kind may have objective.least and requirements.hold."""

    _source: str = PrivateAttr(default="machine")
    _changed: tuple[str, ...] = PrivateAttr(default=())

    @classmethod
    def load(
        cls, source: str | Path, kind: str, changes: Mapping[str, float] | None = None
    ) -> Self:
        """Load the file at a path, or the built-in file of that name; `changes` as in `read`.

        Raises InputError as `read`, and if the file cannot be read or belongs to another kind of
        machine.
        """
        label = str(source)
        table = parse_toml(examples.read_source(source, kind), label)
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
        """Validate the table of a file; `source` is its name in messages, `changed` the paths set
        in `table` before.

        `changes` are numbers set on the command line, which replace those of the file before
        validation. A name is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part
        that fits one path only; values are in the unit that the name ends in.

        Raises InputError, which names file, key, value and the allowed values.
        """
        if changes:
            table, paths_set = apply_overrides(cls, table, source, changes)
            changed = tuple(dict.fromkeys((*changed, *paths_set)))
        try:
            document = cls.model_validate(table)
        except ValidationError as error:
            raise describe_problems(error, source, cls, changed) from None
        document._source = source
        document._changed = changed
        return document

    @property
    def source(self) -> str:
        """The file or built-in name that this was loaded from."""
        return self._source

    @property
    def changed(self) -> tuple[str, ...]:
        """Full paths of the values that were set on the command line."""
        return self._changed

    def si(self, name: str) -> float:
        """Return the number at a path such as `mass.sun_kg` or `nozzle.hinge_A_mm[0]`, in SI units
        and radians.

        The last part of a path suffices if it is unique. Raises InputError for other names.
        """
        numbers = self.numbers()
        path = self._path(name, numbers)
        return float(numbers[path]) * units.unit_factor(path)

    def origin(self, name: str) -> str:
        """Return the origin of a value: its entry in [origin], else that of its section, else the
        default.

        It is "this file" if the entry is that of a built-in file, and the value another one than
        there.
        """
        values = self._values()
        return self._origin(self._path(name, values), values, self._entries(values))

    def number_origins(self) -> dict[str, str]:
        """Return the origins of all numbers of the file by full path."""
        values = self._values()
        entries = self._entries(values)
        return {
            path: self._origin(path, values, entries)
            for path, value in values.items()
            if isinstance(value, int | float)
        }

    def own_numbers(self) -> list[str]:
        """Return the full paths of the numbers whose origin is this file."""
        return [path for path, words in self.number_origins().items() if words == OWN]

    def numbers(self) -> dict[str, float]:
        """Return all numbers of the file by full path, in the units of the file."""
        return {
            path: value for path, value in self._values().items() if isinstance(value, int | float)
        }

    def table(self) -> dict[str, Any]:
        """Return the nested table of the file, with changes."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    def written_table(self) -> dict[str, Any]:
        """Return the table as it is written into another folder."""
        return self.table()

    def input_error(
        self, name: str, allowed: str, kind: type[InputError] = InputError
    ) -> InputError:
        """Return the error for an invalid value, for checks that need more than its file.

        `allowed` states the condition: "it must be ...".
        """
        values = self._values()
        path = self._path(name, values)
        return kind(
            str(
                value_error(
                    path, values[path], allowed, self.source, is_changed=path in self.changed
                )
            )
        )

    def with_numbers(self, changes: Mapping[str, float]) -> Self:
        """Return a copy with numbers set on the command line, as in `read`, and with the other
        files that were read.
        """
        copy = self.read(self.table(), self.source, changes, self.changed)
        for name, value in (self.__pydantic_private__ or {}).items():
            if name not in ("_source", "_changed"):
                setattr(copy, name, value)
        return copy

    def _origin(self, path: str, values: Mapping[str, Any], entries: Mapping[str, str]) -> str:
        if any(item == path or item.startswith(f"{path}[") for item in self.changed):
            return SET
        holders = (path, path.partition("[")[0], path.partition(".")[0], "default")
        holder = next(holder for holder in holders if holder in entries)
        words = entries[holder]
        # An entry that was copied with a built-in file speaks of the numbers there.
        templates = [
            template
            for template in _list_templates(type(self))
            if template.entries.get(holder) == words
        ]
        is_changed = templates and all(
            template.values.get(path) != values[path] for template in templates
        )
        return OWN if is_changed else words

    def _entries(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Return the entries of [origin] by full path."""
        names = paths.Names(values)
        return {
            (names.candidates(entry) or [entry])[0]: text for entry, text in self.origins.items()
        }

    def _values(self) -> dict[str, Any]:
        table = self.table()
        table.pop("origin", None)
        return dict(paths.walk_paths(table))

    def _path(self, name: str, values: Mapping[str, Any]) -> str:
        names = paths.Names(values)
        candidates = names.candidates(name)
        if len(candidates) != 1:
            raise InputError(f"{self.source}: {name}: {names.complaint(name)}")
        return candidates[0]

    @field_validator("origins", check_fields=False)
    @classmethod
    def _origins_are_known_words(cls, origins: dict[str, str]) -> dict[str, str]:
        allowed = "it must start with paper, assumed, calibrated, measured or optimised"
        problems = [
            invalid_value_problem(entry, text, allowed)
            for entry, text in origins.items()
            if not _ORIGIN.match(text)
        ]
        if "default" not in origins:
            missing = "it must say where the numbers come from that have no entry of their own"
            problems.append(missing_value_problem("default", missing))
        raise_problems(problems)
        return origins

    @check
    def _origins_name_something(self) -> Problems:
        names = paths.Names(self._values())
        for entry, text in self.origins.items():
            if entry != "default" and len(names.candidates(entry)) != 1:
                yield invalid_value_problem(f"origin.{entry}", text, names.complaint(entry))


class _Template(NamedTuple):
    """Entries of [origin] and values of a built-in file, by full path."""

    entries: Mapping[str, str]
    values: Mapping[str, Any]


@cache
def _list_templates(kind: type[Document]) -> list[_Template]:
    """Return the built-in files of a kind of documents."""
    templates = []
    for name in examples.list_examples(suffix=".toml"):
        try:
            document = kind.read(parse_toml(examples.example(name, suffix=".toml"), name), name)
        except InputError:  # a file of another kind
            continue
        values = document._values()
        templates.append(_Template(document._entries(values), values))
    return templates
