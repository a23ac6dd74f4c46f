"""HTML of results in notebooks: small tables with all texts escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from planter import safe_text
from planter.records import frames

MOST_ROWS = 8
"""Maximum number of rows of a list."""


def record(title: str, table: Mapping[str, Any]) -> str:
    """Return a result as HTML: its single values, then the first rows of its lists."""
    entries = dict(frames.flat(table))
    lists = {key: value for key, value in entries.items() if frames.is_rows(value)}
    single = [(key, value) for key, value in entries.items() if key not in lists]
    return "\n".join([shown(title, ("", "value"), single), *(_rows(key, rows) for key, rows in lists.items())])


def shown(title: str, head: Sequence[str], rows: Iterable[Sequence[object]], figure: str = "") -> str:
    """Return an HTML table with a caption, and the SVG text of a figure below it."""
    top = "".join(f"<th>{_text(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return (
        f"<table><caption>{_text(title)}</caption><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
        f"{figure[figure.find('<svg') :] if figure else ''}"
    )


def _rows(key: str, rows: Sequence[Mapping[str, Any]]) -> str:
    first = [dict(frames.flat(row)) for row in rows[:MOST_ROWS]]
    head = list(dict.fromkeys(name for row in first for name in row))
    title = key if len(rows) <= MOST_ROWS else f"{key}: {MOST_ROWS} of {len(rows)}"
    return shown(title, head, ([row.get(name) for name in head] for row in first))


def _text(value: object) -> str:
    """Return a value as text of a page: numbers to six digits, nothing hidden, nothing that is markup.

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
