"""Rows and columns as tables of pandas, which is loaded at the first call."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from planter.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


def of(rows: Sequence[Mapping[str, Any]] | Mapping[str, Any]) -> DataFrame:
    """Return a table of pandas from rows, or from columns by name. Raises InputError if pandas is not installed."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise InputError("to_frame needs pandas, which is not installed: pip install 'planter[notebook]'") from None
    return pandas.DataFrame(rows)


def frame(title: str, table: Mapping[str, Any], name: str | None) -> DataFrame:
    """Return the rows at a key of a result, by default the first rows, with groups within a row flattened.

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
    return of([dict(flat(row)) for row in lists[key]])


def flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values of nested tables, the keys of groups joined by points.

    >>> dict(flat({"a": 1, "b": {"c_mm": 2}}))
    {'a': 1, 'b.c_mm': 2}
    """
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _lists(table: Mapping[str, Any]) -> Iterator[tuple[str, list[Mapping[str, Any]]]]:
    for key, value in flat(table):
        if is_rows(value):
            yield key, value


def is_rows(value: object) -> bool:
    """Return whether a value is a list of tables, and not empty."""
    return isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)
