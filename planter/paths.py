"""Names of values in nested tables: `mass`, `mass.sun_kg`, `nozzle.hinge_A_mm`,
`nozzle.hinge_A_mm[0]`.
"""

import copy
import difflib
from collections.abc import Collection, Iterator, Mapping
from itertools import islice
from typing import Any

Table = Mapping[str, Any]
Location = tuple[str | int, ...]
"""Location of a value: keys and indices, as `("cam", "rise", 0)`."""

_COMPARED, _LONGEST = 2000, 80
"""Maximum number and length of names that are compared with a misspelt one."""


def join_location(location: Location) -> str:
    """Return the path of a location: `("cam", "rise", 0)` is `cam.rise[0]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).removeprefix(".")


def last_part(path: str) -> str:
    """Return the part after the last dot, with its index."""
    return path.rpartition(".")[2]


def walk_paths(table: Table) -> Iterator[tuple[str, Any]]:
    """Yield every path of a nested table with its value: tables, keys and the items of lists, outer
    ones first.
    """
    return ((join_location(location), value) for location, value in walk_locations(table))


def walk_locations(value: Any, location: Location = ()) -> Iterator[tuple[Location, Any]]:
    """Yield every location below a value with its content, outer ones first."""
    items: Collection[tuple[str | int, Any]] = ()
    if isinstance(value, Mapping):
        items = value.items()
    elif isinstance(value, list | tuple):
        items = list(enumerate(value))
    for part, item in items:
        yield (*location, part), item
        yield from walk_locations(item, (*location, part))


def with_values(table: Table, values: Mapping[Location, Any]) -> dict[str, Any]:
    """Return a copy of a table of dicts and lists in which the values at existing locations are
    replaced.
    """
    changed = copy.deepcopy(dict(table))
    for (*inner, last), value in values.items():
        holder: Any = changed
        for part in inner:
            holder = holder[part]
        holder[last] = value
    return changed


class Names:
    """Names of the values at some paths: the full path, or its last part."""

    def __init__(self, paths: Collection[str]) -> None:
        self._paths = paths
        self._ends: dict[str, list[str]] = {}
        for path in paths:
            self._ends.setdefault(last_part(path), []).append(path)

    def candidates(self, name: str) -> list[str]:
        """Return the paths that a name may mean: itself, else those that end in it, bounds only
        without others.
        """
        matches = [name] if name in self._paths else self._ends.get(name, [])
        return [path for path in matches if not path.startswith("bounds.")] or matches

    def complaint(self, name: str) -> str:
        """Return the message for a name that means no path, or several."""
        candidates = self.candidates(name)
        if candidates:
            return f"it fits several values, name one of {', '.join(candidates)}"
        first = next(iter(self._paths), "section.length_mm")
        return (
            f"the file has no such value, "
            f"{suggest_names(name, self._paths, f'names look like {first}')}"
        )


def suggest_names(name: str, allowed: Collection[str], otherwise: str = "") -> str:
    """Return a hint for an unknown name: similar allowed names, else `otherwise`, by default all
    allowed names.

    >>> suggest_names("ellips", ["ellipse", "sine"]), suggest_names("x", ["ellipse", "sine"])
    ('did you mean ellipse?', 'it must be one of ellipse, sine')
    """
    similar = find_similar(name, allowed)
    if similar:
        return f"did you mean {' or '.join(similar)}?"
    return otherwise or f"it must be one of {', '.join(allowed)}"


def find_similar(name: str, paths: Collection[str]) -> list[str]:
    """Return at most three paths that are similar to a name."""
    if len(name) > _LONGEST:
        return []
    compared = [path for path in islice(paths, _COMPARED) if len(path) <= _LONGEST]
    by_name = {last_part(path): path for path in compared} | {path: path for path in compared}
    similar = difflib.get_close_matches(name, by_name, n=3, cutoff=0.6)
    return list(dict.fromkeys(by_name[match] for match in similar))
