"""Machines with their labelled drawings, and the meaning and drawing of every symbol, key and
column.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import cast

from planter import plugins
from planter.errors import InputError
from planter.explain import dictionary
from planter.explain.results import DrawnSheet, DrawnSymbol, ExplainedMachine, Meaning
from planter.files.kinds import find_kind, load_part
from planter.view.sheet import Draughtsman, Labelled

GEOMETRIC = {"m", "mm", "rad", "deg"}
"""Units of lengths and angles."""
NO_SUCH_PART = "this machine has no such part"
"""Reason for a name that appears on sheets of similar machines, but not of this one."""
KINDS = ("symbol", "file key", "column")


@dataclass(frozen=True)
class LabelledMachine:
    """A machine with its labelled drawings and the module that drew it."""

    package: str
    labels: Draughtsman
    labelled: Labelled

    def explained(self, files: list[str]) -> ExplainedMachine:
        """Return the result of the command; `files` are those that were written."""
        sheets = [
            DrawnSheet(sheet.name, sheet.title, sorted(sheet.names))
            for sheet in self.labelled.sheets
        ]
        return ExplainedMachine(self.labelled.name, self.package, sheets, self.symbols(), files)

    def symbols(self) -> list[DrawnSymbol]:
        """Return a row for each length, angle and coordinate."""
        return [self._symbol(meaning) for meaning in list_geometry(self.package)]

    def _symbol(self, meaning: Meaning) -> DrawnSymbol:
        sheet = next(
            (sheet.name for sheet in self.labelled.sheets if meaning.name in sheet.names), None
        )
        key = _find_key(meaning, self.labelled.numbers, self.labels)
        column = meaning.name if meaning.kind == "column" else meaning.key
        return DrawnSymbol(
            meaning.name,
            meaning.unit,
            meaning.meaning,
            key,
            column if key is None else None,
            sheet,
            explain_omission(self.labels, meaning) or NO_SUCH_PART if sheet is None else None,
        )


def find_drawings() -> dict[str, Draughtsman]:
    """Return the drawing modules by kind of machine."""
    return {
        plugins.name_package(module): cast(Draughtsman, module)
        for module in plugins.load_modules("labelled")
    }


def find_package(source: str) -> str | None:
    """Return the kind of machine that draws a source, None if there is none."""
    module = load_part(source, "labelled") if find_kind(source) else None
    return None if module is None else plugins.name_package(module)


def draw_machine(source: str, changes: Mapping[str, float]) -> LabelledMachine:
    """Return the drawn machine of a file or a built-in name.

    Raises InputError if no drawing module takes it, or as that module does.
    """
    package = find_package(source)
    if package is not None:
        labels = find_drawings()[package]
        return LabelledMachine(package, labels, labels.draw_labelled(source, changes))
    names = ", ".join(sorted(find_drawings()))
    raise InputError(
        f"{source}: there is no such machine with a labelled drawing: it must be a file of one "
        f"({names}), or the name "
        f"of a built-in one"
    )


def list_geometry(package: str) -> list[Meaning]:
    """Return lengths, angles and coordinates of a machine: symbols, then keys and columns without a
    symbol.

    Each name appears once, with its first meaning.
    """
    meanings = [
        meaning
        for meaning in dictionary.collect_meanings()
        if meaning.machine == package and meaning.unit in GEOMETRIC
    ]
    symbol_keys = {_strip_index(meaning.key) for meaning in meanings if meaning.kind == "symbol"}
    unique: dict[str, Meaning] = {}
    for kind in KINDS:
        for meaning in meanings:
            if meaning.kind == kind and (
                kind == "symbol" or not {_strip_index(meaning.key), meaning.name} & symbol_keys
            ):
                unique.setdefault(meaning.name, meaning)
    return list(unique.values())


def explain_omission(labels: Draughtsman, meaning: Meaning) -> str | None:
    """Return the declared reason for a name without a sheet, or None."""
    return next(
        (
            reason
            for reason, patterns in labels.UNDRAWN.items()
            if any(matches_pattern(meaning, p) for p in patterns)
        ),
        None,
    )


def matches_pattern(meaning: Meaning, pattern: str) -> bool:
    """Return whether a pattern matches a name, its source, or the table of its key."""
    marks = meaning.name, meaning.source, f"{(meaning.key or '').partition('.')[0]}."
    return any(fnmatchcase(mark, pattern) for mark in marks)


def _strip_index(key: str | None) -> str:
    """Return a path without the index of an item."""
    return (key or "").partition("[")[0]


def _find_key(meaning: Meaning, numbers: Mapping[str, float], labels: Draughtsman) -> str | None:
    """Return the file's key of a symbol, or None for a derived symbol."""
    if meaning.kind == "column":
        return None
    key = meaning.key or meaning.name
    undrawn = {pattern for patterns in labels.UNDRAWN.values() for pattern in patterns}
    paths = (path for path in numbers if f"{path.partition('.')[0]}." not in undrawn)
    match = next((path for path in paths if f".{path}".endswith(f".{key}")), None)
    return key if match is None and ("." in key or meaning.kind == "file key") else match
