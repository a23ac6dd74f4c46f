"""Printed numbers of a user's paper: a file that states each number and its conditions."""

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
from planter.files.fields import Line, Positive, Problems, Real, Section, Whole, check, explain, lacking, refused
from planter.files.text import read_toml

MEASURE = "measure of a mechanism"
"""Name of the formula that computes a question."""


@dataclass(frozen=True)
class Question:
    """A measure of a quantity of a machine in a unit; `label` is the path of the number in the file.

    `conditions` are the keys of values for which it holds, each with its path in the file.
    """

    machine: Path
    quantity: str
    unit: str
    label: str
    conditions: Mapping[str, str]
    samples: int | None = None
    until_s: float | None = None

    def refused(self, key: str, value: object, allowed: str) -> InputError:
        """Return the error for an invalid key of the number."""
        return InputError(f"{self.label}.{key} = {value!r} is not allowed: {allowed}")


def _check_number(text: str) -> str:
    try:
        finite = Decimal(text).is_finite()
    except InvalidOperation:
        finite = False
    if not finite:
        raise refused("", text, "it must be a number as it is printed, with a decimal point")
    return text


def _check_texts(value: object) -> object:
    if not isinstance(value, str | list) or not all(isinstance(text, str) for text in value):
        raise refused("", value, "it must be text in quotes, for its digits are its precision, or a list of such texts")
    return [value] if isinstance(value, str) else value


def _as_written(value: object, check: ValidatorFunctionWrapHandler) -> object:
    """Return a checked number with its written digits."""
    check(value)
    return value


RoundedInput = Annotated[Real, WrapValidator(_as_written)]
"""A value of a paper, whose written digits determine its rounding."""
Printed = Annotated[list[Annotated[Line, AfterValidator(_check_number)]], BeforeValidator(_check_texts)]


class PrintedNumberRow(Section):
    """A printed number, or a row of them: lists in `each` of one length, of which every number takes its entry."""

    place: Annotated[Line, Field(min_length=1)]
    quantity: Annotated[Line, Field(min_length=1)]
    unit: Line
    printed: Printed
    values: Annotated[dict[str, RoundedInput], Field(alias="with", default_factory=dict)]
    each: Annotated[dict[str, list[RoundedInput | Line]], Field(default_factory=dict)]
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
        """Yield every number with its entries of `each`."""
        for k, text in enumerate(self.printed):
            yield text, {name: entries[k] for name, entries in self.each.items()}


class NumbersFile(Section):
    """Printed numbers of one paper: values that it discloses, values that it does not, and the numbers."""

    paper: Line | None = None
    disclosed: Annotated[dict[str, RoundedInput], Field(default_factory=dict)]
    assumed: Annotated[dict[str, Real], Field(default_factory=dict)]
    number: Annotated[list[PrintedNumberRow], Field(min_length=1)]

    @check
    def _is_disclosed_or_assumed(self) -> Problems:
        for key in self.disclosed.keys() & self.assumed.keys():
            yield refused(f"assumed.{key}", self.assumed[key], "the paper discloses it, as [disclosed] says")


def read_numbers_file(source: Path) -> NumbersFile:
    """Read the file at a path. Raises InputError with file, key, value and allowed values."""
    table = read_toml(source, Rounded)
    try:
        return NumbersFile.model_validate(table)
    except ValidationError as error:
        raise explain(error, str(source), NumbersFile) from None


def list_rows(file: NumbersFile, source: Path, paper: str, machine: Path) -> Iterator[dict[str, Any]]:
    """Yield every number in the form of `planter.audit.numbers`."""
    everywhere = {key: f"{source}: {part}.{key}" for part in ("disclosed", "assumed") for key in getattr(file, part)}
    for index, row in enumerate(file.number):
        label = f"{source}: number[{index}]"
        for text, entry in row.singles():
            quantity, place = (
                _fill_placeholders(row.quantity, entry, label),
                _fill_placeholders(row.place, entry, label),
            )
            places = {key: f"{label}.with.{key}" for key in row.values}
            places |= {key: f"{label}.each.{key}" for key in entry if not _is_placeholder(key, row)}
            question = Question(machine, quantity, row.unit, label, everywhere | places, row.samples, row.until_s)
            yield {
                "paper": paper,
                "place": place,
                "quantity": quantity,
                "unit": row.unit,
                "printed": text,
                "by": MEASURE,
                "with": {**row.values, **entry, "question": question},
                "needs": row.needs,
                "reading": row.reading,
            }


def _is_placeholder(key: str, row: PrintedNumberRow) -> bool:
    """Return whether an entry is a placeholder in the text of a quantity or a place, and thus no condition."""
    return any(f"{{{key}}}" in text for text in (row.quantity, row.place))


def _fill_placeholders(text: str, entry: Mapping[str, Any], label: str) -> str:
    texts = {key: f"{value:g}" if isinstance(value, float) else value for key, value in entry.items()}
    try:
        return text.format_map(texts)
    except (KeyError, ValueError, IndexError, AttributeError):
        names = ", ".join(f"{{{key}}}" for key in entry) or "no names in braces"
        raise InputError(f"{label}: {text!r} is not allowed: it may hold {names}, as `each` lists them") from None
