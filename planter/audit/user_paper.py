"""Audit of a user's paper: its Python file is derived and judged, its printed numbers are read and
recomputed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from planter import paths, plugins
from planter.audit import numbers, verdicts
from planter.audit.registry import Rounded
from planter.errors import InputError
from planter.files.derivation import GENERATED, derive_file, judge_text
from planter.files.fields import (
    FileSection,
    Line,
    Positive,
    Problems,
    Real,
    Whole,
    check,
    describe_problems,
    invalid_value_problem,
    missing_value_problem,
)
from planter.report import files
from planter.report.folder import NAME as LIST
from planter.report.folder import keep_file
from planter.text_files import read_bytes, read_json, read_toml

MEASURE = "measure of a mechanism"
"""Name of the formula that computes a question."""


@dataclass(frozen=True)
class MeasureQuestion:
    """A measure of a quantity of a machine in a unit; `label` is the path of the number in the
    file.

    `conditions` are the keys of values for which it holds, each with its path in the file.
    `measurement` is the table of the sensor that the file at `source` states, if any.
    """

    machine: Path
    quantity: str
    unit: str
    label: str
    conditions: Mapping[str, str]
    samples: int | None = None
    until_s: float | None = None
    measurement: Mapping[str, Any] | None = None
    source: str = ""

    def refused(self, key: str, value: object, allowed: str) -> InputError:
        """Return the error for an invalid key of the number."""
        return InputError.for_value(f"{self.label}.{key}", repr(value), allowed)


def _check_number(text: str) -> str:
    try:
        finite = Decimal(text).is_finite()
    except InvalidOperation:
        finite = False
    if not finite:
        raise invalid_value_problem(
            "", text, "it must be a number as it is printed, with a decimal point"
        )
    return text


def _check_texts(value: object) -> object:
    if not isinstance(value, str | list) or not all(isinstance(text, str) for text in value):
        raise invalid_value_problem(
            "",
            value,
            "it must be text in quotes, for its digits are its precision, or a list of such texts",
        )
    return [value] if isinstance(value, str) else value


def _as_written(value: object, check: ValidatorFunctionWrapHandler) -> object:
    """Return a checked number with its written digits."""
    check(value)
    return value


RoundedInput = Annotated[Real, WrapValidator(_as_written)]
"""A value of a paper, whose written digits determine its rounding."""
PrintedTexts = Annotated[
    list[Annotated[Line, AfterValidator(_check_number)]], BeforeValidator(_check_texts)
]


class PrintedNumberRow(FileSection):
    """A printed number, or a row of them: lists in `each` of one length, of which every number
    takes its entry.
    """

    place: Annotated[Line, Field(min_length=1)]
    quantity: Annotated[Line, Field(min_length=1)]
    unit: Line
    printed: PrintedTexts
    values: Annotated[dict[str, RoundedInput], Field(alias="with", default_factory=dict)]
    each: Annotated[dict[str, list[RoundedInput | Line]], Field(default_factory=dict)]
    samples: Annotated[Whole, Field(ge=4, le=100_000)] | None = None
    until_s: Positive | None = None
    needs: Annotated[list[Line], Field(default_factory=list)]
    reading: Line = ""

    @check
    def _each_is_as_long_as_printed(self) -> Problems:
        if not self.each and len(self.printed) > 1:
            yield missing_value_problem(
                "each", "it must say what the numbers of the list differ in"
            )
        for name, entries in self.each.items():
            if len(entries) != len(self.printed):
                allowed = f"it must have as many entries as `printed` has, {len(self.printed)}"
                yield invalid_value_problem(f"each.{name}", entries, allowed)

    def singles(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield every number with its entries of `each`."""
        for k, text in enumerate(self.printed):
            yield text, {name: entries[k] for name, entries in self.each.items()}


class NumbersFile(FileSection):
    """Printed numbers of one paper: values that it discloses, values that it does not, its sensor,
    and the numbers.
    """

    paper: Line | None = None
    disclosed: Annotated[dict[str, RoundedInput], Field(default_factory=dict)]
    assumed: Annotated[dict[str, Real], Field(default_factory=dict)]
    measurement: dict[str, Any] | None = None
    number: Annotated[list[PrintedNumberRow], Field(min_length=1)]

    @check
    def _is_disclosed_or_assumed(self) -> Problems:
        for key in self.disclosed.keys() & self.assumed.keys():
            yield invalid_value_problem(
                f"assumed.{key}", self.assumed[key], "the paper discloses it, as [disclosed] says"
            )


def read_numbers_file(source: Path) -> NumbersFile:
    """Read the file at a path. Raises InputError with file, key, value and allowed values."""
    table = read_toml(source, Rounded)
    try:
        return NumbersFile.model_validate(table)
    except ValidationError as error:
        raise describe_problems(error, str(source), NumbersFile) from None


def list_rows(
    file: NumbersFile, source: Path, paper: str, machine: Path
) -> Iterator[dict[str, Any]]:
    """Yield every number in the form of `planter.audit.numbers`."""
    everywhere = {
        key: f"{source}: {part}.{key}"
        for part in ("disclosed", "assumed")
        for key in getattr(file, part)
    }
    for index, row in enumerate(file.number):
        label = f"{source}: number[{index}]"
        for text, entry in row.singles():
            quantity, place = (
                _fill_placeholders(row.quantity, entry, label),
                _fill_placeholders(row.place, entry, label),
            )
            places = {key: f"{label}.with.{key}" for key in row.values}
            places |= {key: f"{label}.each.{key}" for key in entry if not _is_placeholder(key, row)}
            question = MeasureQuestion(
                machine,
                quantity,
                row.unit,
                label,
                everywhere | places,
                row.samples,
                row.until_s,
                file.measurement,
                str(source),
            )
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
    """Return whether an entry is a placeholder in the text of a quantity or a place, and thus no
    condition.
    """
    return any(f"{{{key}}}" in text for text in (row.quantity, row.place))


def _fill_placeholders(text: str, entry: Mapping[str, Any], label: str) -> str:
    texts = {
        key: f"{value:g}" if isinstance(value, float) else value for key, value in entry.items()
    }
    try:
        return text.format_map(texts)
    except (KeyError, ValueError, IndexError, AttributeError):
        names = ", ".join(f"{{{key}}}" for key in entry) or "no names in braces"
        raise InputError(f"{label}: {text!r}: it may hold {names}, as `each` lists them") from None


VERDICTS, TYPESET = "audit.json", "audit_mathml.json"
MAX_SIZE = 100_000_000
"""Largest number of bytes and values of the verdicts, which `derive` has just written."""


@dataclass(frozen=True)
class PaperAudit:
    """The result, its typeset formulas by paper and equation, and the folder of the written
    verdicts; `skeleton` is the file of names that was written for a text, if any.
    """

    result: dict[str, Any]
    typeset: Mapping[str, Any]
    folder: Path
    skeleton: Path | None = None


def audit_user_paper(source: Path, printed: Path | None = None) -> PaperAudit:
    """Judge the papers of a Python file or folder, with the numbers of one of them from a file.

    Verdicts and functions are written to `generated` next to it. Raises InputError for an error in
    either file.
    """
    numbers_file = None if printed is None else read_numbers_file(printed)
    folder = (source if source.is_dir() else source.parent) / GENERATED
    with TemporaryDirectory() as folder_name:
        derive_file(source, Path(folder_name))
        if not Path(folder_name, VERDICTS).is_file():
            raise InputError(
                f"{source}: the file states no paper: define CASE = trial(mechanism, paper)"
            )
        _keep_derivations(Path(folder_name), folder)
    return _collect(folder, numbers_file, printed)


SKELETON = "names.toml"
NAMES_SUFFIX = ".names.toml"


def audit_text(
    text: Path, against: Path, names: Path | None = None, printed: Path | None = None
) -> PaperAudit:
    """Judge the displayed equations of a text against the mechanism of a Python file.

    Verdicts and functions are written to `generated` next to the text. Without `names`, a file of
    names to complete is written next to it, unless there is one. Raises InputError for an error in
    one of the files.
    """
    numbers_file = None if printed is None else read_numbers_file(printed)
    folder, skeleton_path = text.parent / GENERATED, text.with_suffix(NAMES_SUFFIX)
    with TemporaryDirectory() as folder_name:
        judge_text(text, against, names, Path(folder_name))
        skeleton = read_bytes(Path(folder_name, SKELETON), MAX_SIZE).decode()
        _keep_derivations(Path(folder_name), folder)
    is_new = names is None and not skeleton_path.exists()
    if is_new:
        files.write_text(skeleton_path, skeleton)
    keep_file(skeleton_path)
    audit = _collect(folder, numbers_file, printed)
    return replace(audit, skeleton=skeleton_path if is_new else None)


def _keep_derivations(source: Path, folder: Path) -> None:
    """Write what was derived into the folder next to a user's file."""
    derivations = {
        path.relative_to(source).as_posix(): path for path in source.rglob("*") if path.is_file()
    }
    files.write_all(
        folder,
        {
            name: read_bytes(path, MAX_SIZE)
            for name, path in derivations.items()
            if path.name not in (LIST, SKELETON)
        },
    )


def _collect(folder: Path, numbers_file: NumbersFile | None, printed: Path | None) -> PaperAudit:
    """Return the verdicts in a folder, with those on printed numbers."""
    content, typeset = (
        read_json(folder / name, MAX_SIZE, MAX_SIZE) for name in (VERDICTS, TYPESET)
    )
    papers: dict[str, dict[str, str]] = content["papers"]
    number_verdicts = (
        []
        if numbers_file is None or printed is None
        else _judge_file(numbers_file, printed, papers, folder)
    )
    titles = {name: about["title"] for name, about in papers.items()}
    return PaperAudit(verdicts.collect_verdicts(content, number_verdicts, titles), typeset, folder)


def _judge_file(
    numbers_file: NumbersFile, source: Path, papers: Mapping[str, Mapping[str, str]], folder: Path
) -> list[dict[str, Any]]:
    name = find_paper(numbers_file, source, papers)
    model = papers[name]["model"]
    if not model:
        raise InputError(f"{source}: {name} has no mechanism, which is needed to compute numbers")
    for package in plugins.load_modules("printed"):
        numbers.load_formulas(package)
    rows = list(list_rows(numbers_file, source, name, folder / f"{model}.toml"))
    table = {
        "disclosed": {name: numbers_file.disclosed},
        "assumed": {name: numbers_file.assumed},
        "number": rows,
    }
    return numbers.judge_numbers(name, table)


def find_paper(numbers_file: NumbersFile, source: Path, papers: Mapping[str, Any]) -> str:
    """Return the paper of the numbers, which may be left out if there is only one."""
    if numbers_file.paper is None and len(papers) == 1:
        return next(iter(papers))
    if numbers_file.paper in papers:
        return str(numbers_file.paper)
    if numbers_file.paper is None:
        raise InputError(f"{source}: paper is missing: it must be one of {', '.join(papers)}")
    close = paths.find_similar(numbers_file.paper, papers)
    hint = f"did you mean {close[0]}?" if close else f"it must be one of {', '.join(papers)}"
    raise InputError(f"{source}: paper = {numbers_file.paper!r}: {hint}")
