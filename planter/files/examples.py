"""Files to start from, each by its name: what the rooms of the machines bring in their folder `examples`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Literal

from planter import legible, rooms
from planter.errors import InputError
from planter.files import paths
from planter.files.text import parse_toml, read_text, read_toml

Suffix = Literal[".toml", ".csv"]
SUFFIXES: tuple[Suffix, ...] = (".toml", ".csv")
_EVERYWHERE = {"name", "description", "origin"}
"""Keys that say nothing of what kind of file it is."""
_ALIKE = 0.5
"""Share of common tables from which on a file is taken for one of a kind."""


def names(kind: str | None = None, suffix: Suffix | None = None) -> list[str]:
    """Names of what is built in, sorted: all, or those of one room or one kind of file."""
    return sorted(file.name.rpartition(".")[0] for file in _files(kind) if file.name.endswith(suffix or ""))


def example(name: str, kind: str | None = None, suffix: Suffix | None = None) -> str:
    """The commented text of a built-in file, to start from. Raises InputError for an unknown name."""
    for file in _files(kind):
        if file.name.rpartition(".")[0] == name and file.name.endswith(suffix or ""):
            return file.read_text(encoding="utf-8")
    known = names(kind, suffix)
    similar = paths.close(name, known)
    what = "machine" if suffix == ".toml" else "example"
    if kind and (other := _elsewhere(name)):
        raise InputError(f"{name}: {other}, but it must be one of {', '.join(known)} or the path of a {suffix} file")
    hint = f": did you mean {similar[0]}?" if similar else ""
    raise InputError(
        f"{name or legible.name(name)}: there is no built-in {what} of that name{hint} (built in: {', '.join(known)}; "
        f"anything else must be the path of a {suffix or '.toml or .csv'} file)"
    )


def text(source: str | Path, kind: str | None = None, suffix: Suffix = ".toml") -> str:
    """The text of the file at a path, or of the built-in one of that name, of any room or of one.

    Raises InputError where there is neither, where the file cannot be read, or where it is a CSV file and no TOML file
    by its name, or the other way round.
    """
    if _is_name(source, kind, suffix):
        return example(str(source), kind, suffix)
    other = next((one for one in SUFFIXES if one != suffix and str(source).lower().endswith(one)), None)
    if other is not None:
        known = ", ".join(names(kind, suffix))
        raise InputError(f"{source}: this is a {other} file, but it must be a {suffix} file or built in ({known})")
    return read_text(source)


def belongs(source: str, kind: str, tables: set[str]) -> bool:
    """Whether a source is a built-in machine of a room, or a TOML file with the tables that no other room's have."""
    if source in names(kind, ".toml"):
        return True
    try:
        return set(read_toml(source)) >= tables
    except InputError:
        return False


def resembles(source: str, kind: str) -> bool:
    """Whether a source is a built-in machine of a room, or a TOML file that is more like its than any other's."""
    if source in names(kind, ".toml"):
        return True
    try:
        alike = _alike(read_toml(source))
    except InputError:
        return False
    return 0 < alike[kind] == max(alike.values())


def check_kind(table: Mapping[str, Any], source: str, kind: str) -> None:
    """Raises InputError for the table of a file that belongs to another room, by the names of its tables."""
    alike = _alike(table)
    best = max(alike, key=lambda room: alike[room])
    if best != kind and alike[best] > max(_ALIKE, alike.get(kind, 0)):
        known = ", ".join(names(kind, ".toml"))
        raise InputError(f"{source}: this is a file for {_takers(best)}, but it must be one like {known}")


def _elsewhere(name: str) -> str | None:
    """What a name is that is built in for another command, or as another kind of file."""
    for room in sorted(rooms.folders("examples")):
        for file in _files(room):
            if file.name.rpartition(".")[0] == name:
                return f"this is a built-in {file.name.rpartition('.')[2].upper()} file for {_takers(room)}"
    return None


def _takers(room: str) -> str:
    return f"planter {', '.join(rooms.commands(room))}"


def _alike(table: Mapping[str, Any]) -> dict[str, float]:
    """How much a table is like the files of each room."""
    return {room: _likeness(table, room) for room in rooms.folders("examples")}


def _likeness(table: Mapping[str, Any], room: str) -> float:
    """Largest share of top-level keys that a table has in common with a built-in file of a room."""
    own = set(table) - _EVERYWHERE
    return max((len(own & other) / len(own | other) for other in _tables(room) if own | other), default=0)


@cache
def _tables(room: str) -> list[set[str]]:
    """What the tables of each built-in file of a room are called."""
    builtin = ((file.read_text(encoding="utf-8"), file.name) for file in _files(room) if file.name.endswith(".toml"))
    return [set(parse_toml(content, name)) - _EVERYWHERE for content, name in builtin]


def _is_name(source: str | Path, kind: str | None, suffix: Suffix) -> bool:
    if isinstance(source, Path):
        return False
    if source in names(kind, suffix):
        return True
    return not (source.lower().endswith(SUFFIXES) or Path(source).name != source or os.path.exists(source))


@cache
def _files(kind: str | None) -> list[Traversable]:
    found = rooms.folders("examples")
    folders = [found[kind]] if kind else [found[room] for room in sorted(found)]
    return [file for folder in folders for file in folder.iterdir() if file.name.endswith(SUFFIXES)]
