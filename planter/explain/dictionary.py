"""All meanings together: by name, with the figures that draw them, and what is meant where a name is not known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec

from planter import rooms
from planter.errors import InputError
from planter.explain import inputs, outputs, symbols
from planter.explain.results import Explained, KnownNames, Meaning
from planter.files import paths, units


@cache
def every() -> tuple[Meaning, ...]:
    """All meanings: symbols, keys of files, columns, keys of results."""
    named, columns = list(symbols.found()), list(_columns())
    told = {(one.machine, one.key): one.meaning for one in named if one.key}
    figures = dict(_figures())
    found = [
        *named,
        *inputs.found(told),
        *(one for one in columns if (one.machine, one.name) not in told),
        *outputs.found({(one.machine, one.name): one.meaning for one in columns}),
    ]
    listed = [replace(one, figures=figures.get((one.machine, one.key or one.name))) for one in found]
    unique: dict[tuple[str, ...], Meaning] = {}
    for one in listed:
        unique.setdefault((one.kind, one.machine, one.name, one.unit, one.meaning), one)
    return tuple(unique.values())


def explained(name: str) -> Explained:
    """Every meaning of a symbol, key or column; of a file's key its last part is enough.

    Raises InputError for a name that has none, with those that look like it.
    """
    found = [one for one in every() if name in (one.name, one.key)]
    if not found:
        near = paths.close(name, sorted({key for one in every() for key in (one.name, one.key) if key}))
        hint = f"did you mean {' or '.join(near)}?" if near else "`planter explain` lists all names"
        raise InputError(f"NAME = {name} is not a symbol, key or column: {hint}")
    return Explained(name, found)


def explain_in(room: str, key: str) -> Explained:
    """Return every meaning of a symbol, key or column in the machines of a room.

    Raises InputError for a name that has none there, with those that look like it.
    """
    every_meaning = [one for one in every() if one.machine == room]
    meanings = [one for one in every_meaning if key in (one.name, one.key)]
    if not meanings:
        near = paths.close(key, sorted({name for one in every_meaning for name in (one.name, one.key) if name}))
        hint = f"did you mean {' or '.join(near)}?" if near else "`planter explain` lists all names"
        raise InputError(f"KEY = {key} is not a symbol, key or column of {room}: {hint}")
    return Explained(key, meanings)


def names() -> KnownNames:
    """The names that are known, by machine or command."""
    found: dict[str, set[str]] = {}
    for one in every():
        found.setdefault(one.machine, set()).add(one.name)
    return KnownNames({machine: sorted(own) for machine, own in sorted(found.items())})


def of_names(machine: str, wanted: Sequence[str], command: str) -> list[tuple[str, Meaning]]:
    """Names with what each means in a machine, first of all in a command's result; what has no meaning is left out."""
    known: dict[str, Meaning] = {}
    own = [one for one in every() if one.machine == machine]
    for one in sorted(own, key=lambda one: command not in one.source.replace(",", "").split()):
        known.setdefault(one.key or one.name, one)
        known.setdefault(one.name, one)
    return [(name, known[name]) for name in wanted if name in known]


def _columns() -> Iterator[Meaning]:
    """What rooms say of the columns of their CSV files."""
    for module in rooms.brought("columns"):
        room = module.__name__.split(".")[-2]
        for name, (meaning, source) in module.columns().items():
            yield Meaning(name, "column", room, units.unit(name), meaning, source)


def _figures() -> Iterator[tuple[tuple[str, str], list[str]]]:
    """Figures by room and column, as the figures of a room say which columns they draw."""
    found: dict[tuple[str, str], list[str]] = {}
    for room, drawn in _drawn().items():
        for figure, columns in drawn.items():
            for column in columns:
                found.setdefault((room, column), []).append(figure)
    yield from found.items()


def _drawn() -> dict[str, Mapping[str, Sequence[str]]]:
    """`DRAWN` of the modules `report.figures` in the rooms that have one."""
    found = {}
    for report in rooms.brought("report"):
        name = f"{report.__name__}.figures"
        if hasattr(report, "__path__") and find_spec(name) is not None:
            drawn = getattr(import_module(name), "DRAWN", None)
            if drawn is not None:
                found[report.__name__.split(".")[-2]] = drawn
    return found
