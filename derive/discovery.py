"""Finds modules that offer something: in a package's own folder, in installed packages, in a user's
files.

A module offers ``SYSTEMS`` (a tuple of functions that derive a model each) or ``SYSTEM`` (a model),
``CASE`` (a paper and what it is tried against), ``TARGET`` (a language to write in), and families
of pitch curves by ``@register``. Nothing heavy is imported here.
"""

from __future__ import annotations

import pkgutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

GROUPS = ("derive.papers", "derive.families")
"""Entry points by which an installed package adds what can be derived: a name, and the module that
offers it.
"""
TARGETS = "derive.targets"
"""Entry points by which an installed package adds a language."""


def import_modules(package: ModuleType) -> list[ModuleType]:
    """Every module in a package's folder and in the packages there."""
    infos = pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    return [import_module(name) for name in sorted(module.name for module in infos)]


def find_entry_points(*groups: str) -> dict[str, EntryPoint]:
    """Return the entry points of installed packages in some groups, by name."""
    return {entry.name: entry for group in groups for entry in sorted(entry_points(group=group))}


def list_offers(some: Iterable[ModuleType], name: str) -> list[Any]:
    """List the values of an attribute of all modules that have it, in their order."""
    return [getattr(module, name) for module in some if hasattr(module, name)]


def find_files(path: Path) -> list[Path]:
    """The file itself, or those of a folder whose names do not begin with an underscore."""
    return (
        [path]
        if path.is_file()
        else sorted(p for p in path.glob("*.py") if not p.name.startswith("_"))
    )


@contextmanager
def load_user_modules(path: Path) -> Iterator[list[ModuleType]]:
    """The modules of a file or folder, run by path; while they are used, they may import from their
    folder.
    """
    folder = str(path.parent if path.is_file() else path)
    sys.path.append(folder)
    try:
        yield [_run(file) for file in find_files(path)]
    finally:
        sys.path.remove(folder)


def _run(file: Path) -> ModuleType:
    name = f"derive_own_{file.stem}"
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} cannot be run as Python")
    sys.modules[name] = module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
