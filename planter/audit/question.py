"""The printed numbers of a paper of one's own: a file that says what each is, and what it holds for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from planter.audit.registry import Rounded
from planter.errors import InputError
from planter.files.complaints import explain, lacking, refused
from planter.files.fields import Line, Positive, Problems, Real, Section, Whole, check
from planter.files.text import read_toml

MEASURE = "measure of a mechanism"
"""The formula that answers."""


@dataclass(frozen=True)
class Question:
    """What a number is: a measure of a quantity of a machine, in a unit; `label` is its place in the file.

    `given` are keys of values that it is told to hold for, each with its place in the file.
    """

    machine: Path
    quantity: str
    unit: str
    label: str
    given: Mapping[str, str]
    samples: int | None = None
    until_s: float | None = None

    def refused(self, key: str, value: object, allowed: str) -> InputError:
        """The error that something of the number cannot be meant."""
        return InputError(f"{self.label}.{key} = {value!r} is not allowed: {allowed}")


def _number(text: str) -> str:
    try:
        finite = Decimal(text).is_finite()
    except InvalidOperation:
        finite = False
    if not finite:
        raise refused("", text, "it must be a number as it is printed, with a decimal point")
    return text


def _listed(value: object) -> object:
    if not isinstance(value, str | list) or not all(isinstance(one, str) for one in value):
        raise refused("", value, "it must be text in quotes, for its digits are its precision, or a list of such texts")
    return [value] if isinstance(value, str) else value


def _as_written(value: object, check: ValidatorFunctionWrapHandler) -> object:
    """A number that passes its check, with the digits that it is written with."""
    check(value)
    return value


Input = Annotated[Real, WrapValidator(_as_written)]
"""A value that a paper gives: as many digits as it is written with tell how far it is rounded."""
Printed = Annotated[list[Annotated[Line, AfterValidator(_number)]], BeforeValidator(_listed)]


class Row(Section):
    """A printed number, or a row of them: lists in `each` of one length, of which every number takes its entry."""

    place: Annotated[Line, Field(min_length=1)]
    quantity: Annotated[Line, Field(min_length=1)]
    unit: Line
    printed: Printed
    values: Annotated[dict[str, Input], Field(alias="with", default_factory=dict)]
    each: Annotated[dict[str, list[Input | Line]], Field(default_factory=dict)]
    samples: Annotated[Whole, Field(ge=4, le=100_000)] | None = None
    until_s: Positive | None = None
    needs: Annotated[list[Line], Field(default_factory=list)]
    reading: Line = ""

    @check
    def _each_is_as_long_as_printed(self) -> Problems:
        if not self.each and len(self.printed) > 1:
            yield lacking("each", "it must say what the numbers of the list differ in")
        for name, entries in self.each.items():
            if len(entries) != len(self.printed):
                allowed = f"it must have as many entries as `printed` has, {len(self.printed)}"
                yield refused(f"each.{name}", entries, allowed)

    def singles(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Every number with its own entries of `each`."""
        for k, text in enumerate(self.printed):
            yield text, {name: entries[k] for name, entries in self.each.items()}


class NumbersFile(Section):
    """Printed numbers of one paper: values that it discloses, values that it does not, and the numbers."""

    paper: Line | None = None
    disclosed: Annotated[dict[str, Input], Field(default_factory=dict)]
    assumed: Annotated[dict[str, Real], Field(default_factory=dict)]
    number: Annotated[list[Row], Field(min_length=1)]

    @check
    def _is_disclosed_or_assumed(self) -> Problems:
        for key in self.disclosed.keys() & self.assumed.keys():
            yield refused(f"assumed.{key}", self.assumed[key], "the paper discloses it, as [disclosed] says")


def read(source: Path) -> NumbersFile:
    """The file at a path. Raises InputError, which names file, key, value and what is allowed."""
    table = read_toml(source, Rounded)
    try:
        return NumbersFile.model_validate(table)
    except ValidationError as error:
        raise explain(error, str(source), NumbersFile) from None


def rows(file: NumbersFile, source: Path, paper: str, machine: Path) -> Iterator[dict[str, Any]]:
    """Every number as `planter.audit.numbers` takes it."""
    everywhere = {key: f"{source}: {part}.{key}" for part in ("disclosed", "assumed") for key in getattr(file, part)}
    for index, row in enumerate(file.number):
        label = f"{source}: number[{index}]"
        for text, own in row.singles():
            quantity, place = _filled(row.quantity, own, label), _filled(row.place, own, label)
            here = {key: f"{label}.with.{key}" for key in row.values}
            here |= {key: f"{label}.each.{key}" for key in own if not _fills(key, row)}
            question = Question(machine, quantity, row.unit, label, everywhere | here, row.samples, row.until_s)
            yield {
                "paper": paper,
                "place": place,
                "quantity": quantity,
                "unit": row.unit,
                "printed": text,
                "by": MEASURE,
                "with": {**row.values, **own, "question": question},
                "needs": row.needs,
                "reading": row.reading,
            }


def _fills(key: str, row: Row) -> bool:
    """Whether an entry stands in the text of a quantity or a place, so that it need not be a value besides."""
    return any(f"{{{key}}}" in text for text in (row.quantity, row.place))


def _filled(text: str, own: Mapping[str, Any], label: str) -> str:
    shown = {key: f"{value:g}" if isinstance(value, float) else value for key, value in own.items()}
    try:
        return text.format_map(shown)
    except (KeyError, ValueError, IndexError, AttributeError):
        known = ", ".join(f"{{{key}}}" for key in own) or "no names in braces"
        raise InputError(f"{label}: {text!r} is not allowed: it may hold {known}, as `each` lists them") from None
