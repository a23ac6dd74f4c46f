"""TOML text of tables, with notes as comments after values."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any


def lines(table: Mapping[str, Any], notes: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of the keys outside sections, then of the sections; `notes` by full path become comments."""
    sections = {key: value for key, value in table.items() if _sections(value)}
    yield from (f"{_key(key)} = {_value(value)}" for key, value in table.items() if key not in sections)
    for section, values in sections.items():
        if isinstance(values, Mapping):
            yield from ("", f"[{_key(section)}]", *_section(section, values, notes))
        else:
            for index, entry in enumerate(values):
                yield from ("", f"[[{_key(section)}]]", *_section(f"{section}[{index}]", entry, notes))


def _sections(value: Any) -> bool:
    """Return whether a value is a section, or a list of sections."""
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def _section(path: str, values: Mapping[str, Any], notes: Mapping[str, str]) -> Iterator[str]:
    for key, value in values.items():
        note = notes.get(f"{path}.{key}", "")
        yield f"{_key(key)} = {_value(value)}{f'  # {note}' if note else ''}"


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if plain else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)
