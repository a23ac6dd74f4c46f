"""Rows and columns as tables of pandas, which is loaded when the first is asked for."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from planter.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


def of(rows: Sequence[Mapping[str, Any]] | Mapping[str, Any]) -> DataFrame:
    """A table of pandas from rows, or from columns by their names. Raises InputError where pandas is missing."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise InputError("to_frame needs pandas, which is not installed: pip install 'planter[notebook]'") from None
    return pandas.DataFrame(rows)


def frame(what: str, table: Mapping[str, Any], name: str | None) -> DataFrame:
    """The rows at a key of a result, groups within a row flattened; the first rows there are without a key.

    Raises InputError for a key without rows.
    """
    found = dict(_lists(table))
    if not found:
        raise InputError(f"{what} has no rows to make a table of")
    chosen = next(iter(found)) if name is None else name
    if chosen not in found:
        near = difflib.get_close_matches(chosen, found, n=1)
        hint = f"did you mean {near[0]}?" if near else f"it must be one of {', '.join(found)}"
        raise InputError(f"{what} has no rows {chosen}: {hint}")
    return of([dict(flat(row)) for row in found[chosen]])


def flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Keys and values of nested tables, the keys of groups joined by points.

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
    """Whether a value is a list of tables, and not empty."""
    return isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)
