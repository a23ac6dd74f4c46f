"""Keys of results that carry numbers, by the schemas of the commands and what their records say of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from planter import rooms
from planter.explain.results import Meaning
from planter.files import units
from planter.records import schema

NUMBERS = {"number", "integer"}
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def found(columns: Mapping[tuple[str, str], str]) -> Iterator[Meaning]:
    """Every key that carries a number, once for each record that has it, with the commands that return it.

    `columns` has meanings by room and column, for records that hold columns.
    """
    for module in rooms.brought("results"):
        room = module.__name__.split(".")[-2]
        places: dict[tuple[str, str], list[str]] = {}
        for command, kind in module.COMMANDS.items():
            for key, said in _numbers(command, kind):
                places.setdefault((key, columns.get((room, key), said)), []).append(command)
        for (key, said), commands in places.items():
            source = f"planter {', '.join(dict.fromkeys(commands))} --json"
            yield Meaning(key, "result key", room, units.unit(key), said, source)


def _numbers(command: str, kind: Any) -> Iterator[tuple[str, str]]:
    """Keys of a command's schema that carry numbers, with what their records say of them."""
    whole = schema.schema(command, kind)
    for table in (*whole.get("$defs", {}).values(), whole):
        for key, value in table.get("properties", {}).items():
            if carries_number(value):
                yield key, said_of(key, table["description"])


def carries_number(value: Mapping[str, Any]) -> bool:
    """Whether a key's schema allows a number, by itself or within lists and tables of plain values."""
    if value.get("type") in NUMBERS:
        return True
    inner = [*value.get("anyOf", ()), *value.get("prefixItems", ())]
    inner += [value[name] for name in ("items", "additionalProperties") if isinstance(value.get(name), Mapping)]
    return any(carries_number(one) for one in inner)


def said_of(key: str, text: str) -> str:
    """The sentences of a record's description that name a key, else its first with the key's own words.

    >>> said_of("spread", "A certificate. `spread` is how far starts end apart.")
    '`spread` is how far starts end apart.'
    >>> said_of("mean_N", "Samples of a force: extremes and mean.")
    'mean: samples of a force: extremes and mean'
    """
    sentences = _SENTENCE.split(" ".join(text.split()))
    own = [one for one in sentences if f"`{key}`" in one]
    if own:
        return " ".join(own)
    words = key.removesuffix(units.suffix(key)).replace("_", " ")
    first = sentences[0].rstrip(".")
    return f"{words}: {first[:1].lower()}{first[1:]}"
