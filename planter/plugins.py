"""Discovery of the packages of this project, and of installed packages which add machines.

A package may contain a module `commands` (a typer `app`), a folder `examples` of machine files, and
a package `printed` (numbers which papers print, and the formulas that recompute them).
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

from planter import menu

GROUP = "planter.machines"
"""Group of entry points by which an installed package adds a machine: the machine's name, and the
package.
"""


@cache
def find_packages() -> dict[str, str]:
    """Return full package names by short name: the rooms of this project and the packages in them,
    then the installed ones.
    """
    root = Path(__file__).parent
    rooms = _list_packages(root)
    inner = {name: f"{room}.{name}" for room in rooms for name in _list_packages(root / room)}
    internal = {
        name: f"{__package__}.{place}" for name, place in ({r: r for r in rooms} | inner).items()
    }
    return internal | {entry.name: entry.value for entry in sorted(entry_points(group=GROUP))}


def _list_packages(folder: Path) -> list[str]:
    return [module.name for module in pkgutil.iter_modules([str(folder)]) if module.ispkg]


def load_modules(name: str) -> Iterator[ModuleType]:
    """Yield the module (or sub-package) of the given name from every package that contains one.

    An installed package which cannot be loaded is skipped with a warning.
    """
    for package in find_packages().values():
        try:
            if _has_module(package, name):
                yield import_module(f"{package}.{name}")
        except Exception as error:
            if package.startswith(f"{__package__}."):
                raise
            logging.getLogger(__package__).warning(
                "%s is skipped: %s: %s", package, type(error).__name__, error
            )


def name_package(module: ModuleType) -> str:
    """Return the short name of the package that a module from `load_modules` belongs to."""
    return module.__name__.rpartition(".")[0].rpartition(".")[-1]


def _has_module(package: str, name: str) -> bool:
    spec = find_spec(package)
    locations = spec.submodule_search_locations if spec else None
    return bool(locations) and any(
        module.name == name for module in pkgutil.iter_modules(locations)
    )


def list_commands(name: str) -> list[str]:
    """Return the words of the commands and command groups of a package, given by its short name."""
    package = find_packages()[name]
    app = next(
        module.app
        for module in load_modules("commands")
        if module.__name__ == f"{package}.commands"
    )
    commands = [command.name or command.callback.__name__ for command in app.registered_commands]
    names = [*commands, *(group.name for group in app.registered_groups)]
    return [" ".join(menu.current_words([name])) for name in names]


@cache
def find_folders(name: str) -> dict[str, Traversable]:
    """Return the folders of the given name by the short name of the package that contains them."""
    folders = {
        short: resources.files(package).joinpath(name) for short, package in find_packages().items()
    }
    return {short: folder for short, folder in folders.items() if folder.is_dir()}
