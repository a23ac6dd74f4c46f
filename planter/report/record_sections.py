"""A result as sections: single values by their names, groups of them, and tables of rows."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from planter.files.record import Record
from planter.report.html import Block, Section, Table
from planter.report.labels import clean_zero, format_cell, format_label, format_name, tabulate_named
from planter.report.presentation import list_warning_sections

PAGE_COLUMNS = (
    "source",
    "share",
    "hinges_mm",
    "angle_error_deg",
    "multiplicity",
    "outside",
    "lower",
    "upper",
)
"""Columns of rows that only pages have."""


def list_record_sections(
    record: Record, names: Mapping[str, str], omit: Collection[str] = ()
) -> Iterator[Section]:
    """Yield the sections of a result: warnings, single values and groups, then each list of rows.

    `names` has the names of keys, and those of groups and lists under `group.KEY`; keys without a
    name have their words. Rows that hold rows themselves have a section each.
    """
    yield from list_warning_sections(getattr(record, "warnings", None) or [])
    table = record.table()
    entries = {key: value for key, value in table.items() if key not in (*omit, "warnings")}
    yield Section("Results", list(_list_blocks(entries, names)))
    for key, rows in entries.items():
        if not is_table(rows):
            continue
        title = name_group(key, names)
        if any(is_nested(value) for value in rows[0].values()):
            for number, row in enumerate(rows, 1):
                blocks = [*_list_blocks(row, names), *_list_tables(row, names)]
                yield Section(f"{title} {number}", blocks)
        else:
            yield Section(title, [tabulate_record_rows(rows, names)])


def _list_blocks(table: Mapping[str, Any], names: Mapping[str, str]) -> Iterator[Block]:
    """Yield the single values of a record, then each group with its tables."""
    single = {key: value for key, value in table.items() if not is_nested(value) and value != []}
    if single:
        yield _tabulate_values(single, names)
    for key, group in table.items():
        if isinstance(group, Mapping):
            inner = {name: value for name, value in group.items() if not is_nested(value)}
            yield _tabulate_values(inner, names, name_group(key, names))
            yield from _list_tables(group, names)


def _list_tables(table: Mapping[str, Any], names: Mapping[str, str]) -> Iterator[Block]:
    for key, rows in table.items():
        if is_table(rows):
            yield tabulate_record_rows(rows, names, name_group(key, names))


def _tabulate_values(
    values: Mapping[str, Any], names: Mapping[str, str], caption: str = ""
) -> Table:
    return tabulate_named({key: _clean(v) for key, v in values.items()}, names, caption)


def tabulate_record_rows(
    rows: Sequence[Mapping[str, Any]], names: Mapping[str, str], caption: str = ""
) -> Table:
    """Return a table of rows with a column for each key."""
    heads = [_name_column(key, names) for key in rows[0]]
    cells = [[format_cell(_clean(row.get(key))) for key in rows[0]] for row in rows]
    if "name" in rows[0]:  # a design value is named as on the page
        column = list(rows[0]).index("name")
        for row in cells:
            row[column] = names.get(str(row[column]), row[column])
    page_columns = [_name_column(key, names) for key in PAGE_COLUMNS]
    return Table(heads, cells, caption, page_columns)


def _name_column(key: str, names: Mapping[str, str]) -> str:
    return format_label(key, names[key]) if key in names else _capitalise(format_label(key))


def name_group(key: str, names: Mapping[str, str]) -> str:
    """Return the title of a group or list."""
    return names.get(f"group.{key}", _capitalise(format_name(key)))


def is_table(value: object) -> bool:
    """Return whether a value is a list of rows."""
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def is_nested(value: object) -> bool:
    """Return whether a value is a group or a list of rows."""
    return isinstance(value, Mapping) or is_table(value)


def _capitalise(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def _clean(value: Any) -> Any:
    return clean_zero(value) if isinstance(value, float) else value
