"""Readable labels for keys, and cells for values, of results."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from planter.files import units
from planter.paths import last_part
from planter.report.html import Cell, Keys, Table
from planter.text_files import parse_toml

if TYPE_CHECKING:
    from planter.kernels import Array


V = TypeVar("V", bound="Array | float | None")

ROUNDING = 1e-9
"""Magnitude below which a computed value is shown as zero."""


def count_things(number: int, thing: str, things: str = "") -> str:
    """Return a number of things in words: `things` is their plural, unless it ends in s.

    >>> count_things(1, "complex pair"), count_things(0, "complex pair"), count_things(2, "dwell", "dwells")
    ('1 complex pair', '0 complex pairs', '2 dwells')
    """
    return f"{number} {thing if number == 1 else things or f'{thing}s'}"


def format_label(key: str, name: str | None = None) -> str:
    """Return a key, or its `name`, as a label with its unit.

    >>> format_label("variance_N2"), format_label("start_objective"), format_label("seconds")
    ('variance / N2', 'start objective', 'seconds')
    """
    unit = units.display_unit(key)
    words = name or format_name(key)
    return f"{words} / {unit}" if unit else words


def format_name(key: str) -> str:
    """Return a key as words without its unit; symbols such as F_A1x keep their underscore."""
    unit = units.display_unit(key)
    if not unit:
        return separate_words(key)
    stem = key
    while units.display_unit(key[len(stem) :]) != unit:
        stem = stem.rpartition("_")[0]
    return separate_words(stem)


def label_axis(path: str, meanings: Mapping[str, str], width: int = 30) -> str:
    """Return the label of an axis for a number or a result: its meaning, or the words of its key,
    with its unit.

    Lines of a meaning have at most `width` characters.

    >>> label_axis("mass.sun_kg", {"mass.sun_kg": "mass of the sun"}), label_axis("mass.sun_kg", {})
    ('mass of the sun / kg', 'sun / kg')
    """
    return format_label(last_part(path), textwrap.fill(meanings.get(path, ""), width) or None)


def separate_words(key: str) -> str:
    """Return a key as words, unless it contains a symbol."""
    return key if any(c.isupper() for c in key) else key.replace("_", " ")


def format_cell(value: Any) -> Cell:
    """Return a value as one cell of a table.

    >>> format_cell([0.1 + 0.2, 2]), format_cell({"lower": 1.0}), format_cell([])
    ('0.3, 2', 'lower 1', None)
    """
    if isinstance(value, list | tuple):
        return ", ".join(_in_list(item) for item in value) or None
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_in_list(item)}" for key, item in value.items())
    cell: Cell = value
    return cell


def _in_list(value: Any) -> str:
    cell = format_cell(value)
    return f"{cell:.6g}" if isinstance(cell, float) else str(cell)


def list_values(values: Mapping[str, Any]) -> Keys:
    """Return the single values of a result under their labels, those of a group behind its name;
    lists are left out.
    """
    pairs: dict[str, Cell] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            unit = f" / {units.display_unit(key)}" if units.display_unit(key) else ""
            pairs |= {
                f"{format_name(key)}: {item}{unit}": cell
                for item, cell in list_values(value).pairs.items()
            }
        elif not isinstance(value, list | tuple):
            pairs[format_label(key)] = value
    return Keys(pairs)


NAMED_HEAD = ("quantity", "value", "unit", "key")
"""Columns of a table of named values; the key is that of JSON."""


def tabulate_named(values: Mapping[str, Any], names: Mapping[str, str], caption: str = "") -> Table:
    """Return values by their names, with unit and key; a key without a name has its words.

    A name that ends in a stroke and a unit, or in a stroke alone, replaces the unit of the key.
    """
    rows = []
    for key, value in values.items():
        name, stroke, unit = names.get(key, format_name(key)).partition(" /")
        rows.append(
            (name, format_cell(value), unit.strip() if stroke else units.display_unit(key), key)
        )
    return Table(NAMED_HEAD, rows, caption)


def tabulate_records(
    records: Iterable[Any],
    columns: Mapping[str, str | Callable[[Any], Any]],
    caption: str = "",
    page_columns: Collection[str] = (),
) -> Table:
    """Return a table with a row for each record: a column is an attribute, by its path, or a
    function of the record.
    """
    readers = [attrgetter(each) if isinstance(each, str) else each for each in columns.values()]
    rows = [[format_cell(read(record)) for read in readers] for record in records]
    return Table(list(columns), rows, caption, page_columns)


def tabulate_angles(rows: Sequence[Mapping[str, Any]], angle: str) -> Table:
    """Return a table of quantities at the angles [deg] that `rows` have under the key `angle`, one
    column each.
    """
    head = ("quantity", *(f"at {row[angle]:.6g} deg" for row in rows))
    return Table(
        head,
        [
            (format_label(key), *(format_cell(row[key]) for row in rows))
            for key in rows[0]
            if key != angle
        ],
    )


def clean_zero(value: V) -> V:
    """Return a value, or an array of values, with rounding errors replaced by zero.

    >>> clean_zero(-1.8e-14), clean_zero(1.8e-6), clean_zero(None)
    (0.0, 1.8e-06, None)
    """
    # Adding zero takes the sign from a negative zero.
    number: Any = value
    cleaned: V = value if number is None else number * (abs(number) >= ROUNDING) + 0.0
    return cleaned


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
