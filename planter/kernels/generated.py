"""Finds and loads what was generated, modules and sidecars: ours, of installed packages, or in a user's folder."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from types import ModuleType
from typing import Any

from planter import plugins
from planter.errors import InputError
from planter.files.text import check_regular, parse_json, read_json


@cache
def _package() -> str:
    """In a wheel the generated code is part of this package; in a checkout it stands beside it."""
    return "planter.generated" if importlib.util.find_spec("planter.generated") else "generated"


@cache
def _places() -> dict[str, Traversable]:
    """Packages of generated code with their folders: ours first."""
    own = _package()
    packages = plugins.find_packages()
    found = {f"{packages[room]}.generated": place for room, place in plugins.find_folders("generated").items()}
    return {own: files(own)} | found


@cache
def module(name: str, folder: Path | None = None) -> ModuleType:
    """A generated module, from a folder of one's own if that is given. Raises InputError where there is none."""
    if folder is not None:
        return _from_file(folder.joinpath(*name.split(".")).with_suffix(".py"))
    return importlib.import_module(f"{_holder(name)}.{name}")


def text(name: str) -> str:
    """The text of a generated module. Raises InputError where there is none."""
    return _places()[_holder(name)].joinpath(f"{name}.py").read_text(encoding="utf-8")


@cache
def sidecar(name: str, folder: Path | None = None) -> dict[str, Any]:
    """What is written beside a generated module. Raises InputError where there is none."""
    if folder is not None:
        return read_json(folder / f"{name}.json")
    return parse_json(_places()[_holder(name)].joinpath(f"{name}.json").read_text(encoding="utf-8"), name)


def names(prefix: str = "") -> list[str]:
    """Names of what was generated, sorted: all, or those that begin alike."""
    return sorted({name for place in _places().values() for name in _sidecars(place) if name.startswith(prefix)})


def _sidecars(place: Traversable) -> Iterator[str]:
    return (found.name.removesuffix(".json") for found in place.iterdir() if found.name.endswith(".json"))


def _holder(name: str) -> str:
    """The package that holds a module (of `array.NAME`, the one that holds NAME)."""
    own = name.rpartition(".")[2]
    for package, place in _places().items():
        if place.joinpath(f"{own}.json").is_file():
            return package
    raise InputError(f"{own}: nothing of that name was generated (there is: {', '.join(names())})")


def _from_file(path: Path) -> ModuleType:
    check_regular(path)
    spec = importlib.util.spec_from_file_location(f"generated_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: this is no Python file")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found
