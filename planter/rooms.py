"""The rooms of the house, found and not listed: what packages of one shape bring, ours and those installed beside us.

A room may bring a module `commands` (a typer `app`), a folder `examples` of files to start from, and a package
`printed` (numbers that papers print, and the formulas that compute them anew).
"""

from __future__ import annotations

import logging
import pkgutil
from collections.abc import Iterator
from functools import cache
from importlib import import_module, resources
from importlib.metadata import entry_points
from importlib.resources.abc import Traversable
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

GROUP = "planter.machines"
"""Entry points by which an installed package adds a room: a name for the machine, and the package."""


@cache
def rooms() -> dict[str, str]:
    """Packages by the name of their room: those of this package, then those that were installed."""
    own = {
        found.name: f"planter.{found.name}"
        for found in pkgutil.iter_modules([str(Path(__file__).parent)])
        if found.ispkg
    }
    return own | {found.name: found.value for found in sorted(entry_points(group=GROUP))}


def brought(name: str) -> Iterator[ModuleType]:
    """The modules or packages of a name in the rooms that have one, room by room.

    An installed package that cannot be loaded costs a warning, and none but its own commands.
    """
    for package in rooms().values():
        try:
            if _has(package, name):
                yield import_module(f"{package}.{name}")
        except Exception as error:
            if package.startswith(f"{__package__}."):
                raise
            logging.getLogger(__package__).warning("%s is left out: %s: %s", package, type(error).__name__, error)


def _has(package: str, name: str) -> bool:
    spec = find_spec(package)
    places = spec.submodule_search_locations if spec else None
    return bool(places) and any(found.name == name for found in pkgutil.iter_modules(places))


def commands(room: str) -> list[str]:
    """Names of the commands and groups of commands that a room brings."""
    package = rooms()[room]
    app = next(module.app for module in brought("commands") if module.__name__ == f"{package}.commands")
    own = [command.name or command.callback.__name__ for command in app.registered_commands]
    return [*own, *(group.name for group in app.registered_groups)]


@cache
def folders(name: str) -> dict[str, Traversable]:
    """The folders of a name in the rooms that have one, by room."""
    places = {room: resources.files(package).joinpath(name) for room, package in rooms().items()}
    return {room: place for room, place in places.items() if place.is_dir()}
