"""Names of numbers on pages: the file `names.toml` of a machine's package has them by group and
path.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

from planter.text_files import parse_toml

FILE, COLUMNS = "names.toml", "Columns"
"""Name of the file, and of its group of columns."""
_INDEX = re.compile(r"\[(\d+)\]")


class DisplayName(NamedTuple):
    """The name of a number, its symbol, which may be empty, and the title of its group."""

    name: str
    symbol: str
    group: str


class DisplayNames:
    """Names by paths.

    A path `pose[].x_mm` stands for all indices, whose number, counted from 1, replaces {}.
    """

    def __init__(self, groups: Mapping[str, Mapping[str, Any]]) -> None:
        self._names: dict[str, DisplayName] = {}
        self._order: dict[str, tuple[int, int]] = {}
        for number, (group, entries) in enumerate(groups.items()):
            for index, (path, entry) in enumerate(entries.items()):
                name, symbol = (entry, "") if isinstance(entry, str) else entry
                self._names[path] = DisplayName(name, symbol, group)
                self._order[path] = number, index

    def find(self, path: str) -> DisplayName | None:
        """Return the name of a number, None if the file has none."""
        for pattern, index in _list_patterns(path):
            if pattern in self._names:
                entry = self._names[pattern]
                return entry._replace(
                    name=entry.name.format(index), group=entry.group.format(index)
                )
        return None

    def with_symbols(self) -> dict[str, str]:
        """Return the names of all numbers by their paths, with their symbols in brackets."""
        return {
            path: f"{name} ({symbol})" if symbol else name
            for path, (name, symbol, _) in self._names.items()
        }

    def list_columns(self) -> dict[str, str]:
        """Return the meanings of columns that are neither a symbol's nor a result's, by name."""
        return {path: name for path, (name, _, group) in self._names.items() if group == COLUMNS}

    def meanings(self, paths: Iterable[str]) -> dict[str, str]:
        """Return the names of numbers by their paths, without those that have none."""
        return {path: entry.name for path in paths if (entry := self.find(path)) is not None}

    def position(self, path: str) -> tuple[int, int, int]:
        """Return the position of a path on a page: of its group, its index, and its position in the
        group.

        Paths without a name come last.
        """
        for pattern, index in _list_patterns(path):
            if pattern in self._order:
                group, entry = self._order[pattern]
                return group, index, entry
        return len(self._order), 0, 0


def _list_patterns(path: str) -> Iterator[tuple[str, int]]:
    """Yield a path, and the path for all of its first indices with the number of its index, counted
    from 1.
    """
    yield path, 0
    if match := _INDEX.search(path):
        yield f"{path[: match.start()]}[]{path[match.end() :]}", int(match[1]) + 1


@cache
def load_names(package: str) -> DisplayNames:
    """Return the names of a package's machines."""
    text = resources.files(package).joinpath(FILE).read_text(encoding="utf-8")
    return DisplayNames(parse_toml(text, FILE))
