"""What comments above a table say about its columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from planter.errors import InputError
from planter.files import csv_rows

_ENTRY = re.compile(r"(factor|response)\s+([^:]+?)\s*:\s*([^=]*?)\s*(?:=\s*(.*))?")


@dataclass(frozen=True)
class Entry:
    """One comment: the line, what it is about, its text, the values of the levels."""

    line: int
    role: str
    label: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class Legend:
    """The comments of a table that are about columns."""

    source: str
    entries: Mapping[str, Entry]

    @classmethod
    def of(cls, table: csv_rows.Table) -> Legend:
        found: dict[str, Entry] = {}
        for line, comment in table.comments:
            if match := _ENTRY.fullmatch(comment):
                role, name, label, values = match.groups()
                split = tuple(value.strip() for value in values.split(",")) if values else ()
                found[name] = Entry(line, role, label, split)
        return cls(table.source, found)

    def check(self, roles: Mapping[str, str]) -> None:
        """Raises InputError for a comment about a column that is not there or is something else."""
        for name, entry in self.entries.items():
            if roles.get(name) != entry.role:
                allowed = ", ".join(column for column, role in roles.items() if role == entry.role)
                raise InputError(
                    f"{self.source}: line {entry.line} explains the {entry.role} {name}, but there is none, "
                    f"it must be one of {allowed}"
                )

    def label(self, name: str) -> str:
        """What a column means; its name if nothing says."""
        return (self.entries[name].label if name in self.entries else "") or name

    def ordered(self, name: str, levels: list[Any]) -> tuple[list[Any], tuple[float, ...] | None]:
        """The levels in their order, and what they stand for if they are numbers.

        Raises InputError for values that do not fit the levels.
        """
        entry = self.entries.get(name)
        if entry is None or not entry.values:
            return levels, None
        words = isinstance(levels[0], str)
        if words and sorted(entry.values) == sorted(levels):
            return list(entry.values), None
        numbers = [float(value) for value in entry.values if csv_rows.finite(value)]
        if not words and len(numbers) == len(entry.values) == len(set(numbers)) == len(levels):
            return levels, tuple(numbers)
        given, found = ", ".join(entry.values), ", ".join(map(str, levels))
        raise InputError(
            f"{self.source}: line {entry.line} gives {name} the values {given}, but the runs have the levels {found}: "
            f"{'these must stand there, in any order' if words else 'there must be one number for each'}"
        )
