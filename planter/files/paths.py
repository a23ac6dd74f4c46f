"""Names of values in nested tables: `mass`, `mass.sun_kg`, `nozzle.hinge_A_mm`, `nozzle.hinge_A_mm[0]`."""

import copy
import difflib
import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

Table = Mapping[str, Any]


def join(location: tuple[str | int, ...]) -> str:
    """Path of a location given as keys and indices: `("cam", "rise", 0)` is `cam.rise[0]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).removeprefix(".")


def last_part(path: str) -> str:
    """What follows the last dot, with its index."""
    return path.rpartition(".")[2]


def walk(table: Table) -> Iterator[tuple[str, Any]]:
    """Every path of a nested table with its value: tables, keys and the items of lists, outer ones first."""
    yield from _walk(table, ())


def _walk(value: Any, location: tuple[str | int, ...]) -> Iterator[tuple[str, Any]]:
    if location:
        yield join(location), value
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _walk(item, (*location, key))
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            yield from _walk(item, (*location, index))


def with_value(table: Table, path: str, value: Any) -> dict[str, Any]:
    """A copy of a table of dicts and lists in which the value at an existing path is replaced."""
    changed = copy.deepcopy(dict(table))
    *inner, last = re.findall(r"[^.\[\]]+", path)
    holder: Any = changed
    for part in inner:
        holder = holder[int(part) if isinstance(holder, list) else part]
    holder[int(last) if isinstance(holder, list) else last] = value
    return changed


def matching(name: str, paths: Collection[str]) -> list[str]:
    """The paths that a name may mean: itself if it is one, else all that end in it."""
    return [name] if name in paths else [path for path in paths if last_part(path) == name]


def close(name: str, paths: Collection[str]) -> list[str]:
    """At most three paths that look like a name which matches none."""
    by_name = {last_part(path): path for path in paths} | {path: path for path in paths}
    similar = difflib.get_close_matches(name, by_name, n=3, cutoff=0.6)
    return list(dict.fromkeys(by_name[found] for found in similar))
