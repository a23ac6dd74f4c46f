"""Readable labels for keys, and cells for values, of results."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeVar

from planter.files import units
from planter.paths import last_part
from planter.report.html import Cell, Keys, Table

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


def _clean_cell(value: Any) -> Cell:
    return format_cell(clean_zero(value) if isinstance(value, float) else value)


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
