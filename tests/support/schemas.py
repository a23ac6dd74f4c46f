"""JSON schemas of the results of commands, and the keys that they promise."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from planter.records import schema

PUBLISHED = Path(__file__).with_name("published_keys.json")
"""Keys of the results of each command; `python -m tests.support.schemas` adds new ones, no other may change."""


@cache
def load_schema(command: str) -> Mapping[str, Any]:
    """Return the JSON schema of a command's result, as `planter schema` prints it."""
    return schema.build_schema(command, schema.load_result_types()[command])


def list_keys(command: str) -> list[str]:
    """Return the keys of a command's result with their types, such as `travel[].printed_mm: number`, sorted."""
    root = load_schema(command)
    return sorted({f"{path.lstrip('.')}: {kind}" for path, kind in _walk(root, root, "", ())})


def _walk(node: Any, root: Mapping[str, Any], path: str, parents: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    if node in (True, {}):
        yield path, "any"
    elif reference := node.get("$ref"):
        if reference not in parents:
            yield from _walk(root["$defs"][reference.rpartition("/")[2]], root, path, (*parents, reference))
    elif options := node.get("anyOf", node.get("oneOf")):
        for option in options:
            yield from _walk(option, root, path, parents)
    elif "properties" in node:
        for key, value in node["properties"].items():
            yield from _walk(value, root, f"{path}.{key}" + "?" * (key not in node.get("required", ())), parents)
    elif node.get("type") == "array":
        for items in (*node.get("prefixItems", ()), node.get("items", {})):
            if items is not False:
                yield from _walk(items, root, f"{path}[]", parents)
    elif isinstance(node.get("additionalProperties"), Mapping):
        yield from _walk(node["additionalProperties"], root, f"{path}.*", parents)
    else:
        yield path, json.dumps(node.get("const", node.get("enum", node.get("type", "any")))).strip('"')


def load_published_keys() -> dict[str, list[str]]:
    """Return the committed keys of the results of each command."""
    keys: dict[str, list[str]] = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    return keys


if __name__ == "__main__":
    published = load_published_keys()
    keys = {name: sorted({*published.get(name, ()), *list_keys(name)}) for name in sorted(schema.load_result_types())}
    PUBLISHED.write_text(json.dumps(keys, indent=1) + "\n", encoding="utf-8")
