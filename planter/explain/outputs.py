"""Numeric keys of results, with their meanings from the schemas of the commands and the docstrings of records."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from planter import plugins
from planter.explain.results import Meaning
from planter.files import units
from planter.records import schema

NUMBERS = {"number", "integer"}
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def list_result_keys(columns: Mapping[tuple[str, str], str]) -> Iterator[Meaning]:
    """Yield every numeric key, once for each record that has it, with the commands that return it.

    `columns` has meanings by machine and column, for records that contain columns.
    """
    for module in plugins.load_modules("results"):
        room = module.__name__.split(".")[-2]
        places: dict[tuple[str, str], list[str]] = {}
        for command, kind in module.COMMANDS.items():
            for key, meaning in _list_numbers(command, kind):
                places.setdefault((key, columns.get((room, key), meaning)), []).append(command)
        for (key, meaning), commands in places.items():
            source = f"planter {', '.join(dict.fromkeys(commands))} --json"
            yield Meaning(key, "result key", room, units.unit(key), meaning, source)


def _list_numbers(command: str, kind: Any) -> Iterator[tuple[str, str]]:
    """Yield the numeric keys of a command's schema with the descriptions of their records."""
    root = schema.build_schema(command, kind)
    for table in (*root.get("$defs", {}).values(), root):
        for key, value in table.get("properties", {}).items():
            if carries_number(value):
                yield key, find_description(key, table["description"])


def carries_number(value: Mapping[str, Any]) -> bool:
    """Return whether a key's schema allows a number, directly or within lists and tables of plain values."""
    if value.get("type") in NUMBERS:
        return True
    inner = [*value.get("anyOf", ()), *value.get("prefixItems", ())]
    inner += [value[name] for name in ("items", "additionalProperties") if isinstance(value.get(name), Mapping)]
    return any(carries_number(option) for option in inner)


def find_description(key: str, text: str) -> str:
    """Return the sentences of a record's description that name a key, else the first with the words of the key.

    >>> find_description("spread", "A certificate. `spread` is how far starts end apart.")
    '`spread` is how far starts end apart.'
    >>> find_description("mean_N", "Samples of a force: extremes and mean.")
    'mean: samples of a force: extremes and mean'
    """
    sentences = _SENTENCE.split(" ".join(text.split()))
    naming = [sentence for sentence in sentences if f"`{key}`" in sentence]
    if naming:
        return " ".join(naming)
    words = key.removesuffix(units.suffix(key)).replace("_", " ")
    first = sentences[0].rstrip(".")
    return f"{words}: {first[:1].lower()}{first[1:]}"
