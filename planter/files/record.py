"""Results as records: attributes are the keys of the JSON, shown in notebooks as HTML and as tables
of pandas.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Self

from planter import safe_text
from planter.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame
    from pydantic import ConfigDict


def build_frame(rows: Sequence[Mapping[str, Any]] | Mapping[str, Any]) -> DataFrame:
    """Return a table of pandas from rows, or from columns by name.

    Raises InputError if pandas is not installed.
    """
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise InputError(
            "to_frame needs pandas, which is not installed: pip install 'planter[notebook]'"
        ) from None
    return pandas.DataFrame(rows)


def select_rows(title: str, table: Mapping[str, Any], name: str | None) -> DataFrame:
    """Return the rows at a key of a result, by default the first rows, with groups within a row
    flattened.

    Raises InputError if the key has no rows.
    """
    lists = dict(_lists(table))
    if not lists:
        raise InputError(f"{title} has no rows to make a table of")
    key = next(iter(lists)) if name is None else name
    if key not in lists:
        close = difflib.get_close_matches(key, lists, n=1)
        hint = f"did you mean {close[0]}?" if close else f"it must be one of {', '.join(lists)}"
        raise InputError(f"{title} has no rows {key}: {hint}")
    return build_frame([dict(flatten(row)) for row in lists[key]])


def flatten(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values of nested tables, the keys of groups joined by points.

    >>> dict(flatten({"a": 1, "b": {"c_mm": 2}}))
    {'a': 1, 'b.c_mm': 2}
    """
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _lists(table: Mapping[str, Any]) -> Iterator[tuple[str, list[Mapping[str, Any]]]]:
    for key, value in flatten(table):
        if is_rows(value):
            yield key, value


def is_rows(value: object) -> bool:
    """Return whether a value is a list of tables, and not empty."""
    return (
        isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)
    )


MOST_ROWS = 8
"""Maximum number of rows of a list."""


def format_record(title: str, table: Mapping[str, Any]) -> str:
    """Return a result as HTML: its single values, then the first rows of its lists."""
    entries = dict(flatten(table))
    lists = {key: value for key, value in entries.items() if is_rows(value)}
    single = [(key, value) for key, value in entries.items() if key not in lists]
    return "\n".join(
        [
            format_table(title, ("", "value"), single),
            *(_rows(key, rows) for key, rows in lists.items()),
        ]
    )


def format_table(title: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return an HTML table with a caption."""
    top = "".join(f"<th>{_text(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><caption>{_text(title)}</caption><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _rows(key: str, rows: Sequence[Mapping[str, Any]]) -> str:
    first = [dict(flatten(row)) for row in rows[:MOST_ROWS]]
    head = list(dict.fromkeys(name for row in first for name in row))
    title = key if len(rows) <= MOST_ROWS else f"{key}: {MOST_ROWS} of {len(rows)}"
    return format_table(title, head, ([row.get(name) for name in head] for row in first))


def _text(value: object) -> str:
    """Return a value as text of a page: numbers to six digits, nothing hidden, nothing that is
    markup.

    >>> _text(211.3237944), _text([1.0, 2.5]), _text("<b>")
    ('211.324', '1, 2.5', '&lt;b&gt;')
    """
    if value is None:
        return "\N{EN DASH}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value)) or "\N{EN DASH}"
    if isinstance(value, Mapping):
        return ", ".join(f"{_text(key)} {_text(item)}" for key, item in value.items())
    return escape(safe_text.sanitise_line(str(value)))


@dataclass(frozen=True)
class Record:
    """A result, or a part of one.

    A field with the default None is an optional key, left out if it is None. Any other None is
    null.
    """

    __pydantic_config__: ClassVar[ConfigDict] = {"extra": "forbid"}

    def table(self) -> dict[str, Any]:
        """Return the record as in its JSON: dicts, lists, texts, numbers in the units of their
        keys.
        """
        values = ((field, getattr(self, field.name)) for field in fields(self))
        return {
            field.name: _plain(value)
            for field, value in values
            if field.default is MISSING or value is not None
        }

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Self:
        """Build a record from its `table` or its JSON.

        Raises ValueError for other keys or types.
        """
        from pydantic import TypeAdapter

        return TypeAdapter(cls).validate_python(table)

    def to_frame(self, rows: str | None = None) -> DataFrame:
        """Return a list of this record as a table of pandas, columns in the units of their names.

        `rows` is the key of the list, by default the first list of rows. Raises InputError if there
        is no such list, or if pandas is not installed (`pip install planter[notebook]`).
        """
        return select_rows(type(self).__name__, self.table(), rows)

    def _repr_html_(self) -> str:
        """Return the record as HTML for notebooks."""
        title = (type(self).__doc__ or "").partition("\n")[0].partition(";")[0]
        return format_record(title.replace("`", "").rstrip("."), self.table())


class WarningRecord(Record):
    """A warning: its name, the angle [deg] at which its cause begins or is worst, if it has one,
    and its message.

    Each kind of machine declares the fields, because each has its own key for the angle, between
    name and message.
    """

    name: str
    message: str

    def __str__(self) -> str:
        return f"{self.message} ({self.name})"


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.table()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
